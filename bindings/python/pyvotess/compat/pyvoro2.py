"""pyvoro2's compute for three dimensions: ``from pyvotess.compat import pyvoro2 as pv``.

What differs from pyvoro2 0.8:

- Cells come in the order of the points, their faces and vertices in that of votess. Faces that are smaller than
  Voro++'s tolerance are there, and vertices that are equal in exact arithmetic are one.
- Points may be as close to each other as they like, but not equal: that is a DuplicateError. ``duplicate_check`` looks
  at pairs of neighbors.
- A point may lie on an upper wall too.
- A cell is a dict of a subclass, which makes its vertices, adjacency and faces when they are first looked at. Only code
  in C that reads a dict without calling its methods can see it before.
- Face shifts are exact: the options that search, check and repair them are not used, nor are those of Voro++'s blocks.
- Diagnostics judge the volumes alone; faces carry no marks of them.
- locate, ghost_cells, analyze_tessellation, validate_*, normalize_*, annotate_face_properties and the planar and
  inverse namespaces raise NotImplementedError, which names what to use.
"""

from __future__ import annotations

import warnings
from typing import TYPE_CHECKING, Any, Callable, Dict, List, Optional, Sequence, Tuple

import numpy as np

from .._c_api import CellStatus
from .._input import as_points
from ..tessellator import tessellate
from ._cells import Cell, CellBlocks, LazyCell
from ._pause import garbage_collector_paused
from ._pyvoro2_domains import Box, Domain, OrthorhombicCell, PeriodicCell, domain_options
from ._pyvoro2_result import (
    DuplicateError,
    DuplicatePair,
    TessellationDiagnostics,
    TessellationError,
    TessellationIssue,
    TessellationResult,
    diagnose,
)

if TYPE_CHECKING:
    import numpy.typing as npt

    from ..tessellation import Tessellation

    Float64Array = npt.NDArray[np.float64]
    Int64Array = npt.NDArray[np.int64]

_INSTEAD = {
    "locate": "pyvotess.Diagram.locate",
    "ghost_cells": "pyvotess.Diagram.probe",
    "analyze_tessellation": "compute(..., return_diagnostics=True), or pyvotess.Tessellation.verify",
    "validate_tessellation": "pyvotess.Tessellation.verify",
    "validate_normalized_topology": "pyvotess.Tessellation.verify",
    "normalize_vertices": "the vertices of pyvotess.tessellate(want='faces') are shared by the cells already",
    "normalize_edges_faces": "the faces of pyvotess.tessellate(want='faces') are rows of shared vertices already",
    "normalize_topology": "the mesh of pyvotess.tessellate(want='faces') is shared by the cells already",
    "annotate_face_properties": "pyvotess.tessellate(want='areas,normals,faces')",
    "planar": "scipy.spatial.Voronoi: votess has three dimensions only",
    "inverse": "pyvoro2 itself",
}

__all__ = [
    "Box",
    "DuplicateError",
    "DuplicatePair",
    "OrthorhombicCell",
    "PeriodicCell",
    "TessellationDiagnostics",
    "TessellationError",
    "TessellationIssue",
    "TessellationResult",
    "compute",
    "duplicate_check",
    "radii_to_weights",
    "weights_to_radii",
]


def __getattr__(name: str) -> Callable[..., Any]:
    """A function that is not there, which can be imported and raises when it is called; a namespace raises at once."""
    if name not in _INSTEAD:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    message = f"{name} is not in {__name__}; use instead: {_INSTEAD[name]}"

    def missing(*arguments: Any, **keywords: Any) -> Any:
        raise NotImplementedError(message)

    return missing() if name in ("planar", "inverse") else missing


def radii_to_weights(radii: npt.ArrayLike) -> Float64Array:
    """(n,) the squares of radii, which are at least 0."""
    array = np.asarray(radii, dtype=np.float64)
    if array.ndim != 1 or not (array >= 0).all() or not np.isfinite(array * array).all():
        raise ValueError("radii must be one row of finite numbers that are at least 0")
    return array * array


def weights_to_radii(
    weights: npt.ArrayLike, *, r_min: float = 0.0, weight_shift: Optional[float] = None
) -> Tuple[Float64Array, float]:
    """(n,) the roots of weights + shift, and the shift: ``weight_shift``, or what makes the least radius ``r_min``."""
    array = np.asarray(weights, dtype=np.float64)
    if array.ndim != 1 or not np.isfinite(array).all():
        raise ValueError("weights must be one row of finite numbers")
    if weight_shift is not None and r_min != 0:
        raise ValueError("give r_min or weight_shift, not both")
    if not r_min >= 0:
        raise ValueError(f"r_min is {r_min}: it must be at least 0")
    shift = r_min * r_min - float(array.min(initial=np.inf)) if weight_shift is None else float(weight_shift)
    shift = shift if len(array) or weight_shift is not None else r_min * r_min
    if (array + shift < -1e-14).any():
        raise ValueError(f"weight_shift {shift} leaves negative weights, which have no radii")
    return np.sqrt(np.maximum(array + shift, 0.0)), shift


def duplicate_check(
    points: npt.ArrayLike,
    *,
    threshold: float = 1e-5,
    domain: Optional[Domain] = None,
    wrap: bool = True,
    mode: str = "raise",
    max_pairs: int = 10,
) -> Tuple[DuplicatePair, ...]:
    """Pairs of equal points, and of neighbors in the Voronoi diagram closer than ``threshold``, the closest first.

    ``mode``: "raise" a DuplicateError, "warn", or "return" the first ``max_pairs``. Where any two points are closer
    than the threshold, some pair is found; three in a row may not give the pair of the outer ones.
    """
    _require(mode, "mode", ("raise", "warn", "return"))
    array = as_points(points)
    if len(array) < 2:
        return ()
    options = domain_options(domain)[0] if domain is not None and wrap else {}
    t = tessellate(array, want="neighbors", outside="drop" if options else "error", **options)
    pairs: List[DuplicatePair] = []
    if t.duplicate_of is not None:
        copies = np.flatnonzero(t.duplicate_of >= 0)
        pairs += [DuplicatePair(int(t.duplicate_of[copy]), int(copy), 0.0) for copy in copies[:max_pairs]]
    found = t.pairs()
    close = np.flatnonzero((found.distance < threshold) & (found.i < found.j))
    for k in close[np.argsort(found.distance[close], kind="stable")][: max_pairs - len(pairs)]:
        pairs.append(DuplicatePair(int(found.i[k]), int(found.j[k]), float(found.distance[k])))
    if pairs and mode != "return":
        message = f"points {pairs[0].i} and {pairs[0].j} are {pairs[0].distance:g} apart, closer than {threshold:g}"
        if mode == "raise":
            raise DuplicateError(message, tuple(pairs), threshold)
        warnings.warn(message, RuntimeWarning, stacklevel=3)
    return tuple(pairs)


_check_duplicates = duplicate_check  # compute has an option that hides the function's name


def _require(word: Any, name: str, words: Tuple[str, ...]) -> None:
    if word not in words:
        raise ValueError(f"{name} is {word!r}: the words are {', '.join(words)}")


def compute(
    points: npt.ArrayLike,
    *,
    domain: Domain,
    ids: Optional[Sequence[int]] = None,
    duplicate_check: str = "off",
    duplicate_threshold: float = 1e-5,
    duplicate_wrap: bool = True,
    duplicate_max_pairs: int = 10,
    block_size: Optional[float] = None,
    blocks: Optional[Tuple[int, int, int]] = None,
    init_mem: int = 8,
    mode: str = "standard",
    weights: Optional[npt.ArrayLike] = None,
    radii: Optional[npt.ArrayLike] = None,
    return_vertices: bool = True,
    return_adjacency: bool = True,
    return_faces: bool = True,
    return_face_shifts: bool = False,
    face_shift_search: int = 2,
    include_empty: bool = False,
    validate_face_shifts: bool = True,
    repair_face_shifts: bool = False,
    face_shift_tol: Optional[float] = None,
    return_diagnostics: bool = False,
    output: str = "result",
    tessellation_check: str = "none",
    tessellation_require_reciprocity: Optional[bool] = None,
    tessellation_volume_tol_rel: float = 1e-8,
    tessellation_volume_tol_abs: float = 1e-12,
    tessellation_plane_offset_tol: Optional[float] = None,
    tessellation_plane_angle_tol: Optional[float] = None,
    **options: Any,
) -> Any:
    """The cells of (n, 3) points in a domain: a TessellationResult, or with output="cells" a list of dicts.

    The names mean what they mean in pyvoro2; the head of this module tells what is not used. ``options`` are those of
    :func:`pyvotess.tessellate`: ``threads``, ``device``, ``instructions``, ``progress``.

    A cell has ``id``, ``volume``, ``site``, where the point lies in the domain, and as asked ``vertices``,
    ``adjacency`` and ``faces``; a face has ``adjacent_cell``, an id or a wall from -1 to -6, ``vertices``, and as asked
    ``adjacent_shift``, the number of edges (a, b, c) that carry the neighbor's site to where it touches.
    """
    _require(mode, "mode", ("standard", "power"))
    _require(output, "output", ("result", "cells"))
    _require(duplicate_check, "duplicate_check", ("off", "warn", "raise"))
    _require(tessellation_check, "tessellation_check", ("none", "diagnose", "warn", "raise"))
    if mode == "standard" and not (weights is None and radii is None):
        raise ValueError("weights and radii go with mode='power' only")
    if mode == "power" and (weights is None) == (radii is None):
        raise ValueError("mode='power' needs weights or radii, and not both")
    array = as_points(points)
    domain_words, edges, periodic = domain_options(domain)
    if return_face_shifts and not any(periodic):
        raise ValueError("return_face_shifts needs a domain that repeats: an OrthorhombicCell or a PeriodicCell")
    if return_face_shifts and not (return_faces and return_vertices):
        raise ValueError("return_face_shifts needs return_faces=True and return_vertices=True")
    numbers = np.arange(len(array)) if ids is None else np.asarray(ids)
    if numbers.shape != (len(array),) or (len(numbers) and (numbers.dtype.kind not in "iu" or numbers.min() < 0)):
        raise ValueError(f"ids must be {len(array)} integers that are at least 0")
    if len(np.unique(numbers)) < len(numbers):
        raise ValueError("ids must differ from each other")
    numbers = numbers.astype(np.int64)

    backend_radii: Optional[Float64Array] = None
    shift: Optional[float] = None
    if weights is not None:
        backend_radii, shift = weights_to_radii(weights)
    elif radii is not None:
        backend_radii = np.sqrt(radii_to_weights(radii))
    wants = {"vertices": return_vertices, "adjacency": return_adjacency, "faces": return_faces}
    keep = tuple(name for name, wanted in wants.items() if wanted)
    t = tessellate(
        array,
        weights=weights,
        radii=None if weights is not None else radii,
        want=("volumes", "faces") if keep else "volumes",
        **domain_words,
        **options,
    )
    if t.duplicate_of is not None:
        copy = int(np.flatnonzero(t.duplicate_of >= 0)[0])
        pair = DuplicatePair(int(t.duplicate_of[copy]), copy, 0.0)
        raise DuplicateError(f"points {pair.i} and {pair.j} are equal", (pair,), 0.0)
    if duplicate_check != "off":
        _check_duplicates(
            array, threshold=duplicate_threshold, domain=domain, wrap=duplicate_wrap, mode=duplicate_check,
            max_pairs=duplicate_max_pairs,
        )  # fmt: skip

    empty = t.status == CellStatus.EMPTY
    diagnostics = None
    if return_diagnostics or tessellation_check != "none":
        face_count = int((t.neighbors.indices >= 0).sum()) if return_face_shifts else None
        size = abs(float(np.linalg.det(edges)))
        diagnostics = diagnose(
            size, t.volumes, numbers, empty, include_empty, face_count,
            tessellation_volume_tol_rel, tessellation_volume_tol_abs,
        )  # fmt: skip
        if not diagnostics.ok and tessellation_check == "raise":
            raise TessellationError(diagnostics.issues[-1].message, diagnostics)
        if not diagnostics.ok and tessellation_check == "warn":
            warnings.warn(diagnostics.issues[-1].message, stacklevel=2)

    def make_cells() -> List[Dict[str, Any]]:
        with garbage_collector_paused():
            return _cells(t, domain, edges, numbers, empty, keep, return_face_shifts, include_empty)

    if output == "cells":
        return (make_cells(), diagnostics) if return_diagnostics else make_cells()
    return TessellationResult(
        dimension=3,
        domain=domain,
        mode=mode,
        sites=np.asarray(array, dtype=np.float64),
        ids=numbers,
        cell_measures=t.volumes,
        empty_mask=empty,
        input_weights=None if weights is None else np.asarray(weights, dtype=np.float64),
        backend_radii=backend_radii,
        representation_shift=shift,
        tessellation_diagnostics=diagnostics,
        has_boundaries=return_faces,
        has_periodic_shifts=return_face_shifts,
        _make_cells=make_cells,
    )


def _cells(
    t: Tessellation,
    domain: Any,
    edges: Float64Array,
    ids: Int64Array,
    empty: npt.NDArray[np.bool_],
    keep: Tuple[str, ...],
    with_shifts: bool,
    include_empty: bool,
) -> List[Dict[str, Any]]:
    places = t.wrapped_points
    offsets = shifts = None
    if any(t.periodic):
        # pyvoro2 wraps a triclinic cell to another place than votess: whole edges lie between the two.
        wrapped: Float64Array = domain.remap_cart(t.points)
        moved = np.rint(np.linalg.solve(edges.T, (wrapped - places).T).T)
        if moved.any():
            offsets = moved @ edges
        places = places + moved @ edges
        if with_shifts and keep and t.shifts is not None:
            rows = t.neighbors
            seed = np.repeat(np.arange(len(t)), np.diff(rows.indptr))
            other = np.where(rows.indices >= 0, rows.indices, seed)  # the id of a wall is no index
            shifts = t.shifts + (moved[seed] - moved[other]).astype(np.int64)
    blocks = CellBlocks(t, keep, offsets, shifts, None if np.array_equal(ids, np.arange(len(ids))) else ids)
    cells: List[Dict[str, Any]] = []
    for number, volume, site, is_empty in zip(ids.tolist(), t.volumes.tolist(), places.tolist(), empty.tolist()):
        if not is_empty and keep:
            cells.append(blocks.add(LazyCell(id=number, volume=volume, site=site)))
            continue
        blocks.skip()
        if not is_empty:
            cells.append(Cell(id=number, volume=volume, site=site))
        elif include_empty:
            empty_parts: Dict[str, Any] = {name: [] for name in keep}
            cells.append(Cell(id=number, empty=True, volume=0.0, site=site, **empty_parts))
    return cells
