"""scipy.spatial.Delaunay for three dimensions."""

from __future__ import annotations

import sys
from functools import cached_property
from typing import TYPE_CHECKING, Any, List, Optional, Tuple, Type

import numpy as np

from ._points import OfPoints
from ._unbounded import Diagram, diagram_of_space, orientation

if TYPE_CHECKING:
    import numpy.typing as npt

    Float64Array = npt.NDArray[np.float64]
    Int64Array = npt.NDArray[np.int64]
    Int32Array = npt.NDArray[np.int32]
    BoolArray = npt.NDArray[np.bool_]

#: the face opposite to each corner of a positive tetrahedron, counterclockwise seen from outside
_OPPOSITE = np.array([(1, 2, 3), (0, 3, 2), (0, 1, 3), (0, 2, 1)])
_QUERIES_AT_ONCE = 1 << 16


class Delaunay(OfPoints):
    """The Delaunay tetrahedra of points in space, with the attributes of scipy.spatial.Delaunay.

    Parameters
    ----------
    points : (N, 3) numbers, N >= 4, not all in one plane.
    furthest_site, incremental : must be False.
    qhull_options : not used.
    options : of :func:`pyvotess.tessellate`: ``threads``, ``device``, ``instructions``, ``progress``.

    Attributes: ``points``, ``simplices``, ``neighbors``, ``convex_hull``, ``coplanar``, ``vertex_to_simplex``,
    ``vertex_neighbor_vertices``, ``transform``, ``equations``, ``paraboloid_scale``, ``paraboloid_shift``, ``npoints``,
    ``nsimplex``, ``ndim``, ``min_bound``, ``max_bound``, ``furthest_site``, as in scipy. All except the first two are
    computed at first use. ``scipy.interpolate.LinearNDInterpolator`` accepts the object instead of points.

    The simplices fill the convex hull. Exact arithmetic verifies that their surface is convex. Raises QhullError when a
    simplex at the hull is so flat that no box contains the center of its sphere.

    Differences from scipy:

    - The corners of a simplex are ordered so that det(b-a, c-a, d-a) > 0.
    - Five or more points on one sphere are triangulated from the lowest index, consistently with their neighbors.
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
        tetrahedra, lowest = _tetrahedra(diagram)
        if (lowest >= 0).any():
            tetrahedra = np.concatenate((tetrahedra, _cut_polytopes(diagram, lowest)))
            self._edges = None
        else:
            self._edges = diagram.ridge_seeds
        self.simplices: Int32Array = tetrahedra.astype(np.int32)
        self.nsimplex = len(self.simplices)
        self._duplicate_of = diagram.duplicate_of

    @cached_property
    def neighbors(self) -> Int32Array:
        """(T, 4) int32, the simplex opposite to each corner, -1 at the hull."""
        faces = np.sort(self.simplices[:, _OPPOSITE].reshape(-1, 3), axis=1).astype(np.int64)
        if self.npoints < 2**21:  # three ids in one number sort faster
            order = np.argsort((faces[:, 0] << 42) | (faces[:, 1] << 21) | faces[:, 2], kind="stable")
        else:
            order = np.lexsort((faces[:, 2], faces[:, 1], faces[:, 0]))
        sorted_faces = faces[order]
        first = np.flatnonzero((sorted_faces[1:] == sorted_faces[:-1]).all(axis=1))
        neighbors = np.full(len(faces), -1, dtype=np.int32)
        neighbors[order[first]] = order[first + 1] // 4
        neighbors[order[first + 1]] = order[first] // 4
        return neighbors.reshape(-1, 4)

    @cached_property
    def convex_hull(self) -> Int32Array:
        """(F, 3) int32, the triangles of the hull, counterclockwise seen from outside."""
        simplex, corner = np.nonzero(self.neighbors < 0)
        return np.take_along_axis(self.simplices[simplex], _OPPOSITE[corner], axis=1)

    @cached_property
    def vertex_to_simplex(self) -> Int32Array:
        """(N,) int32, a simplex with the point, or with the earlier point that it equals."""
        simplex = np.full(self.npoints, -1, dtype=np.int32)
        simplex[self.simplices.ravel()] = np.repeat(np.arange(self.nsimplex, dtype=np.int32), 4)
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
            ends = np.array([(0, 1), (0, 2), (0, 3), (1, 2), (1, 3), (2, 3)])
            all_edges = np.sort(self.simplices[:, ends].reshape(-1, 2), axis=1).astype(np.int64)
            numbers = np.unique(all_edges[:, 0] * self.npoints + all_edges[:, 1])
            edges = np.column_stack(np.divmod(numbers, self.npoints))
        both = np.concatenate((edges, edges[:, ::-1]))
        indices = both[np.lexsort((both[:, 1], both[:, 0])), 1].astype(np.int32)
        counts = np.bincount(both[:, 0], minlength=self.npoints)
        return np.concatenate(([0], np.cumsum(counts))).astype(np.int32), indices

    @cached_property
    def transform(self) -> Float64Array:
        """(T, 4, 3) float64: a matrix and the last corner r. ``matrix @ (x - r)`` are the first barycentric coordinates.

        The matrix is NaN for a simplex that is too flat.
        """
        corners = self.points[self.simplices]
        a, b, c = (corners[:, k] - corners[:, 3] for k in range(3))
        crosses = np.stack((np.cross(b, c), np.cross(c, a), np.cross(a, b)), axis=1)
        volume = np.einsum("tk,tk->t", a, crosses[:, 0])
        with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
            inverse = crosses / volume[:, None, None]
            lengths = np.abs(np.stack((a, b, c), axis=1)).sum(axis=2).max(axis=1)
            condition = lengths * np.abs(inverse).sum(axis=1).max(axis=1)
        inverse[~(condition * 1000 * np.finfo(np.float64).eps < 1)] = np.nan
        return np.concatenate((inverse, corners[:, 3:]), axis=1)

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
        """(T, 5) float64: downward unit normal and offset of the plane through the lifted corners of each simplex.

        NaN for a simplex that is too flat.
        """
        # In units of the largest coordinate. Vectors from corner d, in the order of a positive volume.
        unit = np.abs(self.points).max()
        scale, shift = self.paraboloid_scale * unit, self.paraboloid_shift / unit
        corners = self.points[self.simplices] / unit
        d = corners[:, 3]
        b, a, c = (corners[:, k] - d for k in range(3))
        # The plane n.x - volume h = offset is that of the sphere, |x - d|^2 volume = (x - d).toward.
        volume = np.einsum("tk,tk->t", a, np.cross(b, c))[:, None]
        pairs = ((a, b, c), (b, c, a), (c, a, b))
        toward = sum(np.einsum("tk,tk->t", u, u)[:, None] * np.cross(v, w) for u, v, w in pairs)
        offset = shift * volume - scale * np.einsum("tk,tk->t", d, d * volume + toward)[:, None]
        planes = np.concatenate((scale * (2 * d * volume + toward), -volume, offset * unit), axis=1)
        with np.errstate(divide="ignore", invalid="ignore"):
            equations: Float64Array = planes / np.sqrt(np.einsum("tk,tk->t", planes[:, :4], planes[:, :4]))[:, None]
        return equations

    def lift_points(self, x: npt.ArrayLike) -> Float64Array:
        """Returns (..., 4) float64, the points (..., 3) lifted to the paraboloid."""
        array = np.asarray(x, dtype=np.float64)
        height = self.paraboloid_scale * np.einsum("...k,...k->...", array, array) + self.paraboloid_shift
        return np.concatenate((array, height[..., None]), axis=-1)

    def plane_distance(self, xi: npt.ArrayLike) -> Float64Array:
        """Returns (..., T) float64, the distance of each lifted point from the plane of each simplex.

        It is positive inside the sphere of the simplex.
        """
        distances: Float64Array = self.lift_points(xi) @ self.equations[:, :4].T + self.equations[:, 4]
        return distances

    def find_simplex(self, xi: npt.ArrayLike, bruteforce: bool = False, tol: Optional[float] = None) -> Int32Array:
        """Returns (...,) int32, the simplex that contains each point of ``xi`` (..., 3), -1 outside of the hull.

        The search walks from simplex to simplex by exact signs. A point outside counts as inside if its barycentric
        coordinates in the last simplex are at least ``-tol``, by default 100 machine epsilons. ``bruteforce`` is not
        used.
        """
        del bruteforce
        array = np.asarray(xi, dtype=np.float64)
        if array.ndim == 0 or array.shape[-1] != 3:
            raise ValueError(f"xi has shape {array.shape}: it must be (..., 3)")
        queries = array.reshape(-1, 3)
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
        while len(walking):
            corners = self.simplices[at[walking]].astype(np.int64)
            beyond = np.full(len(walking), -1)
            for k in range(4):
                undecided = np.flatnonzero(beyond < 0)
                a, b, c = corners[undecided][:, _OPPOSITE[k]].T
                beyond[undecided[orientation(places, a, b, c, self.npoints + walking[undecided]) > 0]] = k
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
        first = np.einsum("tij,tj->ti", transform[:, :3], queries - transform[:, 3])
        least = np.minimum(first.min(axis=1, initial=np.inf), 1 - first.sum(axis=1))
        return np.asarray(least >= -allowed)


def _empty(kind: Type[Delaunay]) -> Delaunay:
    return kind.__new__(kind)


def _tetrahedra(diagram: Diagram) -> Tuple[Int64Array, Int64Array]:
    """Returns (T, 4) positive tetrahedra, and (V,) the lowest seed of the polytope at each vertex, -1 without one."""
    found: List[Int64Array] = []
    lowest = np.full(len(diagram.vertices), -1, dtype=np.int64)
    first = 0  # number of the first vertex that is in no earlier part
    for part in diagram.parts:
        complex_ = part.t.delaunay()
        found.append(part.seeds[complex_.tetrahedra[part.number[complex_.centers] >= first]])
        center = part.number[complex_.polytope_centers]
        least = part.seeds[complex_.polytopes.indices[complex_.polytopes.indptr[:-1]]]
        lowest[center[center >= first]] = least[center >= first]
        first = int(part.number.max(initial=-1)) + 1
    return np.concatenate(found), lowest


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
    has_polytope = np.append(lowest >= 0, False)  # vertices on the box have none
    leaves = np.flatnonzero(has_polytope[np.maximum(corners, -1)])
    enters = np.flatnonzero(has_polytope[np.maximum(following, -1)])
    center = np.concatenate((corners[leaves], following[enters]))
    other = np.concatenate((following[leaves], corners[enters]))
    # Seen along the edge towards the center, the facet is left of the path from seed i to seed j.
    i, j = diagram.ridge_seeds[np.concatenate((ridge[leaves], ridge[enters]))].T
    i, j = np.where(np.arange(len(center)) < len(leaves), (i, j), (j, i))
    order = np.lexsort((other, center))
    center, other, i, j = center[order], other[order], i[order], j[order]
    is_first = np.append(True, (center[1:] != center[:-1]) | (other[1:] != other[:-1]))
    least = np.minimum.reduceat(np.minimum(i, j), np.flatnonzero(is_first))[np.cumsum(is_first) - 1]
    apex = lowest[center]
    kept = (least != apex) & (i != least) & (j != least)
    return np.column_stack((apex[kept], i[kept], j[kept], least[kept]))
