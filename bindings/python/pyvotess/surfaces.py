"""Cells on a triangle surface: the restricted Voronoi diagram, its dual, relaxation and remeshing."""

from __future__ import annotations

import os
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, List, Optional, Union

import numpy as np

from . import _c_api
from ._arguments import as_count, as_flag, as_number, as_path
from ._call import Handle, Progress, raise_on_failure, run, showing
from ._input import as_array, as_one_each, as_points
from ._library import lib
from .fields.lloyd import _as_mask, _share

if TYPE_CHECKING:
    import numpy.typing as npt

    from ._types import BoolArray, Float64Array, Int32Array, Int64Array

# A seed stays on a feature if its cell holds at least this much of it, in units of the cell's size.
_LEAST_SHARE = 0.5


@dataclass(frozen=True)
class SurfaceCells:
    """The parts of N cells on a surface of V vertices and T triangles.

    Polygons: one for each triangle and cell that share an area, P of them, ascending by triangle, then seed. Polygon p has
    the corners ``corners[polygon_offsets[p] : polygon_offsets[p + 1]]``, which run as those of the triangle. Corners are
    shared: where polygons meet, they name the same rows of ``vertices``. The first V rows are those of the surface.
    """

    areas: Float64Array  #: (N,) of the parts; they sum to the area of the surface
    centroids: Float64Array  #: (N, 3) of the parts; NaN for a part without area
    nearest: Float64Array  #: (N, 3) the place of the part nearest to its centroid; NaN likewise
    energies: Float64Array  #: (N,) the integral of ``|x - p|^2`` over the part
    borders: Float64Array  #: (N,) length on edges of one triangle
    pieces: Int32Array  #: (N,) connected parts, joined through edges of the surface
    euler: Int32Array  #: (N,) Euler's characteristic of the part: 1 for a disk
    indptr: Int64Array  #: (N + 1,) offsets into ``indices``, ``lengths``, ``curves`` and ``loops``
    indices: Int32Array  #: ascending in each row: seeds with which a cell shares a positive length
    lengths: Float64Array  #: that length, equal for both cells
    curves: Int32Array  #: connected curves of which it consists
    loops: Int32Array  #: those among them that are closed
    polygon_triangles: Int32Array  #: (P,)
    polygon_seeds: Int32Array  #: (P,)
    polygon_areas: Float64Array  #: (P,)
    polygon_offsets: Int64Array  #: (P + 1,) offsets into ``corners`` and ``beyond``
    corners: Int32Array  #: rows of ``vertices``
    #: the side that begins at each corner: the seed beyond it, or -1 - k on the triangle's edge from its corner k
    beyond: Int32Array
    vertices: Float64Array  #: (W, 3)
    #: (D, 3) restricted Delaunay triangles of seeds, each once, ascending; the lowest seed first. A triangle turns as the
    #: surface does where the three cells first meet.
    dual: Int32Array
    dual_counts: Int32Array  #: (D,) places where these cells meet
    #: seeds at which the dual may differ from the surface. Their part is no disk, shares several curves or a closed one
    #: with a neighbor, or meets two neighbors at several places. More seeds near them mend this.
    faults: Int32Array

    def __len__(self) -> int:
        """N, the number of cells."""
        return len(self.areas)

    def __repr__(self) -> str:
        return (
            f"<pyvotess.SurfaceCells: {len(self)} cells, {len(self.polygon_seeds)} polygons, {len(self.dual)} triangles, "
            f"{len(self.faults)} faults>"
        )

    @property
    def perimeters(self) -> Float64Array:
        """(N,) length of the boundary of each part, as a new array."""
        rows = np.repeat(np.arange(len(self)), np.diff(self.indptr))
        shared: Float64Array = np.bincount(rows, self.lengths, minlength=len(self)).astype(np.float64)
        return shared + self.borders


@dataclass(frozen=True)
class SurfaceRelaxation:
    """The outcome of S steps of :func:`lloyd_on_surface`. S is smaller than requested if the tolerance was reached."""

    points: Float64Array  #: (N, 3) on the surface
    energies: Float64Array  #: (S + 1,) the sum of ``cells.energies`` before the first step and after each
    moved: Float64Array  #: (S,) the largest move in each step, in units of the mean spacing
    cells: SurfaceCells  #: of ``points``

    def __repr__(self) -> str:
        first, last = self.energies[[0, -1]]
        return f"<pyvotess.SurfaceRelaxation of {len(self.points)} seeds, {len(self.moved)} steps: energy {first:.6g} to {last:.6g}>"


@dataclass(frozen=True)
class Remesh:
    """A triangle mesh from :func:`remesh`."""

    vertices: Float64Array  #: (n, 3) on the given surface
    triangles: Int32Array  #: (D, 3) turned as the given ones
    cells: SurfaceCells  #: of ``vertices`` on the given surface
    energies: Float64Array  #: (S + 1,) before the first step of the relaxation, and after each

    @property
    def angles(self) -> Float64Array:
        """(D, 3) angles at the corners of the triangles in degrees, as a new array."""
        x = self.vertices[self.triangles]
        a, b = np.roll(x, -1, axis=1) - x, np.roll(x, 1, axis=1) - x
        across = np.linalg.norm(np.cross(a, b), axis=2)
        angles: Float64Array = np.degrees(np.arctan2(across, (a * b).sum(axis=2)))
        return angles

    def save(self, path: Union[str, os.PathLike[str]]) -> None:
        """Writes vertices and triangles to a file in .obj, whole or not at all.

        >>> square, two = [(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0)], [(0, 1, 2), (0, 2, 3)]
        >>> vt.remesh(square, two, 100).save("square.obj")
        """
        from .export.whole_file import whole_file

        file = as_path(path, "path")
        if not file.lower().endswith(".obj"):
            raise ValueError(f"path is {file!r}: give a file in .obj")
        with whole_file(file) as temporary, open(temporary, "w", encoding="ascii", newline="\n") as out:
            out.writelines(f"v {x!r} {y!r} {z!r}\n" for x, y, z in self.vertices.tolist())
            out.writelines(f"f {a} {b} {c}\n" for a, b, c in (self.triangles + 1).tolist())

    def __repr__(self) -> str:
        least = f", angles from {self.angles.min():.1f} degrees" if len(self.triangles) else ""
        return f"<pyvotess.Remesh: {len(self.vertices)} vertices, {len(self.triangles)} triangles{least}>"


def _as_triangles(triangles: Any) -> Int32Array:
    array = as_array(triangles, "triangles")
    if array.dtype.kind not in "iu":
        raise ValueError(f"triangles has dtype {array.dtype}: give whole numbers")
    if array.ndim != 2 or array.shape[1] != 3:
        raise ValueError(f"triangles has shape {array.shape}: it must be (T, 3)")
    wrong = np.argwhere((array < -(2**31)) | (array >= 2**31))
    if len(wrong):
        raise ValueError(f"triangles[{wrong[0][0]}] has {array[tuple(wrong[0])]}, which is not the index of a vertex")
    return np.ascontiguousarray(array, np.int32)


def surface(
    points: npt.ArrayLike,
    vertices: npt.ArrayLike,
    triangles: npt.ArrayLike,
    *,
    weights: Optional[npt.ArrayLike] = None,
    merge: bool = False,
    threads: int = 0,
    progress: Union[None, bool, Progress] = None,
) -> SurfaceCells:
    """Returns the parts of the cells of points on a triangle surface: the restricted Voronoi diagram.

    Signs are exact, so the parts tile the surface. A place as near to several seeds belongs to the one of lowest index. So
    a cell that only touches the surface may have a part without area. The surface need be neither closed nor oriented
    alike, and may intersect itself. Its triangles without area are skipped, and no part is connected through them.

    Parameters
    ----------
    points : (N, 3) array of real numbers. They need not lie on the surface.
    vertices : (V, 3) array of real numbers.
    triangles : (T, 3) rows of ``vertices``.
    weights : (N,) weights of a power diagram, as for :func:`tessellate`.
    merge : make vertices at equal places one, as for triangles of an STL file.
    threads : as for :func:`tessellate`. The result is the same on any number.
    progress : as for :func:`tessellate`.

    Raises
    ------
    ValueError : bad input; the message names the first bad value.
    MemoryError, VotessError : as for :func:`tessellate`.

    >>> square, two = [(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0)], [(0, 1, 2), (0, 2, 3)]
    >>> cells = vt.surface([(0.25, 0.5, 0), (0.75, 0.5, 0)], square, two)
    >>> print(cells.areas, cells.lengths)
    [0.5 0.5] [1. 1.]
    """
    seeds = as_points(points).astype(np.float64, copy=False)
    places = as_points(vertices, "vertices").astype(np.float64, copy=False)
    rows = _as_triangles(triangles)
    given = None if weights is None else as_one_each(weights, "weights", len(seeds), "points")
    options = _c_api.SurfaceOptions(threads=as_count(threads, "threads", 32), weights=given, merge=as_flag(merge, "merge"))
    handle = Handle("surface")
    arguments = (seeds, len(seeds), places, len(places), rows, len(rows), options, handle)
    raise_on_failure(run(lib.votess_surface_new, *arguments, options=options, progress=progress))
    return SurfaceCells(**handle.arrays(*SurfaceCells.__dataclass_fields__))


def lloyd_on_surface(
    points: npt.ArrayLike,
    vertices: npt.ArrayLike,
    triangles: npt.ArrayLike,
    *,
    steps: int = 100,
    fixed: npt.ArrayLike = (),
    tolerance: float = 0.0,
    merge: bool = False,
    threads: int = 0,
    progress: Union[None, bool, Progress] = None,
) -> SurfaceRelaxation:
    """Moves each seed to its part of a surface, as near as possible to the part's centroid, ``steps`` times.

    The seeds spread evenly over the surface. Those without a part stay.

    Parameters
    ----------
    points, vertices, triangles, merge : as for :func:`surface`.
    steps : maximum number of steps.
    fixed : (N,) bool, or a list of indices: seeds that do not move.
    tolerance : stop when no seed moved farther than this, in units of the mean spacing: the square root of the area for
        each seed.
    threads : as for :func:`tessellate`.
    progress : as for :func:`tessellate`, as a fraction of all steps.

    >>> square, two = [(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0)], [(0, 1, 2), (0, 2, 3)]
    >>> relaxed = vt.lloyd_on_surface(points, square, two, steps=5)
    >>> bool(relaxed.energies[-1] < relaxed.energies[0])
    True
    """
    array = as_points(points).astype(np.float64)
    moving, limit = ~_as_mask(fixed, len(array)), as_number(tolerance, "tolerance")
    if not 0 <= limit < np.inf:
        raise ValueError(f"tolerance is {limit}: it must be finite and not negative")
    return _relax(array, vertices, triangles, as_count(steps, "steps", 32), moving, limit, merge, threads, progress)


def _relax(
    points: Float64Array,
    vertices: npt.ArrayLike,
    triangles: npt.ArrayLike,
    steps: int,
    moving: BoolArray,
    tolerance: float,
    merge: bool,
    threads: int,
    progress: Union[None, bool, Progress],
    features: Optional[_Features] = None,
) -> SurfaceRelaxation:
    energies: List[float] = []
    moved: List[float] = []
    with showing(progress) as show:
        for step in range(steps + 1):
            part = None if show is None else _share(show, step, steps + 1)
            cells = surface(points, vertices, triangles, merge=merge, threads=threads, progress=part)
            energies.append(float(cells.energies.sum()))
            if step == steps or (moved and moved[-1] <= tolerance):
                break
            places = cells.nearest if features is None else features.attract(cells)
            way = places - points
            way[~moving | np.isnan(way[:, 0])] = 0
            moved.append(float(np.sqrt((way**2).sum(axis=1).max(initial=0) * len(points) / cells.areas.sum())))
            points = points + way
    return SurfaceRelaxation(points, np.array(energies), np.array(moved), cells)


class _Features:
    """Edges of a surface that vertices of its remesh lie on: borders, sharp edges, those of more than two triangles."""

    def __init__(self, vertices: Float64Array, triangles: Int32Array, angle: float) -> None:
        x = vertices[triangles]
        normals = np.cross(x[:, 1] - x[:, 0], x[:, 2] - x[:, 0])
        lengths = np.linalg.norm(normals, axis=1)
        normals = normals / np.where(lengths > 0, lengths, 1)[:, None]
        real = np.flatnonzero(lengths > 0)
        ends = np.stack((triangles[real], np.roll(triangles[real], -1, axis=1)), axis=-1).reshape(-1, 2)
        edges, number, counts = np.unique(np.sort(ends, axis=1), axis=0, return_inverse=True, return_counts=True)
        number = number.reshape(-1)
        turned = np.where(ends[:, 0] < ends[:, 1], 1.0, -1.0)
        order = np.argsort(number, kind="stable")
        first = np.cumsum(counts) - counts
        a, b = order[first], order[first + counts - 1]
        # Two triangles of one orientation run along their edge in opposite directions.
        cosines = -turned[a] * turned[b] * (normals[real[a // 3]] * normals[real[b // 3]]).sum(axis=1)
        is_feature = (counts != 2) | (cosines < np.cos(np.radians(angle)))
        self.counts = counts
        self.edge_of = np.full((len(triangles), 3), -1)
        self.edge_of[real] = number.reshape(-1, 3)
        self.is_feature = np.append(is_feature, False)  # also of edge -1
        chosen = edges[is_feature]
        degree = np.bincount(chosen.ravel(), minlength=len(vertices))
        # Ways from each vertex along its features: two that go on nearly straight sum to little.
        ways = vertices[chosen[:, 1]] - vertices[chosen[:, 0]]
        ways = ways / np.maximum(np.linalg.norm(ways, axis=1), np.finfo(float).tiny)[:, None]
        sums = np.zeros((len(vertices), 3))
        np.add.at(sums, chosen[:, 0], ways)
        np.add.at(sums, chosen[:, 1], -ways)
        bend = np.linalg.norm(sums, axis=1) > 2 * np.sin(np.radians(angle) / 2)
        self.is_corner = (degree > 0) & ((degree != 2) | bend)

    def attract(self, cells: SurfaceCells) -> Float64Array:
        """Returns the places to which seeds move: corners, the middle of features in their cell, or ``nearest``."""
        sizes = np.diff(cells.polygon_offsets)
        polygon = np.repeat(np.arange(len(sizes)), sizes)
        after = np.arange(len(polygon)) + 1
        after[cells.polygon_offsets[1:] - 1] = cells.polygon_offsets[:-1]
        slot = np.where(cells.beyond < 0, -1 - cells.beyond, 0)
        edge = np.where(cells.beyond < 0, self.edge_of[cells.polygon_triangles[polygon], slot], -1)
        on = np.flatnonzero(self.is_feature[edge])
        places = np.array(cells.nearest)
        if len(on) == 0:
            return places
        seed = cells.polygon_seeds[polygon[on]]
        a, b = cells.vertices[cells.corners[on]], cells.vertices[cells.corners[after[on]]]
        length = np.linalg.norm(b - a, axis=1) / self.counts[edge[on]]
        total = np.bincount(seed, length, minlength=len(cells))
        middle: Float64Array = np.stack(
            [np.bincount(seed, length * m, minlength=len(cells)).astype(np.float64) for m in ((a + b) / 2).T], axis=1
        )
        takes = total > _LEAST_SHARE * np.sqrt(cells.areas)
        middle[takes] /= total[takes, None]
        way = b - a
        square = np.maximum((way**2).sum(axis=1), np.finfo(float).tiny)
        share = np.clip(((middle[seed] - a) * way).sum(axis=1) / square, 0, 1)
        foot = a + share[:, None] * way
        order = np.argsort(-((foot - middle[seed]) ** 2).sum(axis=1), kind="stable")  # the nearest last
        order = order[takes[seed[order]]]
        places[seed[order]] = foot[order]
        given = cells.corners < len(self.is_corner)
        at = np.flatnonzero(given & self.is_corner[np.where(given, cells.corners, 0)])[::-1]
        places[cells.polygon_seeds[polygon[at]]] = cells.vertices[cells.corners[at]]
        return places


def sample_surface(
    vertices: Float64Array, triangles: npt.NDArray[Any], count: int, rng: np.random.Generator
) -> Float64Array:
    """Returns random places, uniform by area."""
    x = vertices[triangles]
    areas = 0.5 * np.linalg.norm(np.cross(x[:, 1] - x[:, 0], x[:, 2] - x[:, 0]), axis=1)
    if not areas.sum() > 0:
        raise ValueError("the triangles have no area")
    # One in each stretch of equal area, so that no part of the surface stays without.
    ends = np.cumsum(areas)
    which = np.searchsorted(ends, (np.arange(count) + rng.random(count)) * ends[-1] / count, side="right")
    which = np.minimum(which, np.flatnonzero(areas)[-1])
    a, b = np.sqrt(rng.random(count))[:, None], rng.random(count)[:, None]
    places: Float64Array = (1 - a) * x[which, 0] + a * (1 - b) * x[which, 1] + a * b * x[which, 2]
    return places


def remesh(
    vertices: npt.ArrayLike,
    triangles: npt.ArrayLike,
    n: int,
    *,
    steps: int = 30,
    sharp: float = 40.0,
    rng_seed: int = 0,
    merge: bool = False,
    threads: int = 0,
    progress: Union[None, bool, Progress] = None,
) -> Remesh:
    """Returns a mesh of ``n`` vertices and well-shaped triangles for a surface.

    Random places are spread by area, relaxed by Lloyd's method on the surface, and joined by the dual. Seeds whose cells
    hold a stretch of a border or of a sharp edge move along it, and one seed to each of their corners. So the mesh ends
    where the surface does, up to the size of its triangles. ``cells.faults`` lists vertices at which it may differ from
    the surface: thin parts and small holes need more vertices.

    Parameters
    ----------
    vertices, triangles, merge : as for :func:`surface`.
    n : number of vertices, at least 1.
    steps : of the relaxation.
    sharp : angle in degrees by which the surface turns at sharp edges, and these at their corners, above 0. 180: keep
        borders alone.
    rng_seed : of the random places.
    threads, progress : as for :func:`tessellate`.

    >>> square, two = [(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0)], [(0, 1, 2), (0, 2, 3)]
    >>> mesh = vt.remesh(square, two, 100)
    >>> mesh.vertices.shape
    (100, 3)
    """
    places = as_points(vertices, "vertices").astype(np.float64, copy=False)
    rows = _as_triangles(triangles)
    count, angle, merge = as_count(n, "n", 31), as_number(sharp, "sharp"), as_flag(merge, "merge")
    if count == 0:
        raise ValueError("n is 0: give at least 1")
    if not 0 < angle <= 180:
        raise ValueError(f"sharp is {angle}: give an angle above 0, up to 180")
    if not np.isfinite(places).all():
        raise ValueError(f"vertices[{np.argwhere(~np.isfinite(places))[0][0]}] is not finite")
    wrong = np.argwhere((rows < 0) | (rows >= len(places)))
    if len(wrong):
        raise ValueError(f"triangles[{wrong[0][0]}] has {rows[tuple(wrong[0])]}, but there are {len(places)} vertices")
    if merge:
        places, same = np.unique(places + 0.0, axis=0, return_inverse=True)  # both zeros are equal
        rows = same.reshape(-1)[rows].astype(np.int32)
    points = sample_surface(places, rows, count, np.random.default_rng(as_count(rng_seed, "rng_seed", 64)))
    relaxed = _relax(
        points, places, rows, as_count(steps, "steps", 32), np.ones(count, bool), 0.0, False, threads, progress,
        _Features(places, rows, angle),
    )  # fmt: skip
    return Remesh(relaxed.points, relaxed.cells.dual, relaxed.cells, relaxed.energies)
