"""Statistics of a run, and the report of a verification."""

from __future__ import annotations

import ctypes
from dataclasses import dataclass, replace
from typing import Any, Dict, Optional, Tuple

from . import _c_api
from ._call import Handle, raise_on_failure
from ._arguments import as_count
from ._library import lib


@dataclass(frozen=True)
class StageSeconds:
    """Wall-clock seconds of the stages.

    ``open`` finds and opens a device and creates its pipelines. On the CPU ``knn`` and ``fallback`` are part of ``clip``.
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
    """Numbers of cells that the CPU computed again after another device, by reason."""

    uncertain: int  #: floating point could not decide a sign, or lacked precision for the measures
    overflow: int  #: more planes or vertices than the device can hold
    exhausted: int  #: the search ended before the security radius
    skipped: int  #: not tried, because the device failed for nearly all earlier cells
    domain: int  #: the device cannot clip this domain


@dataclass(frozen=True)
class Stats:
    """Statistics of a run. ``dataclasses.asdict(stats)`` returns a dict."""

    device: str  #: name of the device that ran
    points: int  #: N
    faces: int  #: sum of the numbers of faces of all cells, walls included
    mean_faces: float  #: faces divided by the number of cells that are not empty
    volume_sum: float  #: sum of all volumes; 0 without "volumes" in want
    box_volume: float  #: volume of the domain
    moved_vertices: int  #: of a mesh: those that ``mesh_tolerance`` made one with others
    moved_distance: float  #: the largest of these moves
    duplicates: int  #: seeds with status DUPLICATE
    empty_cells: int  #: seeds without a cell: duplicate, empty or outside
    fallback_cells: int  #: cells that the CPU computed again after another device
    fallback_reasons: FallbackReasons  #: their sum is fallback_cells
    exact_cells: int  #: cells made where exact arithmetic decided a sign
    kept_cells: int  #: cells of the last call that still hold, with ``follow``
    threads: int  #: CPU threads used
    peak_memory_bytes: int  #: peak resident memory of the process so far
    precision: str  #: of volumes, centroids and areas: "single" or "double"; always "double" on the CPU
    seconds: StageSeconds
    #: number of faces, without walls, with an area below 1e-9 of the mean (rounded down to a power of two). Rounded
    #: lattices have them, and ``min_face`` drops them. None unless the CPU measured all cells or there are polygons.
    tiny_faces: Optional[int]


def read_stats(result: Handle) -> Stats:
    c_stats = _c_api.Stats()
    raise_on_failure(lib.votess_result_stats(result, c_stats))
    return stats_of(c_stats)


def stats_of(c_stats: _c_api.Struct) -> Stats:
    fields: Dict[str, Any] = {field[0]: getattr(c_stats, field[0]) for field in _c_api.Stats._fields_}
    del fields["struct_size"]
    fields["tiny_faces"] = None if c_stats.tiny_faces < 0 else c_stats.tiny_faces
    fields["precision"] = next(word for word, value in _c_api.PRECISIONS.items() if value == c_stats.precision)
    fields["device"] = fields["device"].decode("utf-8", "replace")
    stages = {name: fields.pop("seconds_" + name) for name in StageSeconds.__dataclass_fields__}
    reasons = {name: fields.pop("fallback_" + name) for name in FallbackReasons.__dataclass_fields__}
    return Stats(seconds=StageSeconds(**stages), fallback_reasons=FallbackReasons(**reasons), **fields)


@dataclass(frozen=True)
class MeshQuality:
    """How well cells suit solvers, as OpenFOAM's checkMesh measures it. See :meth:`Tessellation.mesh_quality`."""

    cells: int  #: those with faces
    faces: int  #: each once
    internal_faces: int  #: between two cells; those of a periodic boundary are not among them
    vertices: int
    max_non_orthogonality: float  #: angle between a face's normal and the line through the centroids of its cells, in degrees
    mean_non_orthogonality: float
    severe_faces: int  #: with an angle above 70 degrees
    max_skewness: float  #: distance of that line from the face's center, as a share of the face's size in its direction
    skew_faces: int  #: with a skewness above 4
    min_area: float  #: of a face
    min_volume: float  #: of a cell
    min_edge: float  #: length
    wrong_faces: int  #: with a normal that does not lead from one cell to the other, or without an area
    wrong_cells: int  #: without a positive volume
    short_edges: int  #: below ``min_edge``, which cannot be collapsed


@dataclass(frozen=True)
class VerifyReport:
    """Report of :meth:`Tessellation.verify` and similar methods. It is true when all possible checks passed."""

    passed: bool
    failure: str  #: one line about the first failed check; empty on success
    skipped: Tuple[str, ...]  #: checks without their arrays: "volumes", "symmetry", "euler", "sample"
    sampled: int = 0  #: cells checked by brute force, up to the failed one; a proof needs none
    tiny_faces: Optional[int] = None  #: as in :class:`Stats`, not a failure; None for rows from blocks
    proven: bool = False  #: all neighbors, shifts, and which seeds have cells are proven; no sample was needed
    unproven: str = ""  #: one line on why not all cells are proven; empty when they are, and when a check failed

    def __bool__(self) -> bool:
        return self.passed


def as_sample(sample: Optional[int], rng_seed: int) -> Tuple[int, int]:
    """Returns the two arguments of :meth:`Tessellation.verify` for the library."""
    bits = 8 * ctypes.sizeof(ctypes.c_size_t)
    cells = _c_api.SAMPLE_AUTOMATIC if sample is None else as_count(sample, "sample", bits)
    return cells, as_count(rng_seed, "rng_seed", 64)


def read_report(passed: int, skipped: int, sampled: int, failure: bytes, unproven: bytes) -> VerifyReport:
    names = tuple(name for name, bit in _c_api.CHECK_BITS.items() if skipped & bit)
    texts = [text.decode("utf-8", "replace") for text in (failure, unproven)]
    proven = bool(passed) and not unproven
    return VerifyReport(bool(passed), texts[0], names, sampled, proven=proven, unproven=texts[1])


def verify(function: Any, *arguments: Any, counts_faces: bool = True) -> VerifyReport:
    """Calls ``votess_verify``, or ``votess_mpi_verify``, which does not count tiny faces, and returns the report."""
    passed, proven, skipped, sampled = ctypes.c_int(), ctypes.c_int(), ctypes.c_uint32(), ctypes.c_size_t()
    texts = [ctypes.create_string_buffer(1024) for _ in range(2)]  # failure, unproven
    tiny = ctypes.c_uint64(_c_api.TINY_FACES_UNKNOWN)
    verdict = (passed, proven, skipped, sampled, tiny) if counts_faces else (passed, skipped, sampled)
    buffers = [part for text in texts for part in (text, len(text))]
    raise_on_failure(function(*arguments, *verdict, *buffers))
    report = read_report(passed.value, skipped.value, sampled.value, texts[0].value, texts[1].value)
    return report if tiny.value == _c_api.TINY_FACES_UNKNOWN else replace(report, tiny_faces=tiny.value)
