"""Columns of the cells for tables, colors and files, and columns of the caller."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any, Container, Dict, Optional, Tuple

import numpy as np

from .._arguments import shown
from .._arrays import ARRAYS, TABLE
from .._input import as_array, as_float64_or_float32

if TYPE_CHECKING:
    import numpy.typing as npt

    from .._state import SeedCells
    from .._types import Float64Array

    Columns = Optional[Mapping[str, npt.ArrayLike]]

_WORDS = {"area": "surface_area", "weights": "weight"}  # of colors, beside names of arrays
_IN_PLANE = {"volume": "area", "surface_area": "perimeter"}


def neighbor_counts(t: SeedCells) -> npt.NDArray[np.int32]:
    """Returns (N,) int32 numbers of neighbors, without walls."""
    rows = t.neighbors
    cell = np.repeat(np.arange(len(t)), np.diff(rows.indptr))
    return np.bincount(cell[rows.indices >= 0], minlength=len(t)).astype(np.int32)


def _arrays_of_cells(t: SeedCells) -> Dict[str, Tuple[str, npt.NDArray[Any]]]:
    """Returns the arrays of the result that are columns of cells, by name, and the names of the columns."""
    held = t._data.arrays
    return {name: (of.column, held[name]) for name, of in TABLE.items() if of.column and name in held}


def column_of(t: SeedCells, word: str) -> str:
    """Returns the name of a column, as in .csv, for a word of ``color``: "area", an array of the result, or that name."""
    name = _WORDS.get(word) or (TABLE[word].column if word in TABLE else word)
    return _IN_PLANE.get(name, name) if t.planar else name


def cell_columns(t: SeedCells) -> Dict[str, npt.NDArray[Any]]:
    """Returns all numbers of the cells in the result, as (N,) columns by name. Names are those of .csv."""
    points = np.asarray(t.points if t.ids is None else t.points[t.ids])
    columns: Dict[str, npt.NDArray[Any]] = dict(zip("xyz", points.T))
    if t.weights is not None:
        columns["weight"] = t.weights
    if "neighbors" in t.wanted:
        columns["neighbors"] = neighbor_counts(t)
    for name, (column, values) in _arrays_of_cells(t).items():
        if values.ndim == 1:
            columns[column_of(t, name)] = values
        else:
            columns.update({f"{column}_{axis}": part for axis, part in zip("xyz", values.T)})
    columns["status"] = t.status
    if t.duplicate_of is not None:
        columns["duplicate_of"] = t.duplicate_of
    return columns


#: Names of the cell data of .vtu, which the caller's columns must not have.
VTU_NAMES = frozenset(("id", "neighbors", "status", *(of.column for of in TABLE.values() if of.column)))


def with_z(vectors: npt.NDArray[np.float64]) -> npt.NDArray[np.float64]:
    """Returns (K, 3) vectors from (K, 3) or (K, 2): those of VTK have three components."""
    return vectors if vectors.shape[1] == 3 else np.insert(vectors, 2, 0.0, axis=1)


def vtu_columns(t: SeedCells) -> Dict[str, npt.NDArray[Any]]:
    """Returns the cell data of .vtu, (N,) or (N, 3), by ``want``. z is 0 in the plane. In a mesh measures are of pieces."""
    of_cells = {column: values if values.ndim == 1 else with_z(values) for column, values in _arrays_of_cells(t).values()}
    data: Dict[str, npt.NDArray[Any]] = {"id": np.arange(len(t), dtype=np.int64)}
    data.update({name: of_cells[name] for name in ("volume",) if name in of_cells}, neighbors=neighbor_counts(t))
    data.update({name: of_cells[name] for name in ("centroid",) if name in of_cells}, status=t.status)
    return data if t.in_mesh else {**data, **of_cells}


def named_columns(columns: Columns) -> Mapping[str, npt.ArrayLike]:
    """Returns the caller's columns by name, none for None."""
    if columns is not None and not isinstance(columns, Mapping):
        raise TypeError(f"columns is {shown(columns)}: give a dict of arrays")
    return columns or {}


def added_columns(t: SeedCells, columns: Columns, taken: Container[str]) -> Dict[str, npt.NDArray[Any]]:
    """Returns the caller's columns, (N,) or (N, k), as little-endian numbers of at most 8 bytes.

    ``taken``: reserved names. Raises ValueError for a bad name, shape or type.
    """
    result: Dict[str, npt.NDArray[Any]] = {}
    for name, values in named_columns(columns).items():
        if not isinstance(name, str) or not name or "/" in name or "\0" in name:
            raise ValueError(f"columns has the name {shown(name)}: give a non-empty text without / and zero characters")
        if name in taken:
            raise ValueError(f"columns has {name!r}, but the file has an array of that name: rename it")
        array = as_array(values, f"column {name!r}")
        if array.ndim not in (1, 2) or len(array) != len(t) or array.shape[1:] == (0,):
            raise ValueError(f"column {name!r} has shape {array.shape}: give one row for each of the {len(t)} cells")
        if array.dtype.kind not in "biuf":
            raise ValueError(f"column {name!r} has dtype {array.dtype}: give numbers")
        kind = {"b": "u1", "f": f"f{min(max(array.dtype.itemsize, 4), 8)}"}.get(array.dtype.kind)
        result[name] = np.ascontiguousarray(array, np.dtype(kind) if kind else array.dtype.newbyteorder("<"))
    return result


def color_values(t: SeedCells, color: Any) -> Tuple[Float64Array, str]:
    """Returns (N,) values for colors, and their label. ``color``: a word of :func:`column_of`, or (N,) values."""
    if isinstance(color, str):
        columns = cell_columns(t)
        name = column_of(t, color)
        if name in columns:
            return np.asarray(columns[name], np.float64), name.replace("_", " ")
        array = next((key for key, of in TABLE.items() if of.column and column_of(t, key) == name), name)
        if array in ARRAYS or any(array in names for names in ARRAYS.values()):
            getattr(t, array)  # raises with the word for want, or the name of the array
        axes = "'x', 'y'" if t.planar else "'x', 'y', 'z'"
        raise ValueError(
            f"color is {color!r}: give 'volume', 'neighbors', 'area', {axes} or {len(t)} values; "
            f"columns are {', '.join(columns)}"
        )
    values = as_float64_or_float32(color, "color").astype(np.float64, copy=False)
    if values.shape != (len(t),):
        raise ValueError(f"color has shape {values.shape}: give one value for each of the {len(t)} cells")
    return values, ""
