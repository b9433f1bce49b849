"""The result: arrays in the library's memory, and what is known about them."""

from __future__ import annotations

import ctypes
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Dict, Optional, Tuple, Union

import numpy as np

from . import _c_api
from ._call import Handle, array_of, raise_on_failure
from ._input import as_count
from ._library import lib
from .mesh import Delaunay, Faces, Lists, make_delaunay
from .pairs import Pairs, count_edges, make_pairs

if TYPE_CHECKING:
    import numpy.typing as npt

    Float64Array = npt.NDArray[np.float64]
    Int8Array = npt.NDArray[np.int8]
    Int64Array = npt.NDArray[np.int64]
    Int32Array = npt.NDArray[np.int32]
    UInt32Array = npt.NDArray[np.uint32]
    UInt8Array = npt.NDArray[np.uint8]


class Neighbors(Lists):
    """The neighbor lists as rows of a compressed sparse row matrix, without its values.

    ``neighbors[i]`` is the row of seed i: ascending ids, walls (negative) first. A slice gives a list of rows.
    """

    def to_scipy(self) -> Any:
        """The (N, N) adjacency matrix as a new scipy.sparse.csr_array of True. Walls are no seeds: they are dropped."""
        from scipy.sparse import csr_array

        is_seed = self._indices >= 0
        seeds_before = np.concatenate(([0], np.cumsum(is_seed, dtype=np.int64)))
        indices = self._indices[is_seed]
        values = np.ones(len(indices), dtype=bool)
        return csr_array((values, indices, seeds_before[self._indptr]), shape=(len(self), len(self)))


@dataclass(frozen=True)
class StageSeconds:
    """Seconds of wall clock per stage. On the CPU ``knn`` and ``fallback`` are part of ``clip``."""

    upload: float
    sort: float
    knn: float
    clip: float
    fallback: float
    download: float
    total: float


@dataclass(frozen=True)
class Stats:
    """What a run did. ``dataclasses.asdict(stats)`` makes it a dict."""

    device: str  #: name of the device that ran
    points: int  #: N
    faces: int  #: sum over cells of their number of faces, walls included
    mean_faces: float  #: faces / cells that are not empty
    volume_sum: float  #: sum of all volumes; 0 when volumes were not wanted
    box_volume: float  #: volume of the domain
    duplicates: int  #: seeds with status DUPLICATE
    empty_cells: int  #: seeds that have no cell: duplicate, empty or outside
    fallback_cells: int  #: cells redone on the CPU after another device
    exact_cells: int  #: cells where exact arithmetic decided a sign
    threads: int  #: CPU threads used
    peak_memory_bytes: int  #: peak resident memory of the process so far
    precision: str  #: of volumes, centroids and areas, "single" or "double"; the CPU always gives "double"
    seconds: StageSeconds


def _read_stats(result: Handle) -> Stats:
    c_stats = _c_api.Stats(struct_size=ctypes.sizeof(_c_api.Stats))
    raise_on_failure(lib.votess_result_stats(result.pointer, ctypes.byref(c_stats)))
    fields: Dict[str, Any] = {field[0]: getattr(c_stats, field[0]) for field in _c_api.Stats._fields_}
    del fields["struct_size"]
    fields["precision"] = next(word for word, value in _c_api.PRECISIONS.items() if value == c_stats.precision)
    fields["device"] = fields["device"].decode("utf-8", "replace")
    stages = {name: fields.pop("seconds_" + name) for name in StageSeconds.__dataclass_fields__}
    return Stats(seconds=StageSeconds(**stages), **fields)


@dataclass(frozen=True)
class VerifyReport:
    """Outcome of :meth:`Tessellation.verify`. True when all checks that could be made passed."""

    passed: bool
    failure: str  #: one line on the first failed check; empty when passed
    skipped: Tuple[str, ...]  #: checks whose arrays were not wanted: "volumes", "symmetry", "euler", "sample"
    sampled: int = 0  #: cells tried by brute force, up to the one that failed

    def __bool__(self) -> bool:
        return self.passed


_Vector = ctypes.c_double * 3


def _constant(values: Any) -> Float64Array:
    array = np.array(values, dtype=np.float64)
    array.flags.writeable = False
    return array


class Tessellation:
    """The cells of N seeds; rows follow the input order.

    Arrays are read-only and lie in the library's memory, which lives as long as any of them. An array that was not
    wanted raises AttributeError.
    """

    def __init__(self, result: Handle, points: npt.NDArray[Any], wanted: Tuple[str, ...], domain_given: bool) -> None:
        self._result = result
        self._points = points
        self._wanted = wanted
        self._domain_given = domain_given
        self._stats = _read_stats(result)
        self._arrays: Dict[str, npt.NDArray[Any]] = {}
        if "neighbors" in wanted:
            self._neighbors = Neighbors(array_of(result, "indptr", np.int64), array_of(result, "indices", np.int32))
        if "areas" in wanted:
            self._arrays["face_areas"] = array_of(result, "face_areas", np.float64)
        if "normals" in wanted:
            self._arrays["face_normals"] = array_of(result, "face_normals", np.float64, columns=3)
        if "surfaces" in wanted:
            self._arrays["surface_areas"] = array_of(result, "surface_areas", np.float64)
        if "radii" in wanted:
            self._arrays["security_radii"] = array_of(result, "security_radii", np.float64)
        if "vertices" in wanted:
            self._arrays["vertices"] = array_of(result, "vertices", np.float64, columns=3)
            self._cell_vertices = Lists(
                array_of(result, "cell_vertex_indptr", np.int64), array_of(result, "cell_vertex_indices", np.int32)
            )
        if "faces" in wanted:
            self._faces = Faces(array_of(result, "face_offsets", np.int64), array_of(result, "face_vertices", np.int32))
        shifts = array_of(result, "shifts", np.int8, columns=3)
        self._shifts = shifts if len(shifts) else None
        if "volumes" in wanted:
            self._arrays["volumes"] = array_of(result, "volumes", np.float64)
        if "centroids" in wanted:
            self._arrays["centroids"] = array_of(result, "centroids", np.float64, columns=3)
        if "counts" in wanted:
            for name in ("face_counts", "edge_counts", "vertex_counts"):
                self._arrays[name] = array_of(result, name, np.uint32)
        self._status = array_of(result, "status", np.uint8)
        duplicate_of = array_of(result, "duplicate_of", np.int32)
        self._duplicate_of = duplicate_of if len(duplicate_of) else None
        lower, upper = _Vector(), _Vector()
        raise_on_failure(lib.votess_result_box(result.pointer, lower, upper))
        self._box = _constant((lower, upper))
        axes = (ctypes.c_int32 * 3)()
        raise_on_failure(lib.votess_result_periodic(result.pointer, axes))
        self._periodic = (bool(axes[0]), bool(axes[1]), bool(axes[2]))
        has_cell, vectors = ctypes.c_int32(), [_Vector() for _ in range(4)]
        raise_on_failure(lib.votess_result_cell(result.pointer, ctypes.byref(has_cell), *vectors))
        self._origin = _constant(vectors[0]) if has_cell.value else None
        self._cell = _constant(vectors[1:]) if has_cell.value else None

    def _wanted_array(self, name: str, word: str) -> npt.NDArray[Any]:
        if word not in self._wanted:
            raise AttributeError(f"{name} was not computed: put {word!r} into want, which was {self._wanted}")
        return self._arrays[name]

    def __len__(self) -> int:
        return len(self._points)

    def __repr__(self) -> str:
        wanted = ", ".join(self._wanted) or "status only"
        return f"<pyvotess.Tessellation of {len(self)} seeds in a {self._domain()}: {wanted}>"

    def _domain(self) -> str:
        def text(vector: Float64Array) -> str:
            return f"({', '.join(f'{x:g}' for x in vector)})"

        if self._cell is not None and self._origin is not None:
            where = f"cell {', '.join(text(edge) for edge in self._cell)} at {text(self._origin)}"
        else:
            where = f"box {text(self._box[0])} to {text(self._box[1])}"
        if len(self.walls):
            where += f" cut by {len(self.walls)} wall{'s' if len(self.walls) > 1 else ''}"
        axes = "".join(axis for axis, repeats in zip("xyz" if self._cell is None else "abc", self._periodic) if repeats)
        return where + (f", periodic {axes}" if axes else "") + ("" if self._domain_given else " around them")

    @property
    def neighbors(self) -> Neighbors:
        """Neighbor lists, N rows. Symmetric: i lists j exactly when j lists i."""
        if "neighbors" not in self._wanted:
            raise AttributeError(f"neighbors was not computed: put 'neighbors' into want, which was {self._wanted}")
        return self._neighbors

    @property
    def volumes(self) -> Float64Array:
        """(N,) float64, length unit cubed; 0 for a duplicate."""
        return self._wanted_array("volumes", "volumes")

    @property
    def face_areas(self) -> Float64Array:
        """(indptr[N],) float64, length unit squared: of the face behind each entry of ``neighbors.indices``.

        Those of walls only when the rows list walls. Row i is ``face_areas[indptr[i]:indptr[i+1]]``. The error is at
        most 1e-10 of the area of the cell's whole surface, 1e-5 when ``stats.precision`` is "single".
        """
        return self._wanted_array("face_areas", "areas")

    @property
    def areas(self) -> Float64Array:
        """The same as :attr:`face_areas`."""
        return self.face_areas

    @property
    def face_normals(self) -> Float64Array:
        """(indptr[N], 3) float64: outward unit normal of the face behind each entry of ``neighbors.indices``."""
        return self._wanted_array("face_normals", "normals")

    @property
    def shifts(self) -> Optional[Int8Array]:
        """(indptr[N], 3) int8: box vectors that carry each neighbor to where it touches; None unless periodic."""
        return self._shifts

    @property
    def surface_areas(self) -> Float64Array:
        """(N,) float64, area of the whole surface of each cell, walls included."""
        return self._wanted_array("surface_areas", "surfaces")

    @property
    def security_radii(self) -> Float64Array:
        """(N,) float64, twice the distance from the seed to the farthest vertex of its cell."""
        return self._wanted_array("security_radii", "radii")

    @property
    def vertices(self) -> Float64Array:
        """(V, 3) float64. Vertices that are equal in exact arithmetic are one, shared by all cells that have it."""
        return self._wanted_array("vertices", "vertices")

    @property
    def cell_vertices(self) -> Lists:
        """The vertices of each cell, ascending: N rows."""
        if "vertices" not in self._wanted:
            raise AttributeError(f"cell_vertices was not computed: put 'vertices' into want, which was {self._wanted}")
        return self._cell_vertices

    @property
    def faces(self) -> Faces:
        """The polygon behind each entry of ``neighbors.indices``, counterclockwise seen from outside the cell."""
        if "faces" not in self._wanted:
            raise AttributeError(f"faces was not computed: put 'faces' into want, which was {self._wanted}")
        return self._faces

    @property
    def least_face(self) -> float:
        """The area below which ``min_face`` or ``min_area`` has dropped faces; 0 when none were."""
        return float(lib.votess_result_least_face(self._result.pointer))

    def delaunay(self) -> Delaunay:
        """The dual Delaunay complex. Needs "faces" in want, and neither ``min_face`` nor ``min_area``."""
        handle = Handle(lib.votess_delaunay_free)
        raise_on_failure(lib.votess_delaunay_new(self._result.pointer, ctypes.byref(handle.pointer)))
        return make_delaunay(
            lambda name, dtype: array_of(handle, name, dtype, prefix="votess_delaunay_"), self._shifts is not None
        )

    @property
    def centroids(self) -> Float64Array:
        """(N, 3) float64, centers of mass in the coordinates of the points; NaN for a duplicate."""
        return self._wanted_array("centroids", "centroids")

    @property
    def face_counts(self) -> UInt32Array:
        """(N,) uint32, faces of each cell, walls included."""
        return self._wanted_array("face_counts", "counts")

    @property
    def edge_counts(self) -> UInt32Array:
        """(N,) uint32, edges of each cell."""
        return self._wanted_array("edge_counts", "counts")

    @property
    def vertex_counts(self) -> UInt32Array:
        """(N,) uint32, vertices of each cell."""
        return self._wanted_array("vertex_counts", "counts")

    @property
    def status(self) -> UInt8Array:
        """(N,) uint8, values of :class:`CellStatus`."""
        return self._status

    @property
    def duplicate_of(self) -> Optional[Int32Array]:
        """(N,) int32: index of the seed that keeps the cell, -1 when not a duplicate. None when there is none."""
        return self._duplicate_of

    @property
    def box(self) -> Float64Array:
        """(2, 3) float64, lower and upper corner of the domain that was used; of a triclinic one the bounds."""
        return self._box

    @property
    def periodic(self) -> Tuple[bool, bool, bool]:
        """Whether the domain repeats along x, y, z, or along the edges of ``cell``."""
        return self._periodic

    @property
    def cell(self) -> Optional[Float64Array]:
        """(3, 3) float64, the edges of a triclinic box, a row each; None for other domains."""
        return self._cell

    @property
    def origin(self) -> Optional[Float64Array]:
        """(3,) float64, the corner of a triclinic box; None for other domains."""
        return self._origin

    @property
    def walls(self) -> Float64Array:
        """(M, 4) float64, rows nx, ny, nz, d of the walls n.x <= d that were given."""
        return array_of(self._result, "walls", np.float64, columns=4)

    @property
    def weights(self) -> Optional[Float64Array]:
        """(N,) float64, the weights of a power diagram, of radii their squares; None for a Voronoi diagram."""
        weights = array_of(self._result, "weights", np.float64)
        return weights if len(weights) else None

    @property
    def lists_walls(self) -> bool:
        """Whether the rows hold wall ids."""
        return bool(lib.votess_result_lists_walls(self._result.pointer))

    @property
    def points(self) -> npt.NDArray[Any]:
        """(N, 3) the points as they were read: the array given, if it needed no conversion. :meth:`verify` uses it."""
        return self._points

    @property
    def wrapped_points(self) -> Float64Array:
        """(N, 3) float64, a new array: where the points lie inside a periodic domain. :attr:`shifts` count from there."""
        points = np.ascontiguousarray(self._points, dtype=np.float64)
        places = np.empty_like(points)
        raise_on_failure(
            lib.votess_wrapped_points(self._result.pointer, points.ctypes.data, len(points), places.ctypes.data)
        )
        return places

    def pairs(self) -> Pairs:
        """All entries of the rows but walls, so that each pair of neighbors is there from both sides."""
        return make_pairs(self)

    def voronoi_indices(self, edge_threshold: float = 0.0) -> Int64Array:
        """(N, M) int64: column k counts the faces of k + 3 edges; M is the least that holds all. Needs "faces" in want.

        Edges shorter than ``edge_threshold`` do not count, and faces that are left with fewer than three neither.
        """
        return count_edges(self, edge_threshold)

    @property
    def stats(self) -> Stats:
        """Counts and seconds per stage."""
        return self._stats

    def plot(
        self,
        slice: Optional[Tuple[str, float]] = None,
        color: Union[str, npt.ArrayLike] = "volume",
        ax: Any = None,
        **style: Any,
    ) -> Any:
        """Shows the cells; needs "faces" in want, and volumes unless another color is given.

        ``slice=("z", 0.5)`` draws the section by that plane with matplotlib, into ``ax`` or a new figure, and returns
        the axes. Without a slice PyVista, where it is installed, shows the cells in space without those of one octant,
        and the plotter is returned (``t.plot().show()``); else the section through the middle is drawn.
        ``color``: "volume", "neighbors", "area", "x", "y", "z", or one value for each cell. ``style`` goes to
        matplotlib's PolyCollection or to PyVista's add_mesh, such as ``cmap="magma"``.
        """
        from ._plot import plot

        return plot(self, slice, color, ax, **style)

    def verify(self, sample: Optional[int] = None, rng_seed: int = 1) -> VerifyReport:
        """Checks this result against its points.

        Volumes sum to the box (relative 1e-9; 1e-4 when ``stats.precision`` is "single"), neighbor lists are symmetric,
        Euler's formula holds, and ``sample`` cells drawn with ``rng_seed`` equal cells cut anew by every seed; None takes
        as many as take about a second, at least 64 or all, a number that depends on the input alone. Checks whose
        arrays were not wanted are skipped.
        """
        points = np.ascontiguousarray(self._points, dtype=np.float64)
        bits = 8 * ctypes.sizeof(ctypes.c_size_t)
        count = _c_api.SAMPLE_AUTOMATIC if sample is None else as_count(sample, "sample", bits)
        passed, skipped, sampled = ctypes.c_int(), ctypes.c_uint32(), ctypes.c_size_t()
        failure = ctypes.create_string_buffer(1024)
        raise_on_failure(
            lib.votess_verify(
                self._result.pointer,
                points.ctypes.data,
                len(points),
                count,
                as_count(rng_seed, "rng_seed", 64),
                ctypes.byref(passed),
                ctypes.byref(skipped),
                ctypes.byref(sampled),
                failure,
                len(failure),
            )
        )
        names = tuple(name for name, bit in _c_api.CHECK_BITS.items() if skipped.value & bit)
        return VerifyReport(bool(passed.value), failure.value.decode("utf-8", "replace"), names, sampled.value)
