"""Tessellate points; read, check and convert the result."""

from __future__ import annotations

import contextlib
import ctypes
import signal
import threading
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Callable, Dict, Iterable, Iterator, List, Optional, Tuple, Union

import numpy as np

from . import _c_api
from ._c_api import ErrorCode
from ._input import Domain, as_count, as_kernel, as_points, as_precision, as_text, as_want
from ._library import lib
from .mesh import Delaunay, Faces, Lists, make_delaunay

if TYPE_CHECKING:
    from types import FrameType, TracebackType

    import numpy.typing as npt

    Float64Array = npt.NDArray[np.float64]
    Int8Array = npt.NDArray[np.int8]
    Int64Array = npt.NDArray[np.int64]
    Int32Array = npt.NDArray[np.int32]
    UInt32Array = npt.NDArray[np.uint32]
    UInt8Array = npt.NDArray[np.uint8]

#: Called some ten times a second with the fraction done, 0 to 1. Return False to stop the run; None goes on.
Progress = Callable[[float], Optional[bool]]


class VotessError(RuntimeError):
    """A failed run that is not the fault of the input. ``code`` says why."""

    def __init__(self, message: str, code: ErrorCode) -> None:
        super().__init__(message, code)
        self.code = code

    def __str__(self) -> str:
        return str(self.args[0])


def _raise_on_failure(status: int) -> None:
    if status == _c_api.OK:
        return
    message = lib.votess_last_error().decode("utf-8", "replace")
    if status == ErrorCode.INVALID_ARGUMENT:
        raise ValueError(message)
    if status == ErrorCode.OUT_OF_MEMORY:
        raise MemoryError(message)
    raise VotessError(message, ErrorCode(status))


class _Handle:
    """Owns one object of the library."""

    def __init__(self, free: Callable[[ctypes.c_void_p], None]) -> None:
        self.pointer = ctypes.c_void_p()
        self._free = free  # kept here: module globals may be gone when the interpreter ends

    def free(self) -> None:
        if self.pointer:
            self._free(self.pointer)
            self.pointer.value = None

    def __del__(self) -> None:
        self.free()

    def __reduce__(self) -> Any:
        raise TypeError("a result of votess cannot be pickled or deep-copied: take its arrays")


class _Memory:
    """What NumPy needs to wrap an array of the library. It becomes the base of the ndarray and keeps the owner alive."""

    def __init__(self, owner: _Handle, address: int, shape: Tuple[int, ...], dtype: np.dtype[Any]) -> None:
        self._owner = owner
        self.__array_interface__ = {
            "version": 3,
            "shape": shape,
            "typestr": dtype.str,
            "data": (address, True),  # True: read-only
        }


def _array(
    result: _Handle, name: str, dtype: Any, columns: int = 0, prefix: str = "votess_result_"
) -> npt.NDArray[Any]:
    """Read-only view, without a copy, of ``<prefix><name>``; shape (length,) or (length / columns, columns)."""
    length = ctypes.c_size_t()
    address = getattr(lib, prefix + name)(result.pointer, ctypes.byref(length))
    shape = (length.value // columns, columns) if columns else (length.value,)
    if not address:
        array = np.empty(shape, dtype)
        array.flags.writeable = False
        return array
    return np.asarray(_Memory(result, address, shape, np.dtype(dtype)))


def _new_options(
    device: str,
    threads: int,
    precision: str,
    grid_resolution: int,
    k_init: int,
    chunk_size: int,
    instructions: str = "",
    kernel: str = "automatic",
) -> _c_api.Options:
    options = _c_api.Options()
    _raise_on_failure(lib.votess_options_init(ctypes.byref(options), ctypes.sizeof(options)))
    options.device = as_text(device, "device")
    options.threads = as_count(threads, "threads", 32)
    options.precision = as_precision(precision)
    options.grid_resolution = as_count(grid_resolution, "grid_resolution", 32)
    options.k_init = as_count(k_init, "k_init", 32)
    options.chunk_size = as_count(chunk_size, "chunk_size", 32)
    options.instructions = as_text(instructions, "instructions")
    options.kernel = as_kernel(kernel)
    return options


# ---- the run ----


@contextlib.contextmanager
def _storing_interrupts(raised: List[BaseException]) -> Iterator[bool]:
    """While a run lasts, what the handler of Ctrl-C raises goes to ``raised``. Yields whether that is so.

    Raised inside a ctypes callback it would be printed and lost. Only the main thread gets signals in Python.
    """
    previous = signal.getsignal(signal.SIGINT)
    if threading.current_thread() is not threading.main_thread() or not callable(previous):
        yield False
        return

    def handler(number: int, frame: Optional[FrameType]) -> None:
        try:
            previous(number, frame)
        except BaseException as error:
            raised.append(error)

    try:
        signal.signal(signal.SIGINT, handler)
    except ValueError:  # a sub-interpreter has no signals
        yield False
        return
    try:
        yield True
    finally:
        signal.signal(signal.SIGINT, previous)


def _run(function: Any, arguments: Tuple[Any, ...], options: _c_api.Options, out: Any, progress: Any) -> None:
    raised: List[BaseException] = []

    def on_progress(fraction: float, _user: Any) -> int:
        try:
            if not raised and progress is not None:
                answer = progress(fraction)
                return 1 if answer is None or answer else 0
        except BaseException as error:
            raised.append(error)
        return 0 if raised else 1

    with _storing_interrupts(raised) as storing:
        if storing or progress is not None:
            options.progress = _c_api.ProgressCallback(on_progress)
        status = function(*arguments, ctypes.byref(options), out)
    if raised:
        try:
            raise raised[0]
        finally:
            raised.clear()  # the traceback holds this frame, which holds the list
    _raise_on_failure(status)


def _tessellate(
    tessellator: Optional[_Handle],
    options: _c_api.Options,
    points: Any,
    domain: Domain,
    want: Union[str, Iterable[str]],
    walls: bool,
    duplicates: str,
    progress: Optional[Progress],
    min_face: float = 0.0,
) -> Tessellation:
    array = as_points(points)
    wanted = as_want(want)
    options.min_face = float(min_face)
    if options.min_face > 0:
        wanted = as_want((*wanted, "areas"))
    options.want = sum(_c_api.WANT_BITS[word] for word in wanted)
    options.walls = bool(walls)
    if duplicates not in _c_api.DUPLICATES:
        raise ValueError(f"duplicates is {duplicates!r}: the words are {', '.join(_c_api.DUPLICATES)}")
    options.duplicates = _c_api.DUPLICATES[duplicates]
    kept = domain.fill(options, len(array))
    if progress is not None and not callable(progress):
        raise TypeError(f"progress must be callable, not {type(progress).__name__}")

    function = lib.votess_tessellate_f32 if array.dtype == np.float32 else lib.votess_tessellate
    result = _Handle(lib.votess_result_free)
    arguments = (tessellator.pointer if tessellator else None, array.ctypes.data, len(array))
    _run(function, arguments, options, ctypes.byref(result.pointer), progress)
    del kept
    return Tessellation(result, array, wanted)


def tessellate(
    points: npt.ArrayLike,
    box: Optional[npt.ArrayLike] = None,
    periodic: Union[bool, str, Iterable[bool]] = False,
    weights: Optional[npt.ArrayLike] = None,
    radii: Optional[npt.ArrayLike] = None,
    want: Union[str, Iterable[str]] = ("neighbors", "volumes"),
    walls: bool = False,
    device: str = "auto",
    threads: int = 0,
    precision: str = "single",
    grid_resolution: int = 0,
    k_init: int = 0,
    chunk_size: int = 0,
    duplicates: str = "merge",
    progress: Optional[Progress] = None,
    instructions: str = "",
    min_face: float = 0.0,
    cell: Optional[npt.ArrayLike] = None,
    origin: Optional[npt.ArrayLike] = None,
    planes: Optional[npt.ArrayLike] = None,
    outside: str = "error",
    kernel: str = "automatic",
) -> Tessellation:
    """Voronoi cells of ``points`` in a box. The neighbor lists are exact for the coordinates as given.

    Parameters
    ----------
    points : (N, 3) array of real numbers, any length unit; N may be 0.
        float64 and float32 in C order are read in place; other arrays are converted, without loss. Not to be
        changed by another thread meanwhile.
    box : (x0, y0, z0, x1, y1, z1) or ((x0, y0, z0), (x1, y1, z1)), the domain.
        Default: the bounds of the points, each side moved out by half of (longest side / cbrt(N)).
        A point outside of it is an error.
    periodic : True, or axes such as "xy", or three flags: the box repeats; points beyond it are wrapped into it.
        ``shifts`` tells which image a neighbor is.
    weights, radii : (N,) numbers: a power diagram, with these weights or the squares of these radii. A seed whose cell
        is empty has status EMPTY.
    want : words out of "neighbors", "volumes", "centroids", "counts", "areas", "normals", "surfaces", "radii",
        "vertices", "faces", as a sequence or with commas in one string. What belongs to entries of the rows adds
        "neighbors"; "faces" adds "vertices", and the walls to the rows.
    walls : list the walls in the rows too: -1..-6 = xmin, xmax, ymin, ymax, zmin, zmax, then those of ``planes``.
    device : "auto" = the first GPU, else the CPU; "cpu"; "gpu" = the first GPU; "lavapipe" = the first Vulkan device
        that is software; or an ``id`` out of :func:`devices`. One that cannot be had raises VotessError.
    precision : of volumes, centroids and areas from a GPU: "single", relative error 1e-5, or "double", 1e-10. The CPU always
        gives 1e-10; the neighbor lists are exact either way.
    threads, grid_resolution, k_init, chunk_size : tuning, 0 = automatic. They change speed and memory, never the
        answer. CPU threads, at most 1024; blocks along an axis of the sorting grid, at most 2**20; on a GPU nearest
        neighbors tried first for each cell, at most 1024, and cells in flight at once.
    instructions : of the CPU: "baseline", "avx2", "avx512", or "" for the best that it has; never changes the lists.
        One that it lacks raises VotessError.
    duplicates : "merge": the lowest index of equal points keeps the cell; "error": refuse them.
    min_face : drop faces between two cells that are smaller than this times their mean area, from rows, areas,
        normals, polygons and face_counts; decided once per pair of cells. 0 drops nothing.
    cell, origin : a triclinic periodic box instead of ``box``: the vectors of its edges, a row each, and its corner.
    planes : (M, 4) rows nx, ny, nz, d: walls that keep n.x <= d, with the ids -7, -8, ...; not in a periodic domain.
    outside : of points outside of ``box`` or ``planes``: "error" refuses them, "drop" gives them an empty cell, status OUTSIDE.
    kernel : who makes a cell on a GPU: "invocation", each shader invocation one; "subgroup", the invocations of a subgroup
        together; "automatic" chooses by device. Changes speed and memory, never the answer. "subgroup" where subgroups
        cannot raises VotessError.
    progress : called some ten times a second with the fraction done; returning False stops the run with
        :class:`VotessError`, an exception stops it and goes on to the caller.

    The GIL is released. Ctrl-C in the main thread stops the run and raises KeyboardInterrupt.

    Raises
    ------
    ValueError : bad input; the message names the first offending index and value.
    MemoryError, VotessError : the run failed; ``VotessError.code`` is UNSUPPORTED when the device cannot be had,
        DEVICE_LOST when it failed.
    """
    options = _new_options(device, threads, precision, grid_resolution, k_init, chunk_size, instructions, kernel)
    domain = Domain(box, periodic, weights, radii, cell, origin, planes, outside)
    return _tessellate(None, options, points, domain, want, walls, duplicates, progress, min_face)


class Tessellator:
    """Keeps device, threads and buffers between calls. A context manager; otherwise freed with the object.

    The memory of a result that is gone, its arrays too, serves the next one: calls of the same size take no new memory.
    Points that move from call to call are tessellated by one Tessellator that is kept.

    The options are those of :func:`tessellate`; the limits of their values are checked at each call.

    One call at a time: a second one, from another thread or from a progress callback, raises VotessError with code
    INVALID_USE. Results do not need the tessellator and outlive it, and may be read by many threads.

    After a fork (``os.fork``, multiprocessing with the start method "fork") the child may use and close its copy: the
    CPU gets new threads. A GPU that was opened before cannot be used there: VotessError with code UNSUPPORTED, or with
    device "auto" the CPU takes over.
    """

    def __init__(
        self,
        device: str = "auto",
        threads: int = 0,
        precision: str = "single",
        grid_resolution: int = 0,
        k_init: int = 0,
        chunk_size: int = 0,
        instructions: str = "",
        kernel: str = "automatic",
    ) -> None:
        self._options = _new_options(
            device, threads, precision, grid_resolution, k_init, chunk_size, instructions, kernel
        )
        self._lock = threading.Lock()
        self._handle = _Handle(lib.votess_tessellator_free)
        _raise_on_failure(lib.votess_tessellator_new(ctypes.byref(self._handle.pointer)))

    @contextlib.contextmanager
    def _alone(self) -> Iterator[None]:
        if not self._lock.acquire(blocking=False):
            raise VotessError(
                "this Tessellator is in use by another call, or was when fork() made this process: use one per thread",
                ErrorCode.INVALID_USE,
            )
        try:
            yield
        finally:
            self._lock.release()

    def tessellate(
        self,
        points: npt.ArrayLike,
        box: Optional[npt.ArrayLike] = None,
        periodic: Union[bool, str, Iterable[bool]] = False,
        weights: Optional[npt.ArrayLike] = None,
        radii: Optional[npt.ArrayLike] = None,
        want: Union[str, Iterable[str]] = ("neighbors", "volumes"),
        walls: bool = False,
        duplicates: str = "merge",
        progress: Optional[Progress] = None,
        min_face: float = 0.0,
        cell: Optional[npt.ArrayLike] = None,
        origin: Optional[npt.ArrayLike] = None,
        planes: Optional[npt.ArrayLike] = None,
        outside: str = "error",
    ) -> Tessellation:
        """As :func:`tessellate`. ValueError after :meth:`close`."""
        domain = Domain(box, periodic, weights, radii, cell, origin, planes, outside)
        with self._alone():
            if not self._handle.pointer:
                raise ValueError("this Tessellator is closed")
            options = _c_api.Options.from_buffer_copy(self._options)  # its texts stay owned by the original
            return _tessellate(self._handle, options, points, domain, want, walls, duplicates, progress, min_face)

    def close(self) -> None:
        """Frees device and buffers. Harmless when repeated."""
        with self._alone():
            self._handle.free()

    def __reduce__(self) -> Any:
        raise TypeError("a Tessellator cannot be copied or pickled: make another one")

    def __enter__(self) -> Tessellator:
        return self

    def __exit__(
        self,
        kind: Optional[type[BaseException]],
        error: Optional[BaseException],
        traceback: Optional[TracebackType],
    ) -> None:
        self.close()


# ---- the result ----


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


def _read_stats(result: _Handle) -> Stats:
    c_stats = _c_api.Stats(struct_size=ctypes.sizeof(_c_api.Stats))
    _raise_on_failure(lib.votess_result_stats(result.pointer, ctypes.byref(c_stats)))
    fields: Dict[str, Any] = {field[0]: getattr(c_stats, field[0]) for field in _c_api.Stats._fields_}
    del fields["struct_size"], fields["reserved"]
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


class Tessellation:
    """The cells of N seeds; rows follow the input order.

    Arrays are read-only and lie in the library's memory, which lives as long as any of them. An array that was not
    wanted raises AttributeError.
    """

    def __init__(self, result: _Handle, points: npt.NDArray[Any], wanted: Tuple[str, ...]) -> None:
        self._result = result
        self._points = points
        self._wanted = wanted
        self._stats = _read_stats(result)
        self._arrays: Dict[str, npt.NDArray[Any]] = {}
        if "neighbors" in wanted:
            self._neighbors = Neighbors(_array(result, "indptr", np.int64), _array(result, "indices", np.int32))
        if "areas" in wanted:
            self._arrays["face_areas"] = _array(result, "face_areas", np.float64)
        if "normals" in wanted:
            self._arrays["face_normals"] = _array(result, "face_normals", np.float64, columns=3)
        if "surfaces" in wanted:
            self._arrays["surface_areas"] = _array(result, "surface_areas", np.float64)
        if "radii" in wanted:
            self._arrays["security_radii"] = _array(result, "security_radii", np.float64)
        if "vertices" in wanted:
            self._arrays["vertices"] = _array(result, "vertices", np.float64, columns=3)
            self._cell_vertices = Lists(
                _array(result, "cell_vertex_indptr", np.int64), _array(result, "cell_vertex_indices", np.int32)
            )
        if "faces" in wanted:
            self._faces = Faces(_array(result, "face_offsets", np.int64), _array(result, "face_vertices", np.int32))
        shifts = _array(result, "shifts", np.int8, columns=3)
        self._shifts = shifts if len(shifts) else None
        if "volumes" in wanted:
            self._arrays["volumes"] = _array(result, "volumes", np.float64)
        if "centroids" in wanted:
            self._arrays["centroids"] = _array(result, "centroids", np.float64, columns=3)
        if "counts" in wanted:
            for name in ("face_counts", "edge_counts", "vertex_counts"):
                self._arrays[name] = _array(result, name, np.uint32)
        self._status = _array(result, "status", np.uint8)
        duplicate_of = _array(result, "duplicate_of", np.int32)
        self._duplicate_of = duplicate_of if len(duplicate_of) else None
        lower, upper = (ctypes.c_double * 3)(), (ctypes.c_double * 3)()
        _raise_on_failure(lib.votess_result_box(result.pointer, lower, upper))
        self._box = np.array((lower, upper), dtype=np.float64)
        self._box.flags.writeable = False

    def _wanted_array(self, name: str, word: str) -> npt.NDArray[Any]:
        if word not in self._wanted:
            raise AttributeError(f"{name} was not computed: put {word!r} into want, which was {self._wanted}")
        return self._arrays[name]

    def __len__(self) -> int:
        return len(self._points)

    def __repr__(self) -> str:
        return f"<pyvotess.Tessellation of {len(self)} seeds: {', '.join(self._wanted) or 'status only'}>"

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
        """The area below which ``min_face`` has dropped faces; 0 when none were."""
        return float(lib.votess_result_least_face(self._result.pointer))

    def delaunay(self) -> Delaunay:
        """The dual Delaunay complex. Needs "faces" in want, and no ``min_face``."""
        handle = _Handle(lib.votess_delaunay_free)
        _raise_on_failure(lib.votess_delaunay_new(self._result.pointer, ctypes.byref(handle.pointer)))
        return make_delaunay(
            lambda name, dtype: _array(handle, name, dtype, prefix="votess_delaunay_"), self._shifts is not None
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
        """(2, 3) float64, lower and upper corner of the domain that was used."""
        return self._box

    @property
    def lists_walls(self) -> bool:
        """Whether the rows hold wall ids."""
        return bool(lib.votess_result_lists_walls(self._result.pointer))

    @property
    def points(self) -> npt.NDArray[Any]:
        """(N, 3) the points as they were read: the array given, if it needed no conversion. :meth:`verify` uses it."""
        return self._points

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
        _raise_on_failure(
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


# ---- devices ----


@dataclass(frozen=True)
class DeviceInfo:
    """A device that can run; ``id`` is what ``device=`` accepts."""

    id: str
    name: str
    description: str  #: limits and features in one line


def devices() -> List[DeviceInfo]:
    """The devices of this machine that votess can use."""
    found = []
    for index in range(lib.votess_device_count()):
        texts = [ctypes.create_string_buffer(size) for size in (256, 256, 4096)]
        sized = [argument for text in texts for argument in (text, len(text))]
        _raise_on_failure(lib.votess_device_info(index, *sized))
        found.append(DeviceInfo(*(text.value.decode("utf-8", "replace") for text in texts)))
    return found
