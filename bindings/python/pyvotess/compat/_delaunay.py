"""scipy.spatial.Delaunay for two and three dimensions."""

from __future__ import annotations

import itertools
import sys
from functools import cached_property
from typing import TYPE_CHECKING, Any, Optional, Tuple, Type

import numpy as np

from ._diagram import Diagram, diagram_of_space
from ._orientation import orientation
from ._points import OfPoints

if TYPE_CHECKING:
    import numpy.typing as npt

    from .._types import BoolArray, Float64Array, Int32Array, Int64Array

#: by dimension: the face opposite to each corner of a positive simplex, counterclockwise seen from outside or around it
_OPPOSITE = {
    2: np.array([(1, 2), (2, 0), (0, 1)]),
    3: np.array([(1, 2, 3), (0, 3, 2), (0, 1, 3), (0, 2, 1)]),
}
_QUERIES_AT_ONCE = 1 << 16


class Delaunay(OfPoints):
    """The Delaunay tetrahedra of points in space, or triangles in the plane, as scipy.spatial.Delaunay.

    Parameters
    ----------
    points : (N, 3) numbers, not all in one plane, or (N, 2), not all on one line.
    furthest_site, incremental : must be False.
    qhull_options : not used.
    options : of :func:`pyvotess.tessellate`: ``threads``, ``device``, ``instructions``, ``progress``.

    Attributes: ``points``, ``simplices``, ``neighbors``, ``convex_hull``, ``coplanar``, ``vertex_to_simplex``,
    ``vertex_neighbor_vertices``, ``transform``, ``equations``, ``paraboloid_scale``, ``paraboloid_shift``, ``npoints``,
    ``nsimplex``, ``ndim``, ``min_bound``, ``max_bound``, ``furthest_site``, as in scipy. All except the first two are
    computed at first use. Interpolators of ``scipy.interpolate`` accept the object instead of points.

    The simplices fill the convex hull.

    Differences from scipy:

    - The corners of a tetrahedron are ordered so that det(b-a, c-a, d-a) > 0. Triangles are counterclockwise, as there.
    - Five or more points on one sphere, or four on one circle, are triangulated from the lowest index. The simplices
      fit together.
    - Flat simplices at the hull, which Qhull may merge, are included.
    - ``coplanar`` lists only points that equal an earlier one.
    """

    if not TYPE_CHECKING:

        @property
        def __class__(self) -> Any:
            """scipy.spatial.Delaunay if it is loaded, because scipy.interpolate checks by isinstance()."""
            return getattr(sys.modules.get("scipy.spatial"), "Delaunay", type(self))

    def __reduce__(self) -> Any:
        return _empty, (type(self),), self.__dict__

    def __init__(
        self,
        points: npt.ArrayLike,
        furthest_site: bool = False,
        incremental: bool = False,
        qhull_options: Optional[str] = None,
        **options: Any,
    ) -> None:
        del qhull_options
        super().__init__(points, furthest_site, incremental)
        diagram = diagram_of_space(self.points, options)
        simplices = _triangles(diagram) if self.ndim == 2 else _tetrahedra(diagram)
        # Edges are dual to ridges if each vertex has one simplex.
        self._edges = diagram.ridge_seeds if len(simplices) == len(diagram.vertices) else None
        self.simplices: Int32Array = simplices.astype(np.int32)
        self.nsimplex = len(self.simplices)
        self._duplicate_of = diagram.duplicate_of

    @cached_property
    def neighbors(self) -> Int32Array:
        """(T, ndim + 1) int32, the simplex opposite to each corner, -1 at the hull."""
        count = self.ndim + 1
        faces = np.sort(self.simplices[:, _OPPOSITE[self.ndim]].reshape(-1, self.ndim), axis=1).astype(np.int64)
        bits = 63 // self.ndim
        if self.npoints < 2**bits:  # all ids in one number sort faster
            order = np.argsort(sum(faces[:, k] << k * bits for k in range(self.ndim)), kind="stable")
        else:
            order = np.lexsort(faces.T)
        sorted_faces = faces[order]
        first = np.flatnonzero((sorted_faces[1:] == sorted_faces[:-1]).all(axis=1))
        neighbors = np.full(len(faces), -1, dtype=np.int32)
        neighbors[order[first]] = order[first + 1] // count
        neighbors[order[first + 1]] = order[first] // count
        return neighbors.reshape(-1, count)

    @cached_property
    def convex_hull(self) -> Int32Array:
        """(F, ndim) int32: the triangles of the hull, counterclockwise seen from outside, or its edges around it."""
        simplex, corner = np.nonzero(self.neighbors < 0)
        return np.take_along_axis(self.simplices[simplex], _OPPOSITE[self.ndim][corner], axis=1)

    @cached_property
    def vertex_to_simplex(self) -> Int32Array:
        """(N,) int32, a simplex with the point, or with the earlier point that it equals."""
        simplex = np.full(self.npoints, -1, dtype=np.int32)
        simplex[self.simplices.ravel()] = np.repeat(np.arange(self.nsimplex, dtype=np.int32), self.ndim + 1)
        copies = np.flatnonzero(self._duplicate_of >= 0)
        simplex[copies] = simplex[self._duplicate_of[copies]]
        return simplex

    @cached_property
    def coplanar(self) -> Int32Array:
        """(K, 3) int32: a point that equals an earlier one, a simplex with the earlier one, and the earlier one."""
        copies = np.flatnonzero(self._duplicate_of >= 0)
        return np.column_stack((copies, self.vertex_to_simplex[copies], self._duplicate_of[copies])).astype(np.int32)

    @cached_property
    def vertex_neighbor_vertices(self) -> Tuple[Int32Array, Int32Array]:
        """(indptr, indices): the points that share an edge with point k are ``indices[indptr[k]:indptr[k+1]]``."""
        edges = self._edges
        if edges is None:
            ends = np.array(list(itertools.combinations(range(self.ndim + 1), 2)))
            all_edges = np.sort(self.simplices[:, ends].reshape(-1, 2), axis=1).astype(np.int64)
            numbers = np.unique(all_edges[:, 0] * self.npoints + all_edges[:, 1])
            edges = np.column_stack(np.divmod(numbers, self.npoints))
        both = np.concatenate((edges, edges[:, ::-1]))
        indices = both[np.lexsort((both[:, 1], both[:, 0])), 1].astype(np.int32)
        counts = np.bincount(both[:, 0], minlength=self.npoints)
        return np.concatenate(([0], np.cumsum(counts))).astype(np.int32), indices

    @cached_property
    def transform(self) -> Float64Array:
        """(T, ndim + 1, ndim) float64: a matrix and the last corner r of each simplex.

        ``matrix @ (x - r)`` are the first barycentric coordinates. The matrix is NaN for a simplex that is too flat.
        """
        corners = self.points[self.simplices]
        sides = corners[:, :-1] - corners[:, -1:]
        cofactors = _cofactors(sides)
        volume = np.einsum("tk,tk->t", sides[:, 0], cofactors[:, 0])
        with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
            inverse = cofactors / volume[:, None, None]
            lengths = np.abs(sides).sum(axis=2).max(axis=1)
            condition = lengths * np.abs(inverse).sum(axis=1).max(axis=1)
        inverse[~(condition * 1000 * np.finfo(np.float64).eps < 1)] = np.nan
        return np.concatenate((inverse, corners[:, -1:]), axis=1)

    @cached_property
    def _paraboloid(self) -> Tuple[float, float]:
        # Qhull scales heights to the size of the coordinates. They range from the smallest one to that of a point at
        # infinity, 1.1 times the largest one.
        squares = np.einsum("pk,pk->p", self.points, self.points)
        scale = float(np.abs(self.points).max() / (1.1 * squares.max() - squares.min()))
        return scale, float(-squares.min() * scale)

    @property
    def paraboloid_scale(self) -> float:
        """Points are lifted to the height ``paraboloid_scale * |x|**2 + paraboloid_shift``."""
        return self._paraboloid[0]

    @property
    def paraboloid_shift(self) -> float:
        """See :attr:`paraboloid_scale`."""
        return self._paraboloid[1]

    @cached_property
    def equations(self) -> Float64Array:
        """(T, ndim + 2) float64: downward unit normal and offset of the plane through the lifted corners of simplices.

        NaN for a simplex that is too flat.
        """
        # In units of the largest coordinate.
        unit = np.abs(self.points).max()
        scale, shift = self.paraboloid_scale * unit, self.paraboloid_shift / unit
        corners = self.points[self.simplices] / unit
        last = corners[:, -1]
        sides = corners[:, :-1] - corners[:, -1:]
        # The determinant of the sides is positive in the plane and negative in space.
        cofactors = (-1) ** self.ndim * _cofactors(sides)
        # The plane n.x - volume h = offset is that of the sphere, |x - last|^2 volume = (x - last).toward.
        volume = np.einsum("tk,tk->t", sides[:, 0], cofactors[:, 0])[:, None]
        toward = np.einsum("tkx,tkx,tky->ty", sides, sides, cofactors)
        offset = shift * volume - scale * np.einsum("tk,tk->t", last, last * volume + toward)[:, None]
        planes = np.concatenate((scale * (2 * last * volume + toward), -volume, offset * unit), axis=1)
        with np.errstate(divide="ignore", invalid="ignore"):
            lengths = np.sqrt(np.einsum("tk,tk->t", planes[:, :-1], planes[:, :-1]))
            equations: Float64Array = planes / lengths[:, None]
        return equations

    def lift_points(self, x: npt.ArrayLike) -> Float64Array:
        """Returns (..., ndim + 1) float64, the points (..., ndim) lifted to the paraboloid."""
        array = np.asarray(x, dtype=np.float64)
        height = self.paraboloid_scale * np.einsum("...k,...k->...", array, array) + self.paraboloid_shift
        return np.concatenate((array, height[..., None]), axis=-1)

    def plane_distance(self, xi: npt.ArrayLike) -> Float64Array:
        """Returns (..., T) float64, the distance of each lifted point from the plane of each simplex.

        It is positive inside the sphere of the simplex.
        """
        distances: Float64Array = self.lift_points(xi) @ self.equations[:, :-1].T + self.equations[:, -1]
        return distances

    def find_simplex(self, xi: npt.ArrayLike, bruteforce: bool = False, tol: Optional[float] = None) -> Int32Array:
        """Returns (...,) int32, the simplex that contains each point of ``xi`` (..., ndim), -1 outside of the hull.

        The search walks from simplex to simplex by exact signs. A point outside counts as inside if its barycentric
        coordinates in the last simplex are at least ``-tol``, by default 100 machine epsilons. ``bruteforce`` is not
        used.
        """
        del bruteforce
        if np.asarray(xi).ndim == 0:  # np.ndim() would ask a Delaunay for its own
            raise IndexError(f"xi has shape (): it must be (..., {self.ndim})")
        array = np.asarray(xi, dtype=np.float64)
        if array.shape[-1] != self.ndim:
            raise ValueError(f"xi has shape {array.shape}: it must be (..., {self.ndim})")
        queries = array.reshape(-1, self.ndim)
        allowed = 100 * float(np.finfo(np.float64).eps) if tol is None else tol
        found = np.full(len(queries), -1, dtype=np.int32)
        known = np.flatnonzero(np.isfinite(queries).all(axis=1))
        for begin in range(0, len(known), _QUERIES_AT_ONCE):
            some = known[begin : begin + _QUERIES_AT_ONCE]
            found[some] = self._walk(queries[some], allowed)
        return found.reshape(array.shape[:-1])

    def _walk(self, queries: Float64Array, allowed: float) -> Int32Array:
        at = self.vertex_to_simplex[self._near(queries)]
        # Queries follow the points, so that both have ids.
        places = np.concatenate((self.points, queries))
        found = np.full(len(queries), -1, dtype=np.int32)
        walking = np.arange(len(queries))
        beyond_sign = -((-1) ** self.ndim)  # orientation() of a face and a point beyond it
        while len(walking):
            corners = self.simplices[at[walking]].astype(np.int64)
            beyond = np.full(len(walking), -1)
            for k, opposite in enumerate(_OPPOSITE[self.ndim]):
                undecided = np.flatnonzero(beyond < 0)
                face = corners[undecided][:, opposite].T
                sign = orientation(places, *face, self.npoints + walking[undecided])
                beyond[undecided[sign == beyond_sign]] = k
            found[walking[beyond < 0]] = at[walking[beyond < 0]]
            walking, beyond = walking[beyond >= 0], beyond[beyond >= 0]
            following = self.neighbors[at[walking], beyond]
            outside = walking[following < 0]
            found[outside] = np.where(self._is_close(queries[outside], at[outside], allowed), at[outside], -1)
            at[walking] = following
            walking = walking[following >= 0]
        return found

    def _near(self, queries: Float64Array) -> Int64Array:
        """Returns (Q,) ids of points near the queries: the nearest of a sample."""
        sample = np.flatnonzero(self._duplicate_of < 0)[:: max(1, int(self.npoints ** (2 / 3) / 4))]
        nearest = np.zeros(len(queries), dtype=np.int64)
        least = np.full(len(queries), np.inf)
        for point in sample:
            with np.errstate(over="ignore"):
                distance = ((queries - self.points[point]) ** 2).sum(axis=1)
            closer = distance < least
            nearest[closer], least[closer] = point, distance[closer]
        nearest[np.isinf(least)] = sample[0]
        return nearest

    def _is_close(self, queries: Float64Array, simplices: Int32Array, allowed: float) -> BoolArray:
        transform = self.transform[simplices]
        first = np.einsum("tij,tj->ti", transform[:, :-1], queries - transform[:, -1])
        least = np.minimum(first.min(axis=1, initial=np.inf), 1 - first.sum(axis=1))
        return np.asarray(least >= -allowed)


def _empty(kind: Type[Delaunay]) -> Delaunay:
    return kind.__new__(kind)


def _cofactors(sides: Float64Array) -> Float64Array:
    """Returns the derivatives of the determinants of matrices (T, ndim, ndim) by their elements."""
    cofactors: Float64Array
    if sides.shape[1] == 2:
        cofactors = sides[:, ::-1, ::-1] * np.array([(1, -1), (-1, 1)])
    else:
        cofactors = np.cross(sides[:, [1, 2, 0]], sides[:, [2, 0, 1]])
    return cofactors


def _triangles(diagram: Diagram) -> Int64Array:
    """Returns (T, 3) counterclockwise triangles: each vertex has a fan from the lowest seed around it.

    An edge of the diagram from vertex v to w has seed i on its left and j on its right. Counterclockwise around w, j
    follows i; around v, i follows j.
    """
    ends = diagram.ridges[1].reshape(-1, 2)
    center = ends[:, ::-1].ravel()
    i = diagram.ridge_seeds.ravel()
    j = diagram.ridge_seeds[:, ::-1].ravel()
    lowest = np.full(len(diagram.vertices) + 1, len(diagram.t))  # the last one is that of infinity
    np.minimum.at(lowest, center, i)
    apex = lowest[center]
    kept = np.flatnonzero((center >= 0) & (i != apex) & (j != apex))
    return np.column_stack((apex[kept], i[kept], j[kept]))


def _tetrahedra(diagram: Diagram) -> Int64Array:
    """Returns (T, 4) positive tetrahedra."""
    dual = diagram.t.delaunay()
    tetrahedra: Int64Array = dual.tetrahedra.astype(np.int64)
    if len(dual.polytopes) == 0:
        return tetrahedra
    lowest = np.full(len(diagram.vertices) + 1, -1)  # the last one is that of infinity
    lowest[dual.polytope_centers] = dual.polytopes.indices[dual.polytopes.indptr[:-1]]
    return np.concatenate((tetrahedra, _cut_polytopes(diagram, lowest)))


def _cut_polytopes(diagram: Diagram, lowest: Int64Array) -> Int64Array:
    """Returns (T, 4) positive tetrahedra of the points around the vertices with a lowest seed.

    A facet of the polytope at a vertex is dual to an edge of the diagram there. An edge of the facet is dual to a ridge
    at that edge. Each facet is a fan from its lowest seed. The tetrahedra are cones from the polytope's lowest seed to
    the triangles of all facets without it. So two polytopes triangulate their common facet equally.
    """
    indptr, corners = diagram.ridges
    ridge = np.repeat(np.arange(len(indptr) - 1), np.diff(indptr))
    following = np.empty_like(corners)
    following[:-1] = corners[1:]
    following[indptr[1:] - 1] = corners[indptr[:-1]]
    leaves = np.flatnonzero(lowest[corners] >= 0)
    enters = np.flatnonzero(lowest[following] >= 0)
    center = np.concatenate((corners[leaves], following[enters]))
    other = np.concatenate((following[leaves], corners[enters]))
    # Seen along the edge towards the center, the facet is left of the path from seed i to seed j.
    i, j = diagram.ridge_seeds[np.concatenate((ridge[leaves], ridge[enters]))].T
    i, j = np.where(np.arange(len(center)) < len(leaves), (i, j), (j, i))
    of_hull = np.flatnonzero(other < 0)
    other[of_hull] = -1 - _facets_of_hull(diagram.t.points, center[of_hull], i[of_hull], j[of_hull])
    order = np.lexsort((other, center))
    center, other, i, j = center[order], other[order], i[order], j[order]
    is_first = np.append(True, (center[1:] != center[:-1]) | (other[1:] != other[:-1]))
    least = np.minimum.reduceat(np.minimum(i, j), np.flatnonzero(is_first))[np.cumsum(is_first) - 1]
    apex = lowest[center]
    kept = (least != apex) & (i != least) & (j != least)
    return np.column_stack((apex[kept], i[kept], j[kept], least[kept]))


def _facets_of_hull(points: Float64Array, center: Int64Array, i: Int64Array, j: Int64Array) -> Int64Array:
    """Returns the number of a facet for each of its edges from seed i to seed j, counterclockwise seen from outside.

    The edge that follows begins at j. Its end k is such that no other edge ends outside of the plane of i, j, k.
    """
    begins, ends = (center * len(points) + seed for seed in (i, j))
    order = np.argsort(begins, kind="stable")
    first = np.searchsorted(begins[order], ends, side="left")
    count = np.searchsorted(begins[order], ends, side="right") - first
    following = order[first]
    for k in range(1, int(count.max(initial=0))):
        edge = np.flatnonzero(count > k)
        best, candidate = following[edge], order[first[edge] + k]
        is_back = j[best] == i[edge]
        is_outside = orientation(points, i[edge], j[edge], j[best], j[candidate]) > 0
        following[edge] = np.where(is_back | is_outside, candidate, best)
    # The number of a facet is that of its first edge. Each step doubles the number of edges compared.
    facet = np.arange(len(i))
    for _ in range(len(i).bit_length()):
        facet = np.minimum(facet, facet[following])
        following = following[following]
    return facet
