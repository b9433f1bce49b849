"""tessellate(), the Tessellator that keeps device and buffers, and the list of devices."""

from __future__ import annotations

import contextlib
import ctypes
import threading
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Iterable, Iterator, List, Optional, Union

from . import _c_api
from ._c_api import DuplicatesWord, ErrorCode, OutsideWord, PrecisionWord, WantName
from ._call import Handle, Progress, VotessError, raise_on_failure
from ._input import Domain
from ._library import lib
from ._run import new_options, tessellate_points
from .tessellation import Tessellation

if TYPE_CHECKING:
    from types import TracebackType

    import numpy.typing as npt


def tessellate(
    points: npt.ArrayLike,
    box: Optional[npt.ArrayLike] = None,
    periodic: Optional[Union[bool, str, Iterable[bool]]] = None,
    weights: Optional[npt.ArrayLike] = None,
    radii: Optional[npt.ArrayLike] = None,
    want: Union[str, Iterable[WantName]] = ("neighbors", "volumes"),
    cell: Optional[npt.ArrayLike] = None,
    walls: npt.ArrayLike = (),
    list_walls: bool = False,
    device: str = "auto",
    threads: int = 0,
    precision: PrecisionWord = "single",
    duplicates: DuplicatesWord = "merge",
    progress: Union[None, bool, Progress] = None,
    origin: Optional[npt.ArrayLike] = None,
    outside: OutsideWord = "error",
    min_face: float = 0.0,
    min_area: float = 0.0,
    grid_resolution: int = 0,
    k_init: int = 0,
    chunk_size: int = 0,
    instructions: str = "",
) -> Tessellation:
    """Returns the Voronoi cells of ``points``. The neighbor lists are exact for the given coordinates.

    Parameters
    ----------
    points : (N, 3) array of real numbers, any length unit; N may be 0.
        float64 and float32 in C order are copied; other arrays are converted without loss. If another thread changes
        the array during the call, cells are wrong, but nothing crashes.
    box : (x0, y0, z0, x1, y1, z1), ((x0, y0, z0), (x1, y1, z1)) or ((x0, x1), (y0, y1), (z0, z1)), the domain.
        Default: the bounds of the points, each side moved out by half of (longest side / cbrt(N)).
        A point outside is an error.
    periodic : True, axes such as "xy", or three flags. The box must be given, and points outside are wrapped into it.
        ``shifts`` is the image of each neighbor. x, y, z mean the edges of a ``cell``.
        Default: a box is not periodic, a cell is along all edges.
    weights, radii : (N,) numbers for a power diagram, with these weights or the squares of these radii. A seed with an
        empty cell has status EMPTY.
    want : names of arrays of the result, as a sequence or one string with commas: "volumes", "centroids",
        "face_areas", "face_normals", "surface_areas", "security_radii", "face_counts", "vertices", "face_offsets" and
        others. Words for groups of arrays: "neighbors" (indptr, indices, shifts), "counts" (face_counts, edge_counts,
        vertex_counts), "areas", "normals", "surfaces", "radii", "vertices" (vertices, cell_vertices) and "faces"
        (face_offsets, face_vertices). A name requests its whole group. Arrays with one row for each neighbor add
        "neighbors"; "faces" adds "vertices", and walls to the rows.
    cell, origin : a triclinic box instead of ``box``: its edges as rows, and its corner. It is periodic along all
        edges, or those of ``periodic``; elsewhere its faces are walls.
    walls : (M, 4) rows nx, ny, nz, d: walls that keep n.x <= d, with the ids -7, -8, ...; not in a periodic domain.
    list_walls : list walls in the rows: -1..-6 = xmin, xmax, ymin, ymax, zmin, zmax, of a
        ``cell`` across its edges a, b, c in the same order, then those of ``walls``.
    device : "auto" = the first GPU, else the CPU; "cpu"; "gpu" = the first GPU; "lavapipe" = the first Vulkan device
        that is software; or an ``id`` of :func:`devices`. A missing device raises VotessError. "auto" uses the CPU for
        fewer than 10,000 points, which it finishes before a GPU is found.
    precision : of volumes, centroids and areas from a GPU: "single", relative error 1e-5, or "double", 1e-10. The CPU always
        gives 1e-10; the neighbor lists are exact either way.
    threads, grid_resolution, k_init, chunk_size : tuning, 0 = automatic. They change speed and memory, never the
        lists. CPU threads, at most 1024; blocks along an axis of the sorting grid, at most 2**20; on a GPU the nearest
        neighbors tried first for each cell, at most 1024, and the cells in flight.
    instructions : of the CPU: "baseline", "avx2", "avx512", or "" for the best available; never changes the lists.
        A set that the CPU lacks raises VotessError.
    duplicates : "merge": the lowest index of equal points keeps the cell; "error": they raise ValueError.
    min_face : drop faces between two cells that are smaller than this times the mean area, from rows, areas, normals,
        polygons and face_counts. Each pair of cells is decided once. 0 drops nothing.
    min_area : the same for faces below this area, length unit squared.
    outside : points outside of ``box`` or ``walls``: "error" raises ValueError, "drop" gives them an empty cell with
        status OUTSIDE.
    progress : True shows a bar of tqdm if it is installed, else a line on stderr. A callable is called about ten times
        a second with the fraction done. If it returns False, the run stops with :class:`VotessError`; its exceptions
        stop the run and reach the caller.

    The GIL is released. Ctrl-C in the main thread stops the run and raises KeyboardInterrupt.

    Raises
    ------
    ValueError : bad input; the message names the first offending index and value.
    MemoryError, VotessError : the run failed; ``VotessError.code`` is UNSUPPORTED for a missing device, DEVICE_LOST
        for one that failed.
    """
    options = new_options(device, threads, precision, grid_resolution, k_init, chunk_size, instructions)
    domain = Domain(box, periodic, weights, radii, cell, origin, walls, outside)
    return Tessellation(
        *tessellate_points(
            None, options, points, domain, want, list_walls, duplicates, progress, min_face, min_area
        ),
        domain.is_given,
    )


class Tessellator:
    """Keeps device, threads and buffers between calls. A context manager; otherwise freed with the object.

    Use one for points that move from call to call. A result whose arrays are all gone leaves its memory to the next
    one, so calls of the same size allocate nothing.

    The options are those of :func:`tessellate`. Each call checks their limits.

    One call at a time: a second one, from another thread or a progress callback, raises VotessError with code
    INVALID_USE. Results outlive the tessellator, and many threads may read them.

    After a fork (``os.fork``, multiprocessing with the start method "fork") the child may use and close its copy, with
    new CPU threads. A GPU from before the fork raises VotessError with code UNSUPPORTED; device "auto" uses the CPU.
    """

    def __init__(
        self,
        device: str = "auto",
        threads: int = 0,
        precision: PrecisionWord = "single",
        grid_resolution: int = 0,
        k_init: int = 0,
        chunk_size: int = 0,
        instructions: str = "",
        ) -> None:
        self._options = new_options(
            device, threads, precision, grid_resolution, k_init, chunk_size, instructions
        )
        self._lock = threading.Lock()
        self._handle = Handle(lib.votess_tessellator_free)
        raise_on_failure(lib.votess_tessellator_new(ctypes.byref(self._handle.pointer)))

    @contextlib.contextmanager
    def _alone(self) -> Iterator[None]:
        if not self._lock.acquire(blocking=False):
            raise VotessError(
                "this Tessellator is in use by another call, or was during fork(): use one for each thread",
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
        periodic: Optional[Union[bool, str, Iterable[bool]]] = None,
        weights: Optional[npt.ArrayLike] = None,
        radii: Optional[npt.ArrayLike] = None,
        want: Union[str, Iterable[WantName]] = ("neighbors", "volumes"),
        cell: Optional[npt.ArrayLike] = None,
        walls: npt.ArrayLike = (),
        list_walls: bool = False,
        duplicates: DuplicatesWord = "merge",
        progress: Union[None, bool, Progress] = None,
        origin: Optional[npt.ArrayLike] = None,
        outside: OutsideWord = "error",
        min_face: float = 0.0,
        min_area: float = 0.0,
    ) -> Tessellation:
        """As :func:`tessellate`. ValueError after :meth:`close`."""
        domain = Domain(box, periodic, weights, radii, cell, origin, walls, outside)
        with self._alone():
            if not self._handle.pointer:
                raise ValueError("this Tessellator is closed")
            options = _c_api.Options.from_buffer_copy(self._options)  # the original owns its texts
            return Tessellation(
                *tessellate_points(
                    self._handle, options, points, domain, want, list_walls, duplicates, progress, min_face, min_area
                ),
                domain.is_given,
            )

    def close(self) -> None:
        """Frees device and buffers. Further calls do nothing."""
        with self._alone():
            self._handle.free()

    def __reduce__(self) -> Any:
        raise TypeError("a Tessellator cannot be copied or pickled: create another one")

    def __enter__(self) -> Tessellator:
        return self

    def __exit__(
        self,
        kind: Optional[type[BaseException]],
        error: Optional[BaseException],
        traceback: Optional[TracebackType],
    ) -> None:
        self.close()


@dataclass(frozen=True)
class DeviceInfo:
    """A usable device. Pass ``id`` as ``device=``."""

    id: str
    name: str
    description: str  #: limits and features in one line


def devices() -> List[DeviceInfo]:
    """Returns the devices of this machine that votess can use."""
    found = []
    for index in range(lib.votess_device_count()):
        texts = [ctypes.create_string_buffer(size) for size in (256, 256, 4096)]
        sized = [argument for text in texts for argument in (text, len(text))]
        raise_on_failure(lib.votess_device_info(index, *sized))
        found.append(DeviceInfo(*(text.value.decode("utf-8", "replace") for text in texts)))
    return found
