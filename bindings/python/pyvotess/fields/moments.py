"""Mass, centroid and energy of cells, summed over simplices between seeds and faces: tetrahedra, in the plane triangles."""

from __future__ import annotations

from math import factorial
from typing import TYPE_CHECKING, Any, Callable, Optional, Tuple

import numpy as np

from .._arguments import shown
from .._input import as_float64_or_float32
from ..export.geometry import mesh_of
from ..pairs import edges_of
from .simplices import simplices

if TYPE_CHECKING:
    import numpy.typing as npt

    from .._types import BoolArray, Float64Array
    from ..tessellation import Tessellation

#: A function of (K, 3) or (K, 2) points that returns (K,) finite numbers >= 0.
Density = Callable[[Any], Any]


def _rule(dimensions: int) -> Tuple[float, float]:
    """Returns the barycentric coordinates of the nodes of a simplex: near one corner, and far from all others.

    The nodes have equal weights, one for each corner. Sums over them are exact for polynomials of degree 2 (Hammer, Stroud
    1956).
    """
    n = dimensions
    far = (n + 2 - (n + 2) ** 0.5) / ((n + 1) * (n + 2))
    return 1 - n * far, far


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
        for _, corners, size in simplices(t, places, caller, chosen):
            total = corners.sum(axis=1)
            squares = np.einsum("kcm,kcm->m", corners, corners) + np.einsum("km,km->m", total, total)
            energy += times * float(size @ squares)
    return energy / (24 if t.planar else 120)


def transport_cost(tessellation: Tessellation, density: Optional[npt.ArrayLike] = None) -> float:
    """Returns the cost of moving the density of the domain to the seeds: the sum of the integrals of ``density`` |x - p|^2.

    Each cell goes to its seed p. In a power diagram no other plan that gives each seed the volume of its cell costs less,
    so after :func:`fit_volumes` this is the squared Wasserstein distance. It has a closed form. The density is 1, or that on
    a grid, as for :meth:`Tessellation.masses`. Needs "faces" in want, but not in a mesh. After ``min_face`` or ``min_area`` it tessellates again: cells need their small faces too.

    >>> print(f"{vt.transport_cost(t):.4f}")
    0.0176
    """
    from ..tessellation import Tessellation

    t = tessellation
    if not isinstance(t, Tessellation):
        raise TypeError(f"tessellation is {shown(t)}: give the result of tessellate()")
    if density is not None:
        return t.masses(density).cost(t.wrapped_points)
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
    for cell, corners, size in simplices(t, places, "lloyd()"):
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
