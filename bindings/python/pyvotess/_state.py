"""What a result holds, read from the library's handle; and how it is pickled, without that handle."""

from __future__ import annotations

import ctypes
from dataclasses import dataclass, fields
from typing import TYPE_CHECKING, Any, Dict, Optional, Tuple

import numpy as np

from ._c_api import ErrorCode
from ._call import Handle, VotessError, array_of, raise_on_failure
from ._library import lib
from .stats import Stats, read_stats

if TYPE_CHECKING:
    import numpy.typing as npt

    from .tessellation import Tessellation

    Float64Array = npt.NDArray[np.float64]

# Arrays of each word of want: name, type, columns (0: one number each).
_WANTED: Dict[str, Tuple[Tuple[str, Any, int], ...]] = {
    "neighbors": (("indptr", np.int64, 0), ("indices", np.int32, 0)),
    "volumes": (("volumes", np.float64, 0),),
    "centroids": (("centroids", np.float64, 3),),
    "counts": (("face_counts", np.uint32, 0), ("edge_counts", np.uint32, 0), ("vertex_counts", np.uint32, 0)),
    "areas": (("face_areas", np.float64, 0),),
    "normals": (("face_normals", np.float64, 3),),
    "surfaces": (("surface_areas", np.float64, 0),),
    "radii": (("security_radii", np.float64, 0),),
    "vertices": (
        ("vertices", np.float64, 3),
        ("cell_vertex_indptr", np.int64, 0),
        ("cell_vertex_indices", np.int32, 0),
    ),
    "faces": (("face_offsets", np.int64, 0), ("face_vertices", np.int32, 0)),
}
# These are empty where there is nothing to say.
_OPTIONAL = (("shifts", np.int8, 3), ("duplicate_of", np.int32, 0), ("weights", np.float64, 0))

_Vector = ctypes.c_double * 3


@dataclass(frozen=True)
class ResultData:
    """All that a result holds. Arrays go by their names in the library, and are missing where there are none."""

    arrays: Dict[str, npt.NDArray[Any]]
    box: Float64Array
    periodic: Tuple[bool, bool, bool]
    origin: Optional[Float64Array]
    cell: Optional[Float64Array]
    walls: Float64Array
    lists_walls: bool
    least_face: float
    stats: Stats


def _constant(values: Any) -> Float64Array:
    array = np.array(values, dtype=np.float64)
    array.flags.writeable = False
    return array


def read_result(result: Handle, wanted: Tuple[str, ...]) -> ResultData:
    arrays = {
        name: array_of(result, name, dtype, columns)
        for word in wanted
        for name, dtype, columns in _WANTED[word]
    }
    arrays["status"] = array_of(result, "status", np.uint8)
    for name, dtype, columns in _OPTIONAL:
        array = array_of(result, name, dtype, columns)
        if len(array):
            arrays[name] = array
    lower, upper = _Vector(), _Vector()
    raise_on_failure(lib.votess_result_box(result.pointer, lower, upper))
    axes = (ctypes.c_int32 * 3)()
    raise_on_failure(lib.votess_result_periodic(result.pointer, axes))
    has_cell, vectors = ctypes.c_int32(), [_Vector() for _ in range(4)]
    raise_on_failure(lib.votess_result_cell(result.pointer, ctypes.byref(has_cell), *vectors))
    return ResultData(
        arrays=arrays,
        box=_constant((lower, upper)),
        periodic=(bool(axes[0]), bool(axes[1]), bool(axes[2])),
        origin=_constant(vectors[0]) if has_cell.value else None,
        cell=_constant(vectors[1:]) if has_cell.value else None,
        walls=array_of(result, "walls", np.float64, columns=4),
        lists_walls=bool(lib.votess_result_lists_walls(result.pointer)),
        least_face=float(lib.votess_result_least_face(result.pointer)),
        stats=read_stats(result),
    )


def locked(data: ResultData) -> ResultData:
    """The same, whose arrays are read-only, as those in the library's memory are."""
    singles = (getattr(data, field.name) for field in fields(data))
    for array in (*data.arrays.values(), *singles):
        if isinstance(array, np.ndarray):
            array.flags.writeable = False
    return data


def same_arrays(ours: ResultData, anew: ResultData) -> str:
    """The name of an array that differs, lists by any number, the others beyond what rounding explains; else empty."""
    if ours.arrays.keys() != anew.arrays.keys():
        return ", ".join(sorted(ours.arrays.keys() ^ anew.arrays.keys()))
    error = 1e-9 if ours.stats.precision == "double" else 1e-4
    for name, array in ours.arrays.items():
        other = anew.arrays[name]
        if array.dtype.kind != "f":
            if not np.array_equal(array, other):
                return name
        elif array.shape != other.shape:
            return name
        else:
            scale = float(np.fmax.reduce(np.abs(other).ravel(), initial=0.0))  # NaN are skipped
            if not np.allclose(array, other, rtol=error, atol=error * scale, equal_nan=True):
                return name
    return ""


def tessellated_anew(t: Tessellation) -> Tuple[Handle, str]:
    """The library's object for a result that was unpickled: its points tessellated again, on the CPU.

    With the name of an array that came out otherwise, else empty.
    """
    from .tessellator import tessellate

    domain: Dict[str, Any] = {"walls": t.walls, "periodic": t.periodic}
    if t.cell is not None:
        domain.update(cell=t.cell, origin=t.origin)
    elif t._domain_given:
        domain["box"] = t.box
    again = tessellate(
        t.points,
        weights=t.weights,
        want=",".join(t.wanted) if t.wanted else (),
        list_walls=t.lists_walls,
        outside="drop",
        min_area=t.least_face,
        device="cpu",
        **domain,
    )
    if again._result is None:
        raise VotessError("a new result lacks its handle", ErrorCode.INTERNAL)
    return again._result, same_arrays(t._data, again._data)
