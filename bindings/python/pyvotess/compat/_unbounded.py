"""Unbounded diagrams, merged from one in a near box and one in a box that contains all vertices."""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property
from typing import TYPE_CHECKING, Any, Dict, List, Tuple

import numpy as np

from ..export.geometry import ranges
from ..tessellator import tessellate
from ._points import qhull_error

if TYPE_CHECKING:
    import numpy.typing as npt

    from ..tessellation import Tessellation

    BoolArray = npt.NDArray[np.bool_]
    Float64Array = npt.NDArray[np.float64]
    Int64Array = npt.NDArray[np.int64]

#: Margin of the near box, in mean distances between points. A wider box costs more; a narrower one leaves more cells to
#: the far box.
_NEAR = 6.0
#: Margins of the far box, in longest sides of the bounds of the points. Vertices are so far away only where four points
#: are flat up to rounding. The next margin is tried if a box does not contain all vertices.
_FAR = (2.0**64, 2.0**100, 2.0**170)


@dataclass(frozen=True)
class Part:
    """A tessellation that is part of a diagram."""

    t: Tessellation
    seeds: Int64Array  #: ids of its points in the diagram, ascending
    number: Int64Array  #: of its vertices in the diagram; negative on the box


@dataclass(frozen=True)
class Diagram:
    """The Voronoi diagram of N points, open where it meets the box.

    With two parts, open cells and their ridges come from the last part, the others from the first.
    """

    parts: List[Part]  #: the second has the vertices that the first lacks
    is_open: BoolArray  #: (N,)
    vertices: Float64Array  #: (V, 3)
    ridge_seeds: Int64Array  #: (R, 2), ascending in each row
    entries: List[Int64Array]  #: for each part its faces that are ridges; ridges begin with those of the last part

    @property
    def duplicate_of(self) -> Int64Array:
        """(N,) the earlier point that a point equals, else -1."""
        duplicate_of = self.parts[0].t.duplicate_of
        return np.full(len(self.is_open), -1) if duplicate_of is None else duplicate_of.astype(np.int64)

    @property
    def unordered(self) -> Int64Array:
        """The cells whose vertices may not ascend."""
        return np.flatnonzero(self.is_open) if len(self.parts) > 1 else np.arange(len(self.is_open))

    @cached_property
    def ridges(self) -> Tuple[Int64Array, Int64Array]:
        """(indptr, corners), counterclockwise seen from the second seed; negative on the box."""
        sizes, corners = [], []
        for part, entry in reversed(list(zip(self.parts, self.entries))):
            begin, end = part.t.faces.indptr[entry], part.t.faces.indptr[entry + 1]
            sizes.append(end - begin)
            corners.append(part.number[part.t.faces.indices[ranges(begin, end - begin)]])
        return np.concatenate(([0], np.cumsum(np.concatenate(sizes)))), np.concatenate(corners)

    @cached_property
    def cells(self) -> Tuple[Int64Array, Int64Array]:
        """(indptr, corners) of each cell; negative on the box."""
        begin, end = np.zeros((2, len(self.is_open)), dtype=np.int64)
        corners: List[Int64Array] = []
        total = 0
        for part in self.parts:
            rows = part.t.cell_vertices
            mine = self.is_open[part.seeds] == (part is not self.parts[0])
            begin[part.seeds[mine]] = total + rows.indptr[:-1][mine]
            end[part.seeds[mine]] = total + rows.indptr[1:][mine]
            corners.append(part.number[rows.indices])
            total += len(rows.indices)
        indptr = np.concatenate(([0], np.cumsum(end - begin)))
        return indptr, np.concatenate(corners)[ranges(begin, end - begin)] if len(corners) > 1 else corners[0]


def diagram_of_space(points: Float64Array, options: Dict[str, Any]) -> Diagram:
    """Returns the unbounded diagram."""
    lower, upper = (points.min(axis=0), points.max(axis=0)) if len(points) else (np.zeros(3), np.zeros(3))
    side = float((upper - lower).max())
    if side == 0:
        raise qhull_error()("the points are fewer than four, or all equal")
    margin = _NEAR * side / np.cbrt(len(points))
    near, is_inner = _tessellate(points, (lower - margin, upper + margin), options)
    # Outside of the near box are only cells that reach it, and only their own neighbors bound them.
    seed_of_vertex = np.repeat(np.arange(len(points)), np.diff(near.cell_vertices.indptr))
    is_open = np.zeros(len(points), dtype=bool)
    is_open[seed_of_vertex[~is_inner[near.cell_vertices.indices]]] = True
    seed = np.repeat(np.arange(len(points)), np.diff(near.neighbors.indptr))
    beside = near.neighbors.indices[is_open[seed]]
    is_far = is_open.copy()
    is_far[beside[beside >= 0]] = True
    far, far_is_inner = _tessellate_far(points[is_far], lower, upper, side, options)

    seeds = np.flatnonzero(is_far)
    near_part = Part(near, np.arange(len(points)), _numbers(is_inner))
    far_number = _match(near_part, Part(far, seeds, _numbers(far_is_inner)), is_open, is_far)
    return _merge([near_part, Part(far, seeds, far_number)], is_open)


def diagram_in_box(points: Float64Array, box: Any, options: Dict[str, Any]) -> Diagram:
    """Returns the diagram without vertices beyond the box."""
    t, is_inner = _tessellate(points, box, options)
    return _merge([Part(t, np.arange(len(points)), _numbers(is_inner))], np.zeros(len(points), dtype=bool))


def _numbers(is_inner: BoolArray) -> Int64Array:
    """Returns numbers of vertices: up from 0, and down from -1 for those on the box."""
    return np.where(is_inner, np.cumsum(is_inner) - 1, -1 - np.arange(len(is_inner)))


def _tessellate(points: Float64Array, box: Any, options: Dict[str, Any]) -> Tuple[Tessellation, BoolArray]:
    """Returns the tessellation with faces, and which of its vertices are not on the box."""
    t = tessellate(points, box=box, want="faces", **options)
    is_inner = np.ones(len(t.vertices), dtype=bool)
    is_wall = np.flatnonzero(t.neighbors.indices < 0)
    begin = t.faces.indptr[is_wall]
    is_inner[t.faces.indices[ranges(begin, t.faces.indptr[is_wall + 1] - begin)]] = False
    return t, is_inner


def _tessellate_far(
    points: Float64Array, lower: Float64Array, upper: Float64Array, side: float, options: Dict[str, Any]
) -> Tuple[Tessellation, BoolArray]:
    for margin in _FAR:
        box = (lower - margin * side, upper + margin * side)
        if not np.isfinite(box).all():
            break
        t, is_inner = _tessellate(points, box, options)
        if not is_inner.any():
            break
        if _is_hull_convex(t, is_inner):
            return t, is_inner
    raise qhull_error()("the points are in one plane, or four of them are so flat that their sphere is too large")


def _match(near: Part, far: Part, is_open: BoolArray, is_far: BoolArray) -> Int64Array:
    """Returns the numbers of the far part's vertices: those of the near part if it has them, else new ones.

    A vertex of an open cell is identified by the set of cells around it that both parts have.
    """
    signs = np.random.default_rng(1).integers(0, 2**64, len(is_open), dtype=np.uint64)
    near_vertex, near_key = _keys(near, is_open, is_far, signs)
    far_vertex, far_key = _keys(far, is_open, is_far, signs)
    order = np.argsort(near_key)
    place = np.minimum(np.searchsorted(near_key[order], far_key), max(len(order) - 1, 0))
    found = near_key[order][place] == far_key if len(order) else np.zeros(len(far_key), dtype=bool)
    number = -1 - np.arange(len(far.number))
    number[far_vertex[found]] = near.number[near_vertex[order[place[found]]]]
    number[far_vertex[~found]] = near.number.max(initial=-1) + 1 + np.arange(np.count_nonzero(~found))
    return number


def _keys(part: Part, is_open: BoolArray, is_far: BoolArray, signs: npt.NDArray[np.uint64]) -> Tuple[Any, Any]:
    """Returns the vertices of open cells that are not on the box, and the sum of the signs of the cells at each."""
    vertex = part.t.cell_vertices.indices
    cell = np.repeat(part.seeds, np.diff(part.t.cell_vertices.indptr))
    used = np.zeros(len(part.number), dtype=bool)
    used[vertex[is_open[cell]]] = True
    used &= part.number >= 0
    kept = used[vertex] & is_far[cell]
    vertex, cell = vertex[kept], cell[kept]
    order = np.argsort(vertex, kind="stable")
    vertices, begin = np.unique(vertex[order], return_index=True)
    return vertices, np.add.reduceat(signs[cell[order]], begin) if len(begin) else signs[:0]


def _merge(parts: List[Part], is_open: BoolArray) -> Diagram:
    count = max(int(part.number.max(initial=-1)) + 1 for part in parts)
    vertices = np.empty((count, 3))
    pairs: List[Int64Array] = []
    entries: List[Int64Array] = []
    for part in reversed(parts):  # the first part keeps its own vertices
        is_used = part.number >= 0
        vertices[part.number[is_used]] = part.t.vertices[is_used]
        rows = part.t.neighbors
        local = np.repeat(np.arange(len(part.seeds), dtype=np.int32), np.diff(rows.indptr))
        entry = np.flatnonzero(rows.indices > local)
        one, other = part.seeds[local[entry]], part.seeds[rows.indices[entry]]
        mine = (is_open[one] | is_open[other]) == (part is not parts[0])
        pairs.append(np.column_stack((one[mine], other[mine])))
        entries.insert(0, entry[mine])
    return Diagram(parts, is_open, vertices, np.concatenate(pairs), entries)


def _is_hull_convex(t: Tessellation, is_inner: BoolArray) -> bool:
    """Returns whether no vertex is beyond the box, in exact arithmetic.

    An edge of the diagram that leaves the box is dual to a triangle on the surface of the tetrahedra at inner vertices.
    If that surface is convex, the tetrahedra fill the convex hull, and none is missing.
    """
    rows, faces = t.neighbors, t.faces
    seed = np.repeat(np.arange(len(t)), np.diff(rows.indptr))
    # One polygon for each pair of seeds whose face has a corner on the box.
    polygon_of = np.repeat(np.arange(len(rows.indices)), np.diff(faces.indptr))
    on_box = ~is_inner[faces.indices]
    outer = np.unique(polygon_of[on_box])
    outer = outer[seed[outer] < rows.indices[outer]]
    size = faces.indptr[outer + 1] - faces.indptr[outer]
    corner = ranges(faces.indptr[outer], size)
    first = np.repeat(faces.indptr[outer], size)
    following = np.where(corner + 1 < np.repeat(faces.indptr[outer + 1], size), corner + 1, first)
    number = np.repeat(np.arange(len(outer)), size)
    leaves = ~on_box[corner] & on_box[following]
    enters = on_box[corner] & ~on_box[following]
    each_once = np.arange(len(outer))
    if not (np.array_equal(number[leaves], each_once) and np.array_equal(number[enters], each_once)):
        return False
    i, j = seed[outer], rows.indices[outer].astype(np.int64)
    above = _third_seeds(t, is_inner, faces.indices[following[leaves]], i, j)
    below = _third_seeds(t, is_inner, faces.indices[corner[enters]], i, j)
    if (above < 0).any() or (below < 0).any():
        return False
    # i, j, above are counterclockwise seen from outside: below must not be above their plane.
    return bool((orientation(np.asarray(t.points, dtype=np.float64), i, j, above, below) <= 0).all())


def _third_seeds(t: Tessellation, is_inner: BoolArray, vertex: Any, i: Int64Array, j: Int64Array) -> Int64Array:
    """Returns for each vertex on the box, where cells i and j meet, a third cell at it; -1 without one."""
    entry = np.flatnonzero(~is_inner[t.cell_vertices.indices])
    cell = np.searchsorted(t.cell_vertices.indptr, entry, side="right") - 1
    vertices = t.cell_vertices.indices[entry]
    order = np.argsort(vertices, kind="stable")
    vertices, cell = vertices[order], cell[order]
    begin = np.searchsorted(vertices, vertex, side="left")
    count = np.searchsorted(vertices, vertex, side="right") - begin
    third = np.full(len(i), -1, dtype=np.int64)
    for k in range(3):
        candidate = cell[np.minimum(begin + k, len(cell) - 1)]
        third = np.where((k < count) & (candidate != i) & (candidate != j), candidate, third)
    return third


def orientation(points: Float64Array, a: Int64Array, b: Int64Array, c: Int64Array, d: Int64Array) -> Int64Array:
    """Returns the exact sign of det(b-a, c-a, d-a) for arrays of ids."""
    u, v, w = points[b] - points[a], points[c] - points[a], points[d] - points[a]
    with np.errstate(over="ignore", invalid="ignore"):
        cross = np.stack([v[:, k - 2] * w[:, k - 1] - v[:, k - 1] * w[:, k - 2] for k in range(3)], axis=1)
        value = np.einsum("pk,pk->p", u, cross)
        parts = np.abs(np.stack([v[:, k - 2] * w[:, k - 1] for k in range(3)], axis=1))
        parts += np.abs(np.stack([v[:, k - 1] * w[:, k - 2] for k in range(3)], axis=1))
        # Bounds a few roundings of 2**-53 each with reserve. Products below the floor may be denormal.
        certain = np.abs(value) > np.maximum(2.0**-48 * np.einsum("pk,pk->p", np.abs(u), parts), 1e-280)
    sign: Int64Array = np.where(certain, np.sign(value), 0).astype(np.int64)
    # Four points with an equal coordinate, as on the sides of a box, are flat. Fractions decide the others.
    flat = ((u == 0) & (v == 0) & (w == 0)).any(axis=1)
    for p in np.flatnonzero(~certain & ~flat):
        sign[p] = _exact_sign([points[ids[p]].tolist() for ids in (a, b, c, d)])
    return sign


def _exact_sign(corners: List[List[float]]) -> int:
    a, b, c, d = ([Fraction(x) for x in corner] for corner in corners)
    u, v, w = ([x - y for x, y in zip(corner, a)] for corner in (b, c, d))
    value = (
        u[0] * (v[1] * w[2] - v[2] * w[1]) + u[1] * (v[2] * w[0] - v[0] * w[2]) + u[2] * (v[0] * w[1] - v[1] * w[0])
    )
    return (value > 0) - (value < 0)
