"""Mass, centroid and energy of cells, summed over simplices between seeds and faces: tetrahedra, in the plane triangles."""

from __future__ import annotations

import itertools
from fractions import Fraction
from math import factorial
from typing import TYPE_CHECKING, Any, Callable, Iterable, Iterator, List, Optional, Tuple

import numpy as np

from .._arguments import shown
from .._input import as_float64_or_float32
from ..export.geometry import mesh_of, triangles
from ..pairs import edges_of

if TYPE_CHECKING:
    import numpy.typing as npt

    from ..tessellation import Tessellation

    BoolArray = npt.NDArray[np.bool_]
    Float64Array = npt.NDArray[np.float64]
    Int64Array = npt.NDArray[np.int64]

#: A function of (K, 3) or (K, 2) points that returns (K,) finite numbers >= 0.
Density = Callable[[Any], Any]

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


def _to_nearest(t: Tessellation, vectors: Float64Array) -> Float64Array:
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
    t: Tessellation, caller: str, chosen: Optional[BoolArray] = None
) -> Tuple[Float64Array, Iterator[Tuple[Int64Array, Int64Array]]]:
    """Returns vertices (V, 3) and blocks of the cells (M,) and vertices (M, 3) of triangles, by cell, of chosen faces.

    In the plane edges (M, 2) between vertices (V, 2) take the place of triangles. The triangles of a cell enclose it, in a mesh its part inside. There faces cannot be chosen.
    """
    if t.in_mesh:
        p = t.pieces()
        sizes = np.diff(p.triangle_offsets)
        vertices = p.vertices
        if any(t.periodic):  # move each piece to its seed
            move = _to_nearest(t, t.wrapped_points[p.cells] - p.centroids)
            vertices = vertices + np.repeat(move, np.diff(p.vertex_offsets), axis=0)
        cells = np.repeat(p.cells, sizes)
        ids = p.triangles + np.repeat(p.vertex_offsets[:-1], sizes)[:, None]
        blocks = (slice(first, first + _TRIANGLES) for first in range(0, len(ids), _TRIANGLES))
        return vertices, ((cells[block], ids[block]) for block in blocks)
    mesh = mesh_of(t, caller, planar=True)
    faces = np.arange(len(mesh.offsets) - 1) if chosen is None else np.flatnonzero(chosen)
    cell_of_face = mesh.cell_of_face
    if t.planar:
        edges = mesh.loops.reshape(-1, 2)
        parts = (faces[first : first + _TRIANGLES] for first in range(0, len(faces), _TRIANGLES))
        return mesh.vertices, ((cell_of_face[part], edges[part]) for part in parts)
    fans = (triangles(mesh, faces[first : first + _FACES]) for first in range(0, len(faces), _FACES))
    return mesh.vertices, ((cell_of_face[face], ids) for ids, face in fans)


def _rule(dimensions: int) -> Tuple[float, float]:
    """Returns the barycentric coordinates of the nodes of a simplex: near one corner, and far from all others.

    The nodes have equal weights, one for each corner. Sums over them are exact for polynomials of degree 2 (Hammer, Stroud
    1956).
    """
    n = dimensions
    far = (n + 2 - (n + 2) ** 0.5) / ((n + 1) * (n + 2))
    return 1 - n * far, far


def _simplices(
    t: Tessellation, places: Float64Array, caller: str, chosen: Optional[BoolArray] = None
) -> Iterator[Tuple[Int64Array, Float64Array, Float64Array]]:
    """Yields, block by block, the simplices between the triangles or edges of chosen faces and the seeds.

    A block is: cells (M,), ascending; x, y, z of three corners relative to the seed (3, 3, M), in the plane (2, 2, M); and
    six times the volumes, or twice the areas (M,), negative where a triangle or edge faces the seed.
    """
    vertices, blocks = _surfaces(t, caller, chosen)
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


def uniform_energy(t: Tessellation, places: Float64Array, caller: str = "lloyd()") -> float:
    """Returns the sum of the integrals of |x - p|^2 over the cells of seeds p, which are at ``places`` in the domain.

    For a tetrahedron with corners at the seed and at a, b, c relative to it, the integral is
    volume / 20 (|a|^2 + |b|^2 + |c|^2 + |a + b + c|^2). It is negative for a face that faces the seed, as in a power
    diagram or a mesh. In the plane it is area / 12 (|a|^2 + |b|^2 + |a + b|^2). In a Voronoi diagram the contributions of a face to its two cells are equal by symmetry, so one of them is
    computed and counted twice.
    """
    twice: Optional[BoolArray] = None
    once: Optional[BoolArray] = None
    if not t.in_mesh and t.weights is None:
        cell, neighbor = mesh_of(t, caller, planar=True).cell_of_face, t.neighbors.indices
        twice, once = cell < neighbor, (neighbor < 0) | (cell == neighbor)
    energy = 0.0
    for times, chosen in ((2, twice), (1, once)):
        if times == 2 and chosen is None:
            continue
        for _, corners, size in _simplices(t, places, caller, chosen):
            total = corners.sum(axis=1)
            squares = np.einsum("kcm,kcm->m", corners, corners) + np.einsum("km,km->m", total, total)
            energy += times * float(size @ squares)
    return energy / (24 if t.planar else 120)


def transport_cost(tessellation: Tessellation) -> float:
    """Returns the cost of moving the uniform density of the domain to the seeds: the sum of the integrals of |x - p|^2.

    Each cell goes to its seed p. In a power diagram no other plan that gives each seed the volume of its cell costs less,
    so after :func:`fit_volumes` this is the squared Wasserstein distance. It has a closed form. Needs "faces" in want, but
    not in a mesh. After ``min_face`` or ``min_area`` it tessellates again: cells need their small faces too.

    >>> print(f"{vt.transport_cost(t):.4f}")
    0.0176
    """
    from ..tessellation import Tessellation

    t = tessellation
    if not isinstance(t, Tessellation):
        raise TypeError(f"tessellation is {shown(t)}: give the result of tessellate()")
    if t.least_face > 0:
        mesh_of(t, "transport_cost()", planar=True)
        t = t._with_all_faces()
    return uniform_energy(t, t.wrapped_points, "transport_cost()")


def _values(t: Tessellation, density: Density, points: Float64Array) -> Float64Array:
    """Returns the density at these points, which are wrapped into a periodic domain first."""
    if any(t.periodic):
        edges = edges_of(t)
        corner = t.box[0] if t.origin is None else t.origin
        turns = np.floor((points - corner) @ np.linalg.inv(edges))
        points = points - np.where(t.periodic, turns, 0) @ edges
    values = as_float64_or_float32(density(points), "the answer of density").astype(np.float64, copy=False)
    if values.shape != (len(points),):
        raise ValueError(
            f"density returned an array of shape {values.shape} for {len(points)} points: it must be ({len(points)},)"
        )
    wrong = np.flatnonzero(~((values >= 0) & (values < np.inf)))
    if len(wrong):
        place = ", ".join(map(str, points[wrong[0]]))
        raise ValueError(f"density is {values[wrong[0]]} at ({place}): it must be finite and not negative")
    return values


def weighted_centroids(t: Tessellation, places: Float64Array, density: Density) -> Tuple[Float64Array, float]:
    """Returns centroids relative to the seeds (N, 3), in the plane (N, 2), NaN without mass, and the energy, by the rule above."""
    dimensions = places.shape[1]
    near, far = _rule(dimensions)
    nodes_of = dimensions + 1  # a simplex
    mass, moment, energy = np.zeros(len(t)), np.zeros((dimensions, len(t))), 0.0
    for cell, corners, size in _simplices(t, places, "lloyd()"):
        if len(cell) == 0:
            continue
        nodes = np.repeat(far * corners.sum(axis=1)[:, None], nodes_of, axis=1)  # x, y, z of each
        nodes[:, :dimensions] += (near - far) * corners
        at = nodes.reshape(dimensions, -1) + np.tile(places.T[:, cell], nodes_of)
        weight = _values(t, density, np.ascontiguousarray(at.T)).reshape(nodes_of, -1) * (size / factorial(nodes_of))
        first, last = cell[0], cell[-1] + 1
        mass[first:last] += np.bincount(cell - first, weight.sum(axis=0))
        for axis in range(dimensions):
            moment[axis, first:last] += np.bincount(cell - first, np.einsum("nm,nm->m", weight, nodes[axis]))
        energy += float(np.einsum("nm,knm,knm->", weight, nodes, nodes))
    centroid = np.divide(moment, mass, out=np.full_like(moment, np.nan), where=mass > 0)
    return centroid.T, energy
