"""One tessellation over the ranks of an MPI communicator of mpi4py. The lists equal those of one machine.

>>> from mpi4py import MPI                                     # doctest: +SKIP
>>> t = pyvotess.mpi.tessellate(points, MPI.COMM_WORLD)        # doctest: +SKIP
"""

from __future__ import annotations

import contextlib
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, Dict, Iterable, Iterator, Literal, Optional, Union

import numpy as np

from .. import _c_api
from .._arguments import as_word
from .._arrays import ARRAYS, WANT_BITS, WantName
from .._c_api import DuplicatesWord
from .._call import Callbacks, Handle, Progress, VotessError, raise_on_failure, showing
from .._domain import DomainLike, as_domain, with_short_forms
from .._input import as_array, as_points, fill_weights
from .._run import new_options
from .._row_arrays import NAMES, RowArrays
from ..mesh import Lists
from ..stats import VerifyReport, as_sample, verify
from . import _library

if TYPE_CHECKING:
    import numpy.typing as npt
    from typing_extensions import Unpack

    from .._domain import DomainKeywords
    from .._types import Float64Array, Int32Array, Int64Array

__all__ = ["MpiCounts", "MpiTessellation", "tessellate"]

_lib, _handle = _library.load()
_CELLS: Dict[str, int] = {"handed_in": 0, "made": 1}
_ARRAYS = ("ids", "points", "indptr", "indices", "owners", *NAMES, "send_indptr", "send", "receive_indptr", "receive")


@dataclass(frozen=True)
class MpiCounts:
    """Counts of a run over all ranks, equal on each rank."""

    seeds: int  #: of all ranks
    largest_block: int  #: seeds of the largest block
    given: int  #: seeds that blocks sent to others
    needed: int  #: sent seeds that became neighbors of cells of the receiving block
    tested: int  #: cells whose vertices were compared with regions of other blocks
    questions: int  #: cells whose faces were sent to other blocks
    bytes: int  #: sent between ranks: seeds, faces, answers and cells
    rounds: int  #: exchanges of seeds between blocks
    box_volume: float  #: of the domain, length unit cubed
    volume_sum: float  #: of all cells; 0 without "volumes" in want
    exact_cells: int  #: cells where exact arithmetic decided a sign


@dataclass(frozen=True, eq=False)
class MpiTessellation(RowArrays):
    """The N cells of a rank. Arrays are read-only views of the library's memory, and None if not in ``want``.

    In the plane, vectors have two components.
    """

    ids: Int64Array  #: (N,) of the seeds
    points: Optional[Float64Array]  #: (N, 3) seeds, with ``cells="made"``
    neighbors: Lists  #: N rows of int64 ids, ascending by id, then by shift; walls are negative
    owners: Int32Array  #: for each entry of the rows the rank of the neighbor; -1 for walls
    send: Lists  #: row r: ids of own seeds that are neighbors on rank r, ascending; with ``cells="handed_in"``
    receive: Lists  #: row r: ids of rank r's seeds that are neighbors of own seeds, in the order of its ``send``
    box: Optional[Float64Array]  #: (2, 3) lower and upper corner; None with a ``cell``
    counts: MpiCounts
    _result: Handle = field(repr=False, compare=False)
    _dimensions: int = field(repr=False, compare=False)

    def __repr__(self) -> str:
        return (f"<pyvotess.mpi.MpiTessellation of {len(self.ids)} seeds of one rank: {len(self.owners)} neighbors, "
                f"{self._listed()}>")  # fmt: skip

    def verify(
        self, comm: Any, points: Optional[npt.ArrayLike] = None, sample: Optional[int] = None, rng_seed: int = 1
    ) -> VerifyReport:
        """Verifies the cells of all ranks, as :meth:`Tessellation.verify`. Collective: every rank of ``comm`` calls it.

        Volumes must sum to the box, lists must be symmetric across ranks, and Euler's formula must hold. Without ``sample``
        all cells are proven. With it, and in a domain without end, a sample of all cells must equal cells that are clipped
        again by every seed. The report is equal on all ranks.

        Parameters
        ----------
        points : the points that this rank passed to :func:`tessellate`; None with ``cells="made"``.
        sample, rng_seed : as for :meth:`Tessellation.verify`, equal on all ranks.
        """
        communicator = _handle(comm)
        with _all_or_none(comm):
            array = None if points is None else np.ascontiguousarray(as_points(points, planar=True), np.float64)
            if array is not None and array.shape[1] != self._dimensions:
                raise ValueError(f"points has shape {array.shape}: it must be (N, {self._dimensions})")
            points_of_rank = (array, 0 if array is None else len(array))
            drawn = as_sample(sample, rng_seed)
        return verify(_lib.votess_mpi_verify, communicator, self._result, *points_of_rank, *drawn, counts_faces=False)


@contextlib.contextmanager
def _all_or_none(comm: Any) -> Iterator[None]:
    """Raises the first rank's error of the block on all ranks. Collective.

    Each collective function checks its arguments in such a block, because a rank that raised alone would leave the
    others waiting for it. The library then compares the arguments that must be equal on all ranks.
    """
    failure: Optional[BaseException] = None
    try:
        yield
    except BaseException as error:  # reported to the other ranks
        failure = error
    failures = comm.allgather(None if failure is None else str(failure))
    if failure is not None and not isinstance(failure, (TypeError, ValueError, VotessError)):
        raise failure  # from a signal handler
    for rank, text in enumerate(failures):
        if text is not None:
            raise ValueError(f"rank {rank}: {text}") from failure


def _read(result: Handle, want: int, made: bool, in_box: bool, periodic: bool, dimensions: int) -> MpiTessellation:
    arrays: Dict[str, Any] = {name: result.array(name) for name in _ARRAYS}
    for word, bit in WANT_BITS.items():
        if word != "neighbors" and not want & bit:  # rows are always present
            arrays.update((name, None) for name in ARRAYS[word] if name in arrays)
    if not made:
        arrays["points"] = None
    if not periodic:
        arrays["shifts"] = None
    if len(arrays["duplicate_of"]) != len(arrays["ids"]) or len(arrays["ids"]) == 0:
        arrays["duplicate_of"] = None
    for name, indptr_name, indices_name in (
        ("neighbors", "indptr", "indices"), ("send", "send_indptr", "send"), ("receive", "receive_indptr", "receive"),
    ):  # fmt: skip
        indptr, indices = arrays.pop(indptr_name), arrays.pop(indices_name)
        arrays[name] = Lists(indptr if len(indptr) else np.zeros(1, np.int64), indices)
    c_counts = _library.MpiCounts()
    raise_on_failure(_lib.votess_mpi_read_counts(result, c_counts))
    counts = MpiCounts(**{name: getattr(c_counts, name) for name in MpiCounts.__dataclass_fields__})
    box = result.array("box")[:, :dimensions] if in_box else None
    return MpiTessellation(box=box, counts=counts, _result=result, _dimensions=dimensions, **arrays)


def _as_ids(ids: Any, count: int) -> Int64Array:
    array = as_array(ids, "ids")
    if array.shape != (count,):
        raise ValueError(f"ids has shape {array.shape} for {count} points: it must be ({count},)")
    if count and (array.dtype.kind not in "iu" or (array.dtype.kind == "u" and int(array.max()) >= 2**63)):
        raise ValueError(f"ids has dtype {array.dtype}, or an id of at least 2**63: give int64")
    return np.ascontiguousarray(array, np.int64)


@with_short_forms
def tessellate(
    points: npt.ArrayLike,
    comm: Any,
    domain: Optional[DomainLike] = None,
    *,
    ids: Optional[npt.ArrayLike] = None,
    weights: Optional[npt.ArrayLike] = None,
    radii: Optional[npt.ArrayLike] = None,
    want: Union[str, Iterable[WantName]] = ("neighbors", "volumes"),
    list_walls: bool = False,
    threads: int = 1,
    duplicates: DuplicatesWord = "merge",
    cells: Literal["handed_in", "made"] = "handed_in",
    progress: Union[None, bool, Progress] = None,
    **keywords: Unpack[DomainKeywords],
) -> MpiTessellation:
    """Returns Voronoi cells of the points of all ranks. Collective: every rank of ``comm`` calls it.

    The lists depend neither on the number of ranks nor on the distribution of the points. Cells are computed on the CPU.

    Parameters
    ----------
    points : (N, 3) or, in the plane, (N, 2) real numbers, the points of this rank; N may be 0 and may differ between
        ranks.
    comm : a communicator of mpi4py.
    domain : as for :func:`pyvotess.tessellate`, or its short forms; no mesh.
    ids : (N,) non-negative integers, unique over all ranks; or None on all ranks, which numbers the points rank after
        rank. Of equal points the lowest id keeps the cell.
    weights, radii : (N,) numbers for the points of this rank.
    threads : CPU threads of this rank, 0 = all of the machine.
    cells : "handed_in": the cells of this rank's points, in their order. "made": the cells in the rank's region of space,
        ascending by id; this saves an exchange. Dropped seeds are on no rank then. The same on all ranks.
    progress : as for :func:`pyvotess.tessellate`, for the cells of this rank; it stops all ranks.

    The others are those of :func:`pyvotess.tessellate`, equal on all ranks. "vertices", "faces" and
    ``duplicates="error"`` raise VotessError with code UNSUPPORTED.

    Raises
    ------
    ValueError, MemoryError, VotessError : if one rank fails, all raise the same error, which names the rank. If a
        progress callback or a signal handler raises, its rank raises that error, and the others raise VotessError with
        code CANCELLED.
    """
    communicator = _handle(comm)
    result = Handle("mpi", _lib)
    with contextlib.ExitStack() as stack:
        with _all_or_none(comm):
            array = as_points(points, planar=True).astype(np.float64, copy=False)
            numbers = None if ids is None else _as_ids(ids, len(array))
            options = new_options(
                device="cpu", want=want, list_walls=list_walls, threads=threads, duplicates=duplicates,
                planar=array.shape[1] == 2,
            )  # fmt: skip
            which = as_word(cells, "cells", _CELLS)
            given = as_domain(domain, keywords)
            (given.replace(box=None) if given.is_hull else given)._fill(options, array)
            fill_weights(options, weights, radii, len(array))
            shown = stack.enter_context(showing(progress))
        if given.is_hull:
            hull = Handle("hull")
            raise_on_failure(_lib.votess_mpi_hull_new(communicator, array, len(array), options, hull))
            facets = hull.array("walls")
            options.walls, options.wall_count = facets, len(facets)
        with Callbacks() as callbacks:
            options.progress = callbacks.progress(shown)
            status = _lib.votess_mpi_tessellate(communicator, array, len(array), numbers, options, which, result)
        raise_on_failure(status)
    axes = options.cell_periodic if options.has_cell else options.periodic
    return _read(result, options.want, cells == "made", given.vectors is None, any(axes), array.shape[1])
