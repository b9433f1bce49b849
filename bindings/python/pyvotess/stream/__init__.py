"""Seeds larger than memory: points are read in pieces, stored in temporary files, and rows are returned in pieces."""

from __future__ import annotations

import itertools
import os
from dataclasses import dataclass
from collections.abc import Iterable, Mapping
from typing import TYPE_CHECKING, Any, Callable, Dict, Iterator, Optional, Tuple, Union

import numpy as np

from .. import _c_api
from .._arguments import as_count, as_flag, as_path, counted, require_one_of, shown
from .._arrays import ARRAYS, WantName
from .._call import Callbacks, Progress, raise_on_failure, showing, view_of
from .._domain import DomainLike, as_domain, with_short_forms
from .._input import as_one_each, as_points
from .._run import implied_words, new_options
from .._row_arrays import NAMES, RowArrays
from ..mesh import Lists
from ..stats import Stats, VerifyReport, read_report, stats_of
from .._library import lib

if TYPE_CHECKING:
    import numpy.typing as npt
    from typing_extensions import Unpack

    from .._domain import DomainKeywords
    from .._types import Float64Array, Int64Array

__all__ = ["StreamResult", "StreamRows", "tessellate_stream"]

_STOP, _END, _GO_ON = -1, 0, 1

@dataclass(frozen=True, eq=False)
class StreamRows(RowArrays):
    """The cells of N consecutive seeds, from seed ``first`` on. Arrays that are not in ``want`` are None.

    They are arrays of :class:`Tessellation` with int64 ids. In the plane, vectors have two components.
    """

    first: int
    indptr: Optional[Int64Array]  #: (N + 1,), counted from the first seed of the run
    indices: Optional[Int64Array]  #: (entries,) neighbors, row by row

    def __len__(self) -> int:
        return len(self.status)

    def __repr__(self) -> str:
        rows = "no rows" if self.indices is None else f"{len(self.indices)} neighbors"
        return f"<pyvotess.StreamRows of {counted(len(self), 'seed')} from {self.first} on: {rows}, {self._listed()}>"

    @property
    def neighbors(self) -> Lists:
        """N rows of int64 ids: row k is that of seed ``first + k``."""
        if self.indptr is None or self.indices is None:
            raise ValueError("the rows have no neighbors: put 'neighbors' into want")
        indices: Any = self.indices
        return Lists(self.indptr - self.indptr[0], indices)


@dataclass(frozen=True, eq=False)
class StreamResult:
    """The outcome of :func:`tessellate_stream`."""

    box: Optional[Float64Array]  #: (2, 3), in the plane (2, 2): the given or default box; None with a cell
    stats: Stats
    blocks: int
    largest_block: int  #: seeds of the largest block
    asked_cells: int  #: cells completed by other blocks
    temporary_bytes: int  #: of all temporary files at one time, at most
    verified: Optional[VerifyReport] = None  #: with ``verify=True``

    def __repr__(self) -> str:
        verified = "" if self.verified is None else ", verified" if self.verified.passed else ", failed to verify"
        return (f"<pyvotess.StreamResult of {counted(self.stats.points, 'seed')} in {counted(self.blocks, 'block')}, "
                f"the largest of {self.largest_block}{verified}>")  # fmt: skip


class _Source:
    """Callbacks of the library, which read the user's pieces and pass rows on."""

    def __init__(
        self, pieces: Iterable[Any], rows: Callable[[StreamRows], Any], beside: Optional[str]
    ) -> None:
        self._pieces, self._rows, self._beside = pieces, rows, beside
        # The arrays that are there, also if a piece has no seeds or entries.
        self._present = {"status"}
        self._iterator: Iterator[Any] = iter(pieces)
        self._again = self._iterator is not pieces
        self._held: Tuple[Any, ...] = ()
        self.box: Optional[Float64Array] = None
        # The first piece has the number of dimensions.
        first = list(itertools.islice(self._iterator, 1))
        self._iterator, self._at_start = itertools.chain(first, self._iterator), True
        self.dimensions = self._points_of(first[0]).shape[1] if first else 3

    def expect(self, wanted: Iterable[str]) -> None:
        self._present.update(name for word in wanted for name in ARRAYS[word])

    def _pair(self, piece: Any) -> Tuple[Any, Any]:
        if not self._beside:
            return piece, None
        if not isinstance(piece, (tuple, list)) or len(piece) != 2:
            raise TypeError(f"one of pieces is {shown(piece)}: give a pair of points and {self._beside}")
        return piece[0], piece[1]

    def _points_of(self, piece: Any) -> npt.NDArray[Any]:
        return as_points(self._pair(piece)[0], "one of pieces", planar=True)

    def restart(self, _user: Any) -> int:
        if self._again and not self._at_start:
            self._iterator = iter(self._pieces)
        self._at_start = False
        return _GO_ON if self._again else _END

    def next(self, seeds: Any) -> int:
        try:
            piece = next(self._iterator)
        except StopIteration:
            return _END
        array = np.ascontiguousarray(self._points_of(piece), dtype=np.float64)
        if array.shape[1] != self.dimensions:
            raise ValueError(f"one of pieces has shape {array.shape}: it must be (n, {self.dimensions}), as the first one")
        self._held = (array,)
        seeds[0].count, seeds[0].points = len(array), array
        if self._beside:
            beside = as_one_each(self._pair(piece)[1], self._beside, len(array), "points")
            self._held = (array, beside)
            setattr(seeds[0], self._beside, beside)
        return _GO_ON

    def begin(self, head: Any) -> int:
        self.box = np.array([head[0].box_lower[: self.dimensions], head[0].box_upper[: self.dimensions]])
        if head[0].periodic and "indices" in self._present:
            self._present.add("shifts")
        return _GO_ON

    def rows(self, rows: Any) -> int:
        def array(name: str) -> Any:
            found = view_of(lib.votess_stream_array, rows, name)
            return found.copy() if len(found) or name in self._present else None

        arrays = {name: array(name) for name in (*NAMES, "indptr", "indices")}
        self._rows(StreamRows(first=rows[0].first, **arrays))
        return _GO_ON


@with_short_forms
def tessellate_stream(
    pieces: Iterable[Any],
    rows: Callable[[StreamRows], Any],
    domain: Optional[DomainLike] = None,
    *,
    memory: int,
    temporary: Optional[Union[str, "os.PathLike[str]"]] = None,
    beside: Optional[str] = None,
    want: Union[str, Iterable[WantName]] = ("neighbors", "volumes"),
    list_walls: bool = False,
    threads: int = 0,
    progress: Union[None, bool, Progress] = None,
    instructions: str = "",
    verify: bool = False,
    **keywords: Unpack[DomainKeywords],
) -> StreamResult:
    """Computes Voronoi cells of points larger than memory, on the CPU. The rows are those of :func:`tessellate`.

    Parameters
    ----------
    pieces : an iterable of (n, 3) or, in the plane, (n, 2) arrays, the points in order. It is read twice if ``iter(pieces)`` restarts, as for a
        list. Points of a generator, which can be read once, are stored in a temporary file.
    rows : called with :class:`StreamRows`, in the order of the points. Its arrays are copies. An exception ends the
        run.
    domain : as for :func:`tessellate`, or its short forms; no mesh.
    memory : bytes that the run may use in addition to the pieces; at least 1,000,000.
    temporary : folder of the temporary files, which have no names and vanish with the run. They take about 80 bytes
        for each point with neighbors and volumes, 95 with ``verify``, 25 with volumes alone where float32 holds the
        coordinates. Default: TMPDIR of the environment, or /tmp.
    beside : "weights" or "radii": each piece is a pair (points, numbers), for a power diagram.
    verify : verify all cells as :meth:`Tessellation.verify` while ``rows`` gets them. The report is ``verified`` of the
        result.

    The others are those of :func:`tessellate`. ``want`` must not have "vertices" or "faces".

    Raises
    ------
    ValueError : bad input; the message names the first offending index among all points, and the value.
    MemoryError, VotessError : the run failed; ``VotessError.code`` is STORAGE when temporary files cannot be written.

    >>> pieces = [np.random.default_rng(k).random((1000, 3)) for k in range(5)]
    >>> volumes = np.empty(5000)
    >>> def take(rows):
    ...     volumes[rows.first : rows.first + len(rows)] = rows.volumes
    >>> vt.tessellate_stream(pieces, take, memory=1_000_000, box=(0, 0, 0, 1, 1, 1)).blocks
    5
    """
    require_one_of(beside, "beside", ("weights", "radii"))
    if not callable(rows):
        raise TypeError(f"rows must be callable, not {type(rows).__name__}")
    is_one = isinstance(pieces, (str, bytes, Mapping)) or getattr(pieces, "ndim", 1) == 0
    if is_one or not isinstance(pieces, Iterable):
        raise TypeError(f"pieces is {shown(pieces)}: give an iterable of (n, 3) or (n, 2) arrays")
    bytes_of_run, checks = as_count(memory, "memory", 64), as_flag(verify, "verify")
    folder = None if temporary is None else os.fsencode(as_path(temporary, "temporary"))
    source = _Source(pieces, rows, beside)
    options = new_options(
        device="cpu", want=want, list_walls=list_walls, threads=threads, instructions=instructions,
        planar=source.dimensions == 2,
    )  # fmt: skip
    given = as_domain(domain, keywords)
    given._fill(options, None)
    source.expect(implied_words(options))
    counts, c_stats = _c_api.StreamCounts(), _c_api.Stats()
    stream = _c_api.Stream(verify=checks, hull=given.is_hull, memory=bytes_of_run, temporary=folder)
    types = dict(_c_api.Stream._fields_)
    with showing(progress) as show:
        with Callbacks() as callbacks:
            options.progress = callbacks.progress(show)
            for name in ("restart", "next", "begin", "rows"):
                setattr(stream, name, callbacks.guarded(types[name], getattr(source, name), _STOP))
            status = lib.votess_tessellate_stream(stream, options, counts, c_stats)
        raise_on_failure(status)
    fields = {name: getattr(counts, name) for name in ("blocks", "largest_block", "asked_cells", "temporary_bytes")}
    if verify:
        texts = (counts.failure, counts.unproven)
        fields["verified"] = read_report(counts.passed, counts.checks_skipped, counts.sampled, *texts)
    return StreamResult(source.box if given.vectors is None else None, stats_of(c_stats), **fields)
