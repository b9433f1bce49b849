"""What pyvoro2's compute gives back beside the cells: the result, its diagnostics, and errors."""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property
from typing import TYPE_CHECKING, Any, Callable, Dict, List, Optional, Tuple

import numpy as np

if TYPE_CHECKING:
    import numpy.typing as npt

    Float64Array = npt.NDArray[np.float64]
    Int64Array = npt.NDArray[np.int64]
    BoolArray = npt.NDArray[np.bool_]

Cells = List[Dict[str, Any]]


@dataclass(frozen=True)
class TessellationIssue:
    """One finding."""

    code: str
    severity: str  #: "info", "warning" or "error"
    message: str
    examples: Tuple[Any, ...] = ()


@dataclass(frozen=True)
class TessellationDiagnostics:
    """Whether the cells fill the domain. Faces need no check: votess lists each from both sides."""

    domain_volume: float
    sum_cell_volume: float
    volume_ratio: float
    volume_gap: float
    volume_overlap: float
    n_sites_expected: int
    n_cells_returned: int
    missing_ids: Tuple[int, ...]
    empty_ids: Tuple[int, ...]
    face_shift_available: bool
    reciprocity_checked: bool
    n_faces_total: int  #: between cells, with their shifts; 0 when those were not asked for
    n_faces_orphan: int
    n_faces_mismatched: int
    issues: Tuple[TessellationIssue, ...]
    ok_volume: bool
    ok_reciprocity: bool
    ok: bool


class TessellationError(ValueError):
    """The cells do not fill the domain."""

    def __init__(self, message: str, diagnostics: TessellationDiagnostics) -> None:
        super().__init__(message, diagnostics)
        self.diagnostics = diagnostics

    def __str__(self) -> str:
        return str(self.args[0])


@dataclass(frozen=True)
class DuplicatePair:
    """Two points that are too close; ``i < j``."""

    i: int
    j: int
    distance: float


class DuplicateError(ValueError):
    """There are points too close to each other."""

    def __init__(self, message: str, pairs: Tuple[DuplicatePair, ...], threshold: float) -> None:
        super().__init__(message, pairs, threshold)
        self.pairs = pairs
        self.threshold = threshold

    def __str__(self) -> str:
        return str(self.args[0])


@dataclass(frozen=True, eq=False)
class TessellationResult:
    """Cells of n sites; arrays follow the order of the input, and are read-only."""

    dimension: int  #: 3
    domain: Any
    mode: str  #: "standard" or "power"
    sites: Float64Array  #: (n, 3), as given
    ids: Int64Array  #: (n,)
    cell_measures: Float64Array  #: (n,) volumes, 0 for an empty cell
    empty_mask: BoolArray  #: (n,)
    input_weights: Optional[Float64Array] = None  #: (n,) when weights were given
    backend_radii: Optional[Float64Array] = None  #: (n,) in power mode
    representation_shift: Optional[float] = None  #: what was added to the weights to make them squares of radii
    tessellation_diagnostics: Optional[TessellationDiagnostics] = None
    has_boundaries: bool = field(default=False, repr=False)  #: whether the cells have faces
    has_periodic_shifts: bool = field(default=False, repr=False)  #: whether the faces have shifts
    _make_cells: Optional[Callable[[], Cells]] = field(default=None, repr=False)

    normalized_vertices = None
    normalized_topology = None
    has_normalized_vertices = False
    has_normalized_topology = False
    global_vertices = None
    global_edges = None
    measure_kind = "volume"
    boundary_kind = "faces"

    def __post_init__(self) -> None:
        for name in ("sites", "ids", "cell_measures", "empty_mask", "input_weights", "backend_radii"):
            values = getattr(self, name)
            if values is not None:
                values = np.array(values)
                values.flags.writeable = False
                object.__setattr__(self, name, values)

    def __getstate__(self) -> Dict[str, Any]:
        return {**self.__dict__, "cells": self.cells, "_make_cells": None}

    @cached_property
    def cells(self) -> Cells:
        """The cells as dicts, in the order of the input, made at the first use."""
        assert self._make_cells is not None
        cells = self._make_cells()
        object.__setattr__(self, "_make_cells", None)
        return cells

    @property
    def has_tessellation_diagnostics(self) -> bool:
        return self.tessellation_diagnostics is not None

    def require_tessellation_diagnostics(self) -> TessellationDiagnostics:
        """The diagnostics; ValueError without them."""
        if self.tessellation_diagnostics is None:
            raise ValueError("there are no diagnostics: give compute return_diagnostics=True")
        return self.tessellation_diagnostics

    def require_boundaries(self) -> List[List[Dict[str, Any]]]:
        """The faces of each site, in the order of the input; ValueError without them."""
        if not self.has_boundaries:
            raise ValueError("there are no faces: give compute return_faces=True")
        faces: Dict[int, List[Dict[str, Any]]] = {cell["id"]: cell["faces"] for cell in self.cells}
        return [faces.get(number, []) for number in self.ids.tolist()]

    def require_normalized_vertices(self) -> Any:
        """Raises ValueError, as pyvoro2 does for three dimensions."""
        raise ValueError("there are no normalized vertices: those of pyvotess.tessellate(want='faces') are shared")

    def require_normalized_topology(self) -> Any:
        """Raises ValueError, as pyvoro2 does for three dimensions."""
        raise ValueError("there is no normalized topology: the mesh of pyvotess.tessellate(want='faces') is shared")


def diagnose(
    domain_volume: float,
    volumes: Float64Array,
    ids: Int64Array,
    empty: BoolArray,
    includes_empty: bool,
    face_count: Optional[int],
    tol_rel: float,
    tol_abs: float,
) -> TessellationDiagnostics:
    """``face_count`` is None when the faces have no shifts."""
    total = float(volumes.sum())
    hidden = tuple(ids[empty].tolist())
    missing = () if includes_empty else hidden
    issues: Tuple[TessellationIssue, ...] = ()
    if missing:
        issues += (TessellationIssue("HIDDEN_IDS", "info", f"{len(missing)} empty cells are left out", missing[:10]),)
    ok = abs(total - domain_volume) <= max(tol_rel * domain_volume, tol_abs) or not len(ids)
    if not ok:
        message = f"the volumes sum to {total:g}, that of the domain is {domain_volume:g}"
        issues += (TessellationIssue("GAP" if total < domain_volume else "OVERLAP", "error", message),)
    return TessellationDiagnostics(
        domain_volume=domain_volume,
        sum_cell_volume=total,
        volume_ratio=total / domain_volume,
        volume_gap=max(domain_volume - total, 0.0),
        volume_overlap=max(total - domain_volume, 0.0),
        n_sites_expected=len(ids),
        n_cells_returned=len(ids) - len(missing),
        missing_ids=missing,
        empty_ids=hidden,
        face_shift_available=face_count is not None,
        reciprocity_checked=face_count is not None,
        n_faces_total=face_count or 0,
        n_faces_orphan=0,
        n_faces_mismatched=0,
        issues=issues,
        ok_volume=ok,
        ok_reciprocity=True,
        ok=ok,
    )
