"""What a run did, and what a check found."""

from __future__ import annotations

import ctypes
from dataclasses import dataclass
from typing import Any, Dict, Optional, Tuple

from . import _c_api
from ._call import Handle, raise_on_failure
from ._input import as_count
from ._library import lib


@dataclass(frozen=True)
class StageSeconds:
    """Seconds of wall clock per stage.

    ``open`` finds and opens a device and makes its pipelines. On the CPU ``knn`` and ``fallback`` are part of ``clip``.
    """

    open: float
    upload: float
    sort: float
    knn: float
    clip: float
    fallback: float
    download: float
    total: float


@dataclass(frozen=True)
class FallbackReasons:
    """Why cells were redone on the CPU after another device."""

    uncertain: int  #: floating point could not decide a sign, or not measure well enough
    overflow: int  #: more planes or vertices at once than the device holds
    exhausted: int  #: the search ended before the security radius
    skipped: int  #: the device had failed at nearly all cells before, and was not asked
    domain: int  #: the device does not clip this domain


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
    fallback_reasons: FallbackReasons  #: they add up to fallback_cells
    exact_cells: int  #: cells where exact arithmetic decided a sign
    threads: int  #: CPU threads used
    peak_memory_bytes: int  #: peak resident memory of the process so far
    precision: str  #: of volumes, centroids and areas, "single" or "double"; the CPU always gives "double"
    seconds: StageSeconds
    #: faces, walls left out, with an area below 1e-9 of the mean (of the largest power of two within that), as rounded
    #: lattices have them: ``min_face`` drops them. None where neither the CPU measured all cells nor there are polygons.
    tiny_faces: Optional[int]


def read_stats(result: Handle) -> Stats:
    c_stats = _c_api.Stats(struct_size=ctypes.sizeof(_c_api.Stats))
    raise_on_failure(lib.votess_result_stats(result.pointer, ctypes.byref(c_stats)))
    return stats_of(c_stats)


def stats_of(c_stats: _c_api.Stats) -> Stats:
    fields: Dict[str, Any] = {field[0]: getattr(c_stats, field[0]) for field in _c_api.Stats._fields_}
    del fields["struct_size"]
    fields["tiny_faces"] = None if c_stats.tiny_faces < 0 else c_stats.tiny_faces
    fields["precision"] = next(word for word, value in _c_api.PRECISIONS.items() if value == c_stats.precision)
    fields["device"] = fields["device"].decode("utf-8", "replace")
    stages = {name: fields.pop("seconds_" + name) for name in StageSeconds.__dataclass_fields__}
    reasons = {name: fields.pop("fallback_" + name) for name in FallbackReasons.__dataclass_fields__}
    return Stats(seconds=StageSeconds(**stages), fallback_reasons=FallbackReasons(**reasons), **fields)


@dataclass(frozen=True)
class VerifyReport:
    """Outcome of :meth:`Tessellation.verify` and its like. True when all checks that could be made passed."""

    passed: bool
    failure: str  #: one line on the first failed check; empty when passed
    skipped: Tuple[str, ...]  #: checks whose arrays were not wanted: "volumes", "symmetry", "euler", "sample"
    sampled: int = 0  #: cells tried by brute force, up to the one that failed
    tiny_faces: Optional[int] = None  #: no failure: as in :class:`Stats`; None for rows found in blocks

    def __bool__(self) -> bool:
        return self.passed


def verify(function: Any, arguments: Tuple[Any, ...], sample: Optional[int], rng_seed: int) -> VerifyReport:
    """Calls ``votess_verify`` or its like: the arguments, sample, rng_seed, then what it reports."""
    bits = 8 * ctypes.sizeof(ctypes.c_size_t)
    passed, skipped, sampled = ctypes.c_int(), ctypes.c_uint32(), ctypes.c_size_t()
    failure = ctypes.create_string_buffer(1024)
    raise_on_failure(
        function(
            *arguments,
            _c_api.SAMPLE_AUTOMATIC if sample is None else as_count(sample, "sample", bits),
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
