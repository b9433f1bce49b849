"""The simplices between seeds and the faces of their cells: tetrahedra, in the plane triangles."""

from __future__ import annotations

import itertools
from fractions import Fraction
from typing import TYPE_CHECKING, Iterable, Iterator, List, Optional, Tuple

import numpy as np

from ..export.geometry import mesh_of, triangles
from ..pairs import edges_of

if TYPE_CHECKING:
    from .._state import SeedCells
    from .._types import BoolArray, Float64Array, Int64Array

_FACES = 2048  # in a block, so that its arrays stay in the cache
_TRIANGLES = 4 * _FACES  # in a block of pieces


def _reduced(edges: Float64Array) -> Float64Array:
    """Returns a basis of the lattice of up to three rows, in which no sum or difference is shorter. Each is rounded once."""
    basis = [[Fraction(x) for x in row] for row in edges.tolist()]

    def dot(a: List[Fraction], b: List[Fraction]) -> Fraction:
        return sum((x * y for x, y in zip(a, b)), Fraction())

    def moved(k: int, by: Iterable[int]) -> List[Fraction]:
        return [sum((n * row[i] for n, row in zip(by, basis)), basis[k][i]) for i in range(len(basis[k]))]

    changed = True
    while changed:
        changed = False
        for k in range(len(basis)):
            for j in range(len(basis)):  # one at a time, as Lagrange
                by = [0] * len(basis)
                if j != k:
                    by[j] = -round(dot(basis[k], basis[j]) / dot(basis[j], basis[j]))
                changed |= any(by)
                basis[k] = moved(k, by)
            choices = [by for by in itertools.product((-1, 0, 1), repeat=len(basis)) if by[k] == 0]
            shortest = min((moved(k, by) for by in choices), key=lambda row: dot(row, row))
            if dot(shortest, shortest) < dot(basis[k], basis[k]):
                basis[k], changed = shortest, True
    return np.array([[float(x) for x in row] for row in basis])


def _to_nearest(t: SeedCells, vectors: Float64Array) -> Float64Array:
    """Returns the multiples of the periodic edges that are nearest to these vectors (M, 3)."""
    edges = _reduced(edges_of(t)[np.asarray(t.periodic)])
    inverse = np.linalg.pinv(edges)
    first = np.round(vectors @ inverse)
    rest = vectors - first @ edges
    best, distance = first, np.linalg.norm(rest, axis=1)
    # A nearer multiple differs by at most twice the largest distance.
    reach = np.floor(2 * distance.max(initial=0) * np.linalg.norm(inverse, axis=0)).astype(int)
    for more in itertools.product(*(range(-n, n + 1) for n in reach)):
        other = np.linalg.norm(rest - more @ edges, axis=1)
        nearer = other < distance
        best, distance = np.where(nearer[:, None], first + more, best), np.where(nearer, other, distance)
    multiples: Float64Array = best @ edges
    return multiples


def _surfaces(
    t: SeedCells, caller: str, chosen: Optional[BoolArray] = None, may_skip: bool = False, open: Optional[str] = None
) -> Tuple[Float64Array, Iterator[Tuple[Int64Array, Int64Array]]]:
    """Returns vertices (V, 3) and blocks of the cells (M,) and vertices (M, 3) of triangles, by cell, of chosen faces.

    In the plane edges (M, 2) between vertices (V, 2) take the place of triangles. The triangles of a cell enclose it, in a mesh its part inside. There faces cannot be chosen.
    ``may_skip``, ``open``: as for :func:`mesh_of`.
    """
    if t.in_mesh:
        p = t.pieces()  # type: ignore[attr-defined]
        vertices = p.vertices
        if any(t.periodic):  # move each piece to its seed
            move = _to_nearest(t, t.wrapped_points[p.cells] - p.centroids)
            vertices = vertices + np.repeat(move, np.diff(p.vertex_offsets), axis=0)
        cells, ids = p.cells[p._piece_of], p._corners
        blocks = (slice(first, first + _TRIANGLES) for first in range(0, len(ids), _TRIANGLES))
        return vertices, ((cells[block], ids[block]) for block in blocks)
    mesh = mesh_of(t, caller, planar=True, may_skip=may_skip, open=open)
    faces = np.arange(len(mesh.offsets) - 1) if chosen is None else np.flatnonzero(chosen)
    cell_of_face = mesh.cell_of_face
    if t.planar:
        edges = mesh.loops.reshape(-1, 2)
        parts = (faces[first : first + _TRIANGLES] for first in range(0, len(faces), _TRIANGLES))
        return mesh.vertices, ((cell_of_face[part], edges[part]) for part in parts)
    fans = (triangles(mesh, faces[first : first + _FACES]) for first in range(0, len(faces), _FACES))
    return mesh.vertices, ((cell_of_face[face], ids) for ids, face in fans)


def simplices(
    t: SeedCells,
    places: Float64Array,
    caller: str,
    chosen: Optional[BoolArray] = None,
    may_skip: bool = False,
    open: Optional[str] = None,
) -> Iterator[Tuple[Int64Array, Float64Array, Float64Array]]:
    """Yields, block by block, the simplices between the triangles or edges of chosen faces and the seeds.

    A block is: cells (M,), ascending; x, y, z of three corners relative to the seed (3, 3, M), in the plane (2, 2, M); and
    six times the volumes, or twice the areas (M,), negative where a triangle or edge faces the seed.
    """
    vertices, blocks = _surfaces(t, caller, chosen, may_skip, open)
    vertices, seeds = np.ascontiguousarray(vertices.T), np.ascontiguousarray(places.T)
    for cell, ids in blocks:
        corners = vertices.take(np.ascontiguousarray(ids.T), axis=1)
        corners -= seeds.take(cell, axis=1)[:, None]
        if t.planar:
            (ax, bx), (ay, by) = corners
            yield cell, corners, ax * by - bx * ay
            continue
        (ax, bx, cx), (ay, by, cy), (az, bz, cz) = corners
        yield cell, corners, ax * (by * cz - bz * cy) + ay * (bz * cx - bx * cz) + az * (bx * cy - by * cx)
