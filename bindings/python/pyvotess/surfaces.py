"""Cells on a triangle surface: the restricted Voronoi diagram, its dual, relaxation and remeshing."""

from __future__ import annotations

import os
import warnings
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Dict, Literal, Optional, Tuple, Union

import numpy as np

from . import _c_api
from ._arguments import as_count, as_flag, as_number, as_path, as_word, counted
from ._call import Handle, Progress, raise_on_failure, run
from ._input import as_mesh, as_one_each, as_points
from ._library import lib
from .fields.lloyd import _as_mask

if TYPE_CHECKING:
    import numpy.typing as npt

    from ._types import Float64Array, Int32Array, Int64Array

SurfaceWant = Literal["areas", "nearest", "polygons", "all"]

_MAX_VERTICES = 2**28
#: The arrays of each word of want. A word requests those of the words before it too.
_ARRAYS: Dict[str, Tuple[str, ...]] = {
    "areas": ("areas", "borders"),
    "nearest": ("centroids", "nearest", "energies"),
    "polygons": (
        "pieces", "euler", "polygon_triangles", "polygon_seeds", "polygon_areas", "polygon_pieces", "polygon_offsets",
        "corners", "beyond", "vertices",
    ),
    "all": (
        "indptr", "indices", "lengths", "curves", "loops", "dual", "dual_counts", "piece_dual", "piece_dual_counts", "faults",
    ),
}  # fmt: skip
_LEVELS = {word: level for level, word in enumerate(_ARRAYS, 1)}
_FIGURES = ("min_angle", "mean_min_angle", "distance", "border_edges", "crowded_edges")


@dataclass(frozen=True, eq=False)
class SurfaceCells:
    """The parts of N cells on a surface of V vertices and T triangles.

    Polygons: one for each triangle and cell that share an area, P of them, ascending by triangle, then seed. Polygon p has
    the corners ``corners[polygon_offsets[p] : polygon_offsets[p + 1]]``, which run as those of the triangle. Corners are
    shared: where polygons meet, they name the same rows of ``vertices``. The first V rows are those of the surface.
    Arrays that :func:`surface` was not asked for are missing.
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
    polygon_pieces: Int32Array  #: (P,) the connected part, numbered over all cells in their order
    polygon_offsets: Int64Array  #: (P + 1,) offsets into ``corners`` and ``beyond``
    corners: Int32Array  #: rows of ``vertices``
    #: the side that begins at each corner: the seed beyond it, or -1 - k on the triangle's edge from its corner k
    beyond: Int32Array
    vertices: Float64Array  #: (W, 3)
    #: (D, 3) restricted Delaunay triangles of seeds, each once, ascending; the lowest seed first. A triangle turns as the
    #: surface does where the three cells first meet.
    dual: Int32Array
    dual_counts: Int32Array  #: (D,) places where these cells meet
    #: (E, 3) the same with each connected part as a vertex of its own, by the numbers of ``polygon_pieces``. Where cells lie
    #: on both sides of a thin plate, it has both sides too.
    piece_dual: Int32Array
    piece_dual_counts: Int32Array  #: (E,)
    #: seeds at which the dual may differ from the surface. Their part is not a disk, shares several curves or a closed one
    #: with a neighbor, or meets two neighbors at several places. More seeds near them mend this.
    faults: Int32Array

    def __len__(self) -> int:
        """N, the number of cells."""
        return len(self.areas)

    def __repr__(self) -> str:
        made = vars(self)
        counts = {"polygons": "polygon_seeds", "triangles": "dual", "faults": "faults"}
        return f"<pyvotess.SurfaceCells: {counted(len(self), 'cell')}" + "".join(
            f", {len(made[name])} {what}" for what, name in counts.items() if name in made
        ) + ">"

    if not TYPE_CHECKING:  # a type checker would accept any name

        def __getattr__(self, name: str) -> Any:
            for word, names in _ARRAYS.items():
                if name in names or (name == "perimeters" and word == "all"):
                    raise AttributeError(f"{name} was not computed: give want={word!r} to surface()")
            raise AttributeError(f"{type(self).__name__!r} object has no attribute {name!r}")

    @property
    def perimeters(self) -> Float64Array:
        """(N,) length of the boundary of each part, as a new array."""
        rows = np.repeat(np.arange(len(self)), np.diff(self.indptr))
        shared: Float64Array = np.bincount(rows, self.lengths, minlength=len(self)).astype(np.float64)
        return shared + self.borders


@dataclass(frozen=True, eq=False)
class SurfaceRelaxation:
    """The outcome of S steps of :func:`lloyd_on_surface`. S is smaller than requested if the tolerance was reached."""

    points: Float64Array  #: (N, 3) on the surface
    energies: Float64Array  #: (S + 1,) the sum of ``cells.energies`` before the first step and after each
    moved: Float64Array  #: (S,) the largest move in each step, in units of the mean spacing
    cells: SurfaceCells  #: of ``points``

    def __repr__(self) -> str:
        first, last = self.energies[[0, -1]]
        return f"<pyvotess.SurfaceRelaxation of {counted(len(self.points), 'seed')}, {counted(len(self.moved), 'step')}: energy {first:.6g} to {last:.6g}>"


@dataclass(frozen=True, eq=False)
class Remesh:
    """A triangle mesh from :func:`remesh`. Without triangles the angles are 0 and the distance is infinite."""

    vertices: Float64Array  #: (W, 3) on the given surface
    triangles: Int32Array  #: (D, 3) turned as the given ones
    points: Float64Array  #: (M, 3) seeds
    #: of ``points`` on the given surface; vertex k is their connected part k. Further vertices lie in parts that were split.
    cells: SurfaceCells
    energies: Float64Array  #: (S + 1,) before the first step of the relaxation, and after each
    #: seeds at which the mesh may differ from the surface: a part is not a disk, the triangles around it do not fit, or they
    #: miss a border or a corner in it. More vertices mend this.
    faults: Int32Array
    min_angle: float  #: degrees, of all triangles
    mean_min_angle: float  #: degrees: the mean of the smallest angle of each triangle
    #: the largest distance found between the two meshes: from corners of the polygons of ``cells``, and from the middles of
    #: the triangles and of their sides
    distance: float
    border_edges: int  #: edges of one triangle
    crowded_edges: int  #: edges of more than two

    @property
    def angles(self) -> Float64Array:
        """(D, 3) angles at the corners of the triangles in degrees, as a new array."""
        x = self.vertices[self.triangles]
        x = np.ldexp(x, -int(np.frexp(np.abs(x).max(initial=0.0))[1]))  # products neither overflow nor vanish
        a, b = np.roll(x, -1, axis=1) - x, np.roll(x, 1, axis=1) - x
        across = np.linalg.norm(np.cross(a, b), axis=2)
        angles: Float64Array = np.degrees(np.arctan2(across, (a * b).sum(axis=2)))
        return angles

    def save(self, path: Union[str, os.PathLike[str]]) -> None:
        """Writes vertices and triangles to a file in .obj, whole or not at all.

        >>> square, two = [(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0)], [(0, 1, 2), (0, 2, 3)]
        >>> vt.remesh((square, two), 100).save("square.obj")
        """
        from .export.whole_file import whole_file

        file = as_path(path, "path")
        if not file.lower().endswith(".obj"):
            raise ValueError(f"path is {file!r}: give a file in .obj")
        with whole_file(file) as temporary, open(temporary, "w", encoding="ascii", newline="\n") as out:
            out.writelines(f"v {x!r} {y!r} {z!r}\n" for x, y, z in self.vertices.tolist())
            out.writelines(f"f {a} {b} {c}\n" for a, b, c in (self.triangles + 1).tolist())

    def __repr__(self) -> str:
        least = f", angles from {self.min_angle:.1f} degrees" if len(self.triangles) else ""
        return f"<pyvotess.Remesh: {len(self.vertices)} vertices, {counted(len(self.triangles), 'triangle')}{least}>"


def surface(
    points: npt.ArrayLike,
    mesh: Any,
    *,
    weights: Optional[npt.ArrayLike] = None,
    want: SurfaceWant = "all",
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
    mesh : (vertices, triangles), (V, 3) real numbers and (T, 3) rows of these; or a mesh of trimesh, PyVista, meshio or Open3D,
        or what :func:`remesh` returns.
    weights : (N,) weights of a power diagram, as for :func:`tessellate`.
    want : which arrays to make. ``"areas"``: ``areas`` and ``borders``; ``"nearest"``: also ``centroids``, ``nearest`` and
        ``energies``; ``"polygons"``: also the polygons, ``vertices``, ``pieces`` and ``euler``; ``"all"``: also the rows of
        neighbors and the duals.
    merge : make vertices at equal places one, as for triangles of an STL file.
    threads : as for :func:`tessellate`. The result is the same on any number.
    progress : as for :func:`tessellate`.

    Raises
    ------
    ValueError : bad input; the message names the first bad value.
    MemoryError, VotessError : as for :func:`tessellate`.

    Warns
    -----
    RuntimeWarning : areas or energies are infinite or all 0 in float64, as for coordinates of 1e200.

    >>> square, two = [(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0)], [(0, 1, 2), (0, 2, 3)]
    >>> cells = vt.surface([(0.25, 0.5, 0), (0.75, 0.5, 0)], (square, two))
    >>> print(cells.areas, cells.lengths)
    [0.5 0.5] [1. 1.]
    """
    seeds = as_points(points).astype(np.float64, copy=False)
    given = None if weights is None else as_one_each(weights, "weights", len(seeds), "points")
    level = as_word(want, "want", _LEVELS)
    options = _c_api.SurfaceOptions(
        threads=as_count(threads, "threads", 32), weights=given, want=level, merge=as_flag(merge, "merge")
    )
    handle = Handle("surface")
    arrays = _as_surface(mesh)
    run(lib.votess_surface_new, seeds, len(seeds), *arrays, options, handle, options=options, progress=progress)
    return _cells(handle, level)


def _as_surface(mesh: Any) -> Tuple[Float64Array, int, Int32Array, int]:
    vertices, triangles = as_mesh(mesh)
    if vertices.shape[1] != 3:
        raise ValueError(f"vertices of mesh have shape {vertices.shape}: a surface lies in space, give (V, 3)")
    return vertices, len(vertices), triangles, len(triangles)


def _cells(handle: Handle, level: int = len(_ARRAYS)) -> SurfaceCells:
    cells = object.__new__(SurfaceCells)
    for names in list(_ARRAYS.values())[:level]:
        vars(cells).update(handle.arrays(*names))
    for name in ("areas", "energies")[:level]:
        total = getattr(cells, name).sum()
        if total == 0 or np.isinf(total):
            advice = "multiply" if total == 0 else "divide"
            warnings.warn(f"{name} of cells are beyond float64: {advice} coordinates by a constant", RuntimeWarning, 3)
            break
    return cells


def lloyd_on_surface(
    points: npt.ArrayLike,
    mesh: Any,
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
    points, mesh, merge : as for :func:`surface`.
    steps : maximum number of steps.
    fixed : (N,) bool, or a list of indices: seeds that do not move.
    tolerance : stop when no seed moved farther than this, in units of the mean spacing: the square root of the area for
        each seed.
    threads : as for :func:`tessellate`.
    progress : as for :func:`tessellate`, as a fraction of all steps.

    >>> square, two = [(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0)], [(0, 1, 2), (0, 2, 3)]
    >>> relaxed = vt.lloyd_on_surface(points, (square, two), steps=5)
    >>> bool(relaxed.energies[-1] < relaxed.energies[0])
    True
    """
    seeds = as_points(points).astype(np.float64, copy=False)
    limit = as_number(tolerance, "tolerance")
    if not 0 <= limit < np.inf:
        raise ValueError(f"tolerance is {limit}: it must be finite and not negative")
    options = _c_api.SurfaceLloydOptions(
        threads=as_count(threads, "threads", 32), fixed=_as_mask(fixed, len(seeds)).view(np.uint8), tolerance=limit,
        steps=as_count(steps, "steps", 32), merge=as_flag(merge, "merge"),
    )  # fmt: skip
    handle = Handle("surface")
    arrays = _as_surface(mesh)
    run(lib.votess_surface_lloyd, seeds, len(seeds), *arrays, options, handle, options=options, progress=progress)
    return SurfaceRelaxation(
        energies=handle.array("step_energies"), cells=_cells(handle), **handle.arrays("points", "moved")
    )


def remesh(
    mesh: Any,
    n: int,
    *,
    steps: int = 16,
    sharp: float = 40.0,
    rng_seed: int = 1,
    merge: bool = False,
    threads: int = 0,
    progress: Union[None, bool, Progress] = None,
) -> Remesh:
    """Returns a mesh of well-shaped triangles with about ``n`` vertices for a surface.

    It has exactly ``n``, unless parts of the surface are thinner than the triangles are long, or it has more corners. Random
    places are spread by area, relaxed on the surface by steps that go further than those of Lloyd's method, and joined by the
    dual of connected parts. Seeds whose cells hold a stretch of a border or of a sharp edge move along it, and one seed goes
    to each of their corners. Seeds are added at corners and borders that the triangles would miss, as in sharp tips. So the
    mesh ends where the surface does. Where cells fall into several parts, as on both sides of a thin plate, fewer seeds make
    the same number of vertices. Where the mesh would differ from the surface, as around thin bars, seeds are added, at most
    ``n`` in all. Parts that still do not fit together are split, into at most ``4 n`` more, each with a vertex of its own: so
    the mesh is closed, and has the handles of the surface, where that is a manifold. ``faults`` lists the seeds where that
    did not help. Flat triangles are mended by flips of their longest edge. Sharp edges nearer to each other than the
    triangles are long may share vertices: ``distance`` tells.

    Parameters
    ----------
    mesh, merge : as for :func:`surface`.
    n : number of vertices, from 1 to 268435456.
    steps : of the relaxation.
    sharp : angle in degrees by which the surface turns at sharp edges, and these at their corners, above 0. 180: keep
        borders alone.
    rng_seed : of the random places.
    threads, progress : as for :func:`tessellate`.

    >>> square, two = [(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0)], [(0, 1, 2), (0, 2, 3)]
    >>> mesh = vt.remesh((square, two), 100)
    >>> mesh.vertices.shape
    (100, 3)
    """
    count, angle = as_count(n, "n", 64), as_number(sharp, "sharp")
    if not 0 < count <= _MAX_VERTICES:
        raise ValueError(f"n is {count}: give 1 to {_MAX_VERTICES}")
    if not 0 < angle <= 180:
        raise ValueError(f"sharp is {angle}: give an angle above 0, up to 180")
    options = _c_api.RemeshOptions(
        threads=as_count(threads, "threads", 32), rng_seed=as_count(rng_seed, "rng_seed", 64), sharp=angle,
        steps=as_count(steps, "steps", 32), merge=as_flag(merge, "merge"),
    )  # fmt: skip
    handle = Handle("surface")
    arrays = _as_surface(mesh)
    run(lib.votess_surface_remesh, count, *arrays, options, handle, options=options, progress=progress)
    figures = _c_api.RemeshFigures()
    raise_on_failure(lib.votess_surface_figures(handle, figures))
    return Remesh(
        handle.array("mesh_vertices"), handle.array("mesh_triangles"), handle.array("points"), _cells(handle),
        handle.array("step_energies"), handle.array("mesh_faults"), **{name: getattr(figures, name) for name in _FIGURES},
    )  # fmt: skip
