"""Cells on a triangle surface: the restricted Voronoi diagram, its dual, relaxation and remeshing."""

from __future__ import annotations

import ctypes
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, List, Optional, Tuple, Union

import numpy as np

from . import _c_api
from ._arguments import as_count, as_flag, as_number
from ._call import Callbacks, Handle, Progress, raise_on_failure, showing
from ._input import as_array, as_one_each, as_points
from ._library import lib

if TYPE_CHECKING:
    import numpy.typing as npt

    Float64Array = npt.NDArray[np.float64]
    Int64Array = npt.NDArray[np.int64]
    Int32Array = npt.NDArray[np.int32]


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
    beyond: Int32Array  #: beyond the side that begins at each corner: a seed, or -1 for an edge of the triangle
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
        shared: Float64Array = np.bincount(rows, self.lengths, minlength=len(self))
        return shared + self.borders


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
        raise ValueError(f"triangles[{wrong[0][0]}] has {array[tuple(wrong[0])]}, which is no index of a vertex")
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
    given = None if weights is None else np.ascontiguousarray(as_one_each(weights, "weights", len(seeds), "points"))
    options = _c_api.SurfaceOptions(
        struct_size=ctypes.sizeof(_c_api.SurfaceOptions),
        threads=as_count(threads, "threads", 32),
        weights=None if given is None else given.ctypes.data,
        merge=as_flag(merge, "merge"),
    )
    handle = Handle("surface")
    with showing(progress) as show, Callbacks() as callbacks:
        options.progress = callbacks.progress(show)
        status = lib.votess_surface_new(
            seeds.ctypes.data, len(seeds), places.ctypes.data, len(places), rows.ctypes.data, len(rows),
            ctypes.byref(options), ctypes.byref(handle.pointer),
        )  # fmt: skip
    raise_on_failure(status)
    return SurfaceCells(**{name: handle.array(name) for name in SurfaceCells.__dataclass_fields__})


def lloyd_on_surface(
    points: Float64Array,
    vertices: Any,
    triangles: Any,
    *,
    steps: int,
    moving: npt.NDArray[np.bool_],
    tolerance: float = 0.0,
    merge: bool = False,
    threads: int = 0,
    show: Optional[Progress] = None,
) -> Tuple[Float64Array, Float64Array, Float64Array, SurfaceCells]:
    """Returns points moved to the centroids of their parts, put back onto the surface; energies, moves and cells."""
    energies: List[float] = []
    moved: List[float] = []
    for step in range(steps + 1):
        cells = surface(points, vertices, triangles, merge=merge, threads=threads)
        if show is not None and show((step + 1) / (steps + 1)) is False:
            from ._c_api import ErrorCode
            from ._call import VotessError

            raise VotessError("the progress callback stopped the run", ErrorCode.CANCELLED)
        energies.append(float(cells.energies.sum()))
        if step == steps or (moved and moved[-1] <= tolerance):
            break
        way = cells.nearest - points
        way[~moving | np.isnan(way[:, 0])] = 0
        moved.append(float(np.sqrt((way**2).sum(axis=1).max(initial=0) * len(points) / cells.areas.sum())))
        points = points + way
    return points, np.array(energies), np.array(moved), cells


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
    rng_seed: int = 0,
    merge: bool = False,
    threads: int = 0,
    progress: Union[None, bool, Progress] = None,
) -> Remesh:
    """Returns a mesh of ``n`` vertices and well-shaped triangles for a surface.

    Random places are spread by area, relaxed by Lloyd's method on the surface, and joined by the dual. ``cells.faults``
    lists vertices at which the mesh may differ from the surface: thin parts and holes need more vertices. Borders and
    sharp edges are not followed: vertices lie near them, not on them.

    Parameters
    ----------
    vertices, triangles, merge : as for :func:`surface`.
    n : number of vertices, at least 1.
    steps : of the relaxation.
    rng_seed : of the random places.
    threads, progress : as for :func:`tessellate`.

    >>> square, two = [(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0)], [(0, 1, 2), (0, 2, 3)]
    >>> mesh = vt.remesh(square, two, 100)
    >>> mesh.vertices.shape
    (100, 3)
    """
    places = as_points(vertices, "vertices").astype(np.float64, copy=False)
    rows = _as_triangles(triangles)
    count, steps = as_count(n, "n", 31), as_count(steps, "steps", 32)
    if count == 0:
        raise ValueError("n is 0: give at least 1")
    wrong = np.argwhere((rows < 0) | (rows >= len(places)))
    if len(wrong):
        raise ValueError(f"triangles[{wrong[0][0]}] has {rows[tuple(wrong[0])]}, but there are {len(places)} vertices")
    points = sample_surface(places, rows, count, np.random.default_rng(as_count(rng_seed, "rng_seed", 64)))
    with showing(progress) as show:
        points, energies, _, cells = lloyd_on_surface(
            points, places, rows, steps=steps, moving=np.ones(count, bool), merge=merge, threads=threads, show=show
        )
    return Remesh(points, cells.dual, cells, energies)
