"""Mass, centroid and energy of cells, summed over tetrahedra between seeds and faces."""

from __future__ import annotations

import itertools
from typing import TYPE_CHECKING, Any, Callable, Iterator, Optional, Tuple

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

#: A function of (K, 3) points that returns (K,) finite numbers >= 0.
Density = Callable[[Any], Any]

# The rule of Hammer and Stroud (1956) for a tetrahedron, exact for polynomials of degree 2. It has four points of equal
# weight. Their barycentric coordinates are _NEAR for one corner and _FAR for the three others.
_NEAR, _FAR = (5 + 3 * 5**0.5) / 20, (5 - 5**0.5) / 20

_FACES = 2048  # in a block, so that its arrays stay in the cache
_TRIANGLES = 4 * _FACES  # in a block of pieces


def _to_nearest(t: Tessellation, vectors: Float64Array) -> Float64Array:
    """Returns the multiples of the periodic edges that are nearest to these vectors (M, 3)."""
    edges = edges_of(t)
    inverse = np.where(t.periodic, np.linalg.inv(edges), 0)
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

    The triangles of a cell enclose it, in a mesh its part inside. There faces cannot be chosen.
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
    mesh = mesh_of(t, caller)
    faces = np.arange(len(mesh.offsets) - 1) if chosen is None else np.flatnonzero(chosen)
    cell_of_face = mesh.cell_of_face
    fans = (triangles(mesh, faces[first : first + _FACES]) for first in range(0, len(faces), _FACES))
    return mesh.vertices, ((cell_of_face[face], ids) for ids, face in fans)


def _tetrahedra(
    t: Tessellation, places: Float64Array, caller: str, chosen: Optional[BoolArray] = None
) -> Iterator[Tuple[Int64Array, Float64Array, Float64Array]]:
    """Yields, block by block, the tetrahedra between the triangles of chosen faces and the seeds.

    A block is: cells (M,), ascending; x, y, z of three corners relative to the seed (3, 3, M); and six times the volumes
    (M,), negative where a triangle faces the seed.
    """
    vertices, blocks = _surfaces(t, caller, chosen)
    vertices, seeds = np.ascontiguousarray(vertices.T), np.ascontiguousarray(places.T)
    for cell, ids in blocks:
        corners = vertices.take(np.ascontiguousarray(ids.T), axis=1)
        corners -= seeds.take(cell, axis=1)[:, None]
        (ax, bx, cx), (ay, by, cy), (az, bz, cz) = corners
        yield cell, corners, ax * (by * cz - bz * cy) + ay * (bz * cx - bx * cz) + az * (bx * cy - by * cx)


def uniform_energy(t: Tessellation, places: Float64Array, caller: str = "lloyd()") -> float:
    """Returns the sum of the integrals of |x - p|^2 over the cells of seeds p, which are at ``places`` in the domain.

    For a tetrahedron with corners at the seed and at a, b, c relative to it, the integral is
    volume / 20 (|a|^2 + |b|^2 + |c|^2 + |a + b + c|^2). It is negative for a face that faces the seed, as in a power
    diagram or a mesh. In a Voronoi diagram the contributions of a face to its two cells are equal by symmetry, so one of them is
    computed and counted twice.
    """
    twice: Optional[BoolArray] = None
    once: Optional[BoolArray] = None
    if not t.in_mesh and t.weights is None:
        cell, neighbor = mesh_of(t, caller).cell_of_face, t.neighbors.indices
        twice, once = cell < neighbor, (neighbor < 0) | (cell == neighbor)
    energy = 0.0
    for times, chosen in ((2, twice), (1, once)):
        if times == 2 and chosen is None:
            continue
        for _, corners, size in _tetrahedra(t, places, caller, chosen):
            total = corners.sum(axis=1)
            squares = np.einsum("kcm,kcm->m", corners, corners) + np.einsum("km,km->m", total, total)
            energy += times * float(size @ squares)
    return energy / 120


def transport_cost(tessellation: Tessellation) -> float:
    """Returns the cost of moving the uniform density of the domain to the seeds: the sum of the integrals of |x - p|^2.

    Each cell goes to its seed p. In a power diagram no other plan that gives each seed the volume of its cell costs less,
    so after :func:`fit_volumes` this is the squared Wasserstein distance. It has a closed form. Needs "faces" in want, but
    not in a mesh.
    """
    from ..tessellation import Tessellation

    if not isinstance(tessellation, Tessellation):
        raise TypeError(f"tessellation is {shown(tessellation)}: give the result of tessellate()")
    return uniform_energy(tessellation, tessellation.wrapped_points, "transport_cost()")


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
        x, y, z = points[wrong[0]]
        raise ValueError(f"density is {values[wrong[0]]} at ({x}, {y}, {z}): it must be finite and not negative")
    return values


def weighted_centroids(t: Tessellation, places: Float64Array, density: Density) -> Tuple[Float64Array, float]:
    """Returns centroids relative to the seeds (N, 3), NaN without mass, and the energy, by the rule above."""
    mass, moment, energy = np.zeros(len(t)), np.zeros((3, len(t))), 0.0
    for cell, corners, size in _tetrahedra(t, places, "lloyd()"):
        if len(cell) == 0:
            continue
        nodes = np.repeat(_FAR * corners.sum(axis=1)[:, None], 4, axis=1)  # x, y, z of the four points
        nodes[:, :3] += (_NEAR - _FAR) * corners
        at = nodes.reshape(3, -1) + np.tile(places.T[:, cell], 4)
        weight = _values(t, density, np.ascontiguousarray(at.T)).reshape(4, -1) * (size / 24)
        first, last = cell[0], cell[-1] + 1
        mass[first:last] += np.bincount(cell - first, weight.sum(axis=0))
        for axis in range(3):
            moment[axis, first:last] += np.bincount(cell - first, np.einsum("nm,nm->m", weight, nodes[axis]))
        energy += float(np.einsum("nm,knm,knm->", weight, nodes, nodes))
    centroid = np.divide(moment, mass, out=np.full_like(moment, np.nan), where=mass > 0)
    return centroid.T, energy
