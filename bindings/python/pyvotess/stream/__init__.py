"""Seeds that do not fit into memory: they come in pieces, wait in temporary files, and rows go out in pieces.

>>> pieces = [np.random.default_rng(k).random((1000, 3)) for k in range(5)]
>>> volumes = np.empty(5000)
>>> def take(rows):
...     volumes[rows.first : rows.first + len(rows)] = rows.volumes
>>> vt.tessellate_stream(pieces, take, memory=1_000_000, box=(0, 0, 0, 1, 1, 1)).blocks
4
"""

from __future__ import annotations

import ctypes
import os
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Callable, Iterable, Iterator, Optional, Tuple, Union

import numpy as np

from .. import _c_api
from .._c_api import OutsideWord, WantName
from .._call import Callbacks, Progress, raise_on_failure, showing
from .._input import Domain, as_count, as_one_each, as_points, as_text, as_want
from .._run import new_options
from .._state import no_attribute
from ..stats import Stats, VerifyReport, stats_of
from . import _stream_api as _stream

if TYPE_CHECKING:
    import numpy.typing as npt

    Float64Array = npt.NDArray[np.float64]
    Int64Array = npt.NDArray[np.int64]
    Int8Array = npt.NDArray[np.int8]
    UInt8Array = npt.NDArray[np.uint8]
    UInt32Array = npt.NDArray[np.uint32]

__all__ = ["StreamResult", "StreamRows", "tessellate_stream"]


@dataclass(frozen=True)
class StreamRows:
    """The cells of n seeds, from ``first`` on, which follow those before. None for arrays that are not wanted.

    As the arrays of :class:`Tessellation`, but ids are int64.
    """

    first: int
    status: UInt8Array  #: (n,) :class:`CellStatus`
    duplicate_of: Optional[Int64Array]  #: (n,) where the run has duplicates
    indptr: Optional[Int64Array]  #: (n + 1,), counted from the first seed of the run on
    indices: Optional[Int64Array]  #: (entries,) neighbors, row by row
    shifts: Optional[Int8Array]  #: (entries, 3), where the domain is periodic
    face_areas: Optional[Float64Array]  #: (entries,)
    face_normals: Optional[Float64Array]  #: (entries, 3)
    volumes: Optional[Float64Array]  #: (n,)
    centroids: Optional[Float64Array]  #: (n, 3)
    surface_areas: Optional[Float64Array]  #: (n,)
    security_radii: Optional[Float64Array]  #: (n,)
    face_counts: Optional[UInt32Array]  #: (n,), as the two below
    edge_counts: Optional[UInt32Array]
    vertex_counts: Optional[UInt32Array]

    if not TYPE_CHECKING:  # which would allow any name

        def __getattr__(self, name: str) -> Any:
            raise no_attribute(self, name)

    def __len__(self) -> int:
        return len(self.status)

    def neighbors(self, k: int) -> Int64Array:
        """Row k of these, that of seed ``first + k``."""
        if self.indptr is None or self.indices is None:
            raise ValueError("neighbors were not wanted")
        row = range(len(self))[k]
        begin, end = self.indptr[row : row + 2] - self.indptr[0]
        return self.indices[begin:end]


@dataclass(frozen=True)
class StreamResult:
    """What a run did."""

    box: Optional[Float64Array]  #: (2, 3) the box that was given or assumed; None where a cell was given
    stats: Stats
    blocks: int
    largest_block: int  #: seeds of the largest one
    asked_cells: int  #: that were completed by other blocks
    temporary_bytes: int  #: in all files
    verified: Optional[VerifyReport] = None  #: with ``verify=True``


class _Source:
    """Between the library and what the user gave: functions for the library to call."""

    def __init__(self, pieces: Iterable[Any], rows: Callable[[StreamRows], Any], beside: Optional[str]) -> None:
        self._pieces, self._rows, self._beside = pieces, rows, beside
        self._iterator: Iterator[Any] = iter(pieces)
        self._again = self._iterator is not pieces
        self._held: Tuple[Any, ...] = ()
        self.box: Optional[Float64Array] = None

    def restart(self, _user: Any) -> int:
        if self._again:
            self._iterator = iter(self._pieces)
        return _stream.GO_ON if self._again else _stream.END

    def next(self, seeds: Any) -> int:
        try:
            piece = next(self._iterator)
        except StopIteration:
            return _stream.END
        points, numbers = piece if self._beside else (piece, None)
        array = np.ascontiguousarray(as_points(points, "a piece of points"), dtype=np.float64)
        self._held = (array,)
        seeds[0].count, seeds[0].points = len(array), array.ctypes.data
        if self._beside:
            beside = as_one_each(numbers, self._beside, len(array), "points")
            self._held = (array, beside)
            setattr(seeds[0], self._beside, beside.ctypes.data)
        return _stream.GO_ON

    def begin(self, head: Any) -> int:
        self.box = np.array([head[0].box_lower[:], head[0].box_upper[:]])
        return _stream.GO_ON

    def rows(self, rows: Any) -> int:
        some = rows[0]
        counts = {"count": some.count, "more": some.count + 1, "entries": some.entries}

        def array(name: str) -> Any:
            dtype, columns, of = _stream.ARRAYS[name]
            address = getattr(some, name)
            if not address:
                empty = name == "status" or (name == "neighbors" and some.indptr)
                return np.empty(0, dtype) if empty else None
            shape = (counts[of], columns) if columns else (counts[of],)
            size = counts[of] * (columns or 1) * np.dtype(dtype).itemsize
            return np.frombuffer(ctypes.string_at(address, size), dtype).reshape(shape)

        arrays = {name: array(name) for name in _stream.ARRAYS}
        arrays["indices"] = arrays.pop("neighbors")
        self._rows(StreamRows(some.first, **arrays))
        return _stream.GO_ON


def tessellate_stream(
    pieces: Iterable[Any],
    rows: Callable[[StreamRows], Any],
    memory: int,
    temporary: Optional[Union[str, "os.PathLike[str]"]] = None,
    beside: Optional[str] = None,
    box: Optional[npt.ArrayLike] = None,
    periodic: Optional[Union[bool, str, Iterable[bool]]] = None,
    want: Union[str, Iterable[WantName]] = ("neighbors", "volumes"),
    cell: Optional[npt.ArrayLike] = None,
    walls: npt.ArrayLike = (),
    list_walls: bool = False,
    threads: int = 0,
    progress: Union[None, bool, Progress] = None,
    origin: Optional[npt.ArrayLike] = None,
    outside: OutsideWord = "error",
    instructions: str = "",
    verify: bool = False,
) -> StreamResult:
    """Voronoi cells of points that do not fit into memory; on the CPU. The rows are those of :func:`tessellate`.

    Parameters
    ----------
    pieces : any iterable of (n, 3) arrays, the points one piece after the other. It is read twice, if ``iter(pieces)``
        begins anew, as that of a list does; what can be read only once, as a generator, waits in a temporary file.
    rows : called with :class:`StreamRows` of some seeds after the other, in the order of the points. Its arrays are
        copies. What it raises ends the run.
    memory : bytes that the run may take, beside the pieces; at least 1,000,000.
    temporary : the folder of temporary files, which have no names and are gone when the run ends. Default: that of the
        environment's TMPDIR, or /tmp. About 140 bytes a point for neighbors and volumes.
    beside : "weights" or "radii": each piece is a pair (points, numbers), for a power diagram.
    verify : checks all cells as :meth:`Tessellation.verify` does, while ``rows`` is called with them; the outcome is
        ``verified`` of the result.

    The others as in :func:`tessellate`, ``want`` without "vertices" and "faces".

    Raises
    ------
    ValueError : bad input; the message names the first offending index of all points, and the value.
    MemoryError, VotessError : the run failed; ``VotessError.code`` is STORAGE when temporary files cannot be written.
    """
    if beside not in (None, "weights", "radii"):
        raise ValueError(f"beside is {beside!r}: give 'weights', 'radii' or None")
    if not callable(rows):
        raise TypeError(f"rows must be callable, not {type(rows).__name__}")
    options = new_options("cpu", threads, instructions=instructions)
    options.want = as_want(want)
    options.list_walls = bool(list_walls)
    kept = Domain(box, periodic, None, None, cell, origin, walls, outside).fill(options, 0)
    source = _Source(pieces, rows, beside)
    counts = _stream.Counts(struct_size=ctypes.sizeof(_stream.Counts))
    c_stats = _c_api.Stats(struct_size=ctypes.sizeof(_c_api.Stats))
    with showing(progress) as shown:
        with Callbacks() as callbacks:
            options.progress = callbacks.progress(shown)
            stream = _stream.Stream(
                struct_size=ctypes.sizeof(_stream.Stream),
                verify=bool(verify),
                memory=as_count(memory, "memory", 64),
                temporary=as_text(os.fspath(temporary), "temporary") if temporary is not None else None,
                restart=callbacks.guarded(_stream.Restart, source.restart, _stream.STOP),
                next=callbacks.guarded(_stream.Next, source.next, _stream.STOP),
                begin=callbacks.guarded(_stream.Begin, source.begin, _stream.STOP),
                rows=callbacks.guarded(_stream.Take, source.rows, _stream.STOP),
            )
            status = _stream.tessellate(
                ctypes.byref(stream), ctypes.byref(options), ctypes.byref(counts), ctypes.byref(c_stats)
            )
        raise_on_failure(status)
    del kept
    fields = {name: getattr(counts, name) for name in ("blocks", "largest_block", "asked_cells", "temporary_bytes")}
    if verify:
        names = tuple(name for name, bit in _c_api.CHECK_BITS.items() if counts.checks_skipped & bit)
        failure = counts.failure.decode("utf-8", "replace")
        fields["verified"] = VerifyReport(bool(counts.passed), failure, names, counts.sampled)
    return StreamResult(source.box if cell is None else None, stats_of(c_stats), **fields)
