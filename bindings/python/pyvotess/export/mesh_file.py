"""Files of meshes and of pieces, written by the library."""

from __future__ import annotations

import contextlib
import ctypes
import os
from typing import TYPE_CHECKING, Any, Callable, Dict, Optional

import numpy as np

from .. import _c_api
from .._call import Callbacks, raise_on_failure, watched
from .._library import lib
from ..stats import MeshQuality
from .whole_file import whole_file

if TYPE_CHECKING:
    import numpy.typing as npt

    from .._state import SeedCells

    Arrays = Dict[str, npt.NDArray[Any]]


def _make_folders(folder: str, stack: contextlib.ExitStack) -> None:
    """Makes a folder and those that it is in. Those that are new and empty are removed when ``stack`` ends by an error."""
    if os.path.isdir(folder):
        return
    _make_folders(os.path.dirname(folder), stack)
    os.mkdir(folder)

    def end(kind: object, *_: object) -> None:
        if kind is not None:
            with contextlib.suppress(OSError):
                os.rmdir(folder)

    stack.push(end)


def write_by(call: Callable[[Any], int], path: str, folder: str = "") -> None:
    """Lets ``call`` write the file by a callback, and those of a format of several, which lie in ``folder``.

    The latter appear when all are written, or not at all. Raises for an error of a file, else for the status of ``call``.
    """
    with contextlib.ExitStack() as stack:
        files = {None: stack.enter_context(open(path, "wb"))}

        def write(piece: Any) -> int:
            name = piece[0].file
            if name not in files:
                target = os.path.join(folder, name.decode())
                _make_folders(os.path.dirname(target), stack)
                files[name] = stack.enter_context(open(stack.enter_context(whole_file(target)), "wb"))
            files[name].write((ctypes.c_char * piece[0].count).from_address(piece[0].data))
            return 1

        with Callbacks() as callbacks:
            status = watched(call, callbacks.guarded(_c_api.WriteCallback, write, 0))
        raise_on_failure(status)
        for file in files.values():  # an error of the last bytes comes before any file appears
            file.flush()


def _arrays_of(t: SeedCells) -> Dict[str, Any]:
    seeds = np.ascontiguousarray(t.points, np.float64)
    return {
        "indptr": t.indptr,
        "indices": t.indices,
        "shifts": t.shifts,
        "face_offsets": t.face_offsets,
        "face_vertices": t.face_vertices,
        "vertices": t.vertices,
        "cell_vertex_indptr": t.cell_vertex_indptr,
        "cell_vertex_indices": t.cell_vertex_indices,
        "seeds": seeds,
        "weights": t.weights,
    }


def write_mesh(
    path: str,
    extension: str,
    t: SeedCells,
    columns: Arrays,
    colors: Optional[npt.NDArray[np.uint8]],
    skip_open: bool,
    folder: str = "",
    min_edge: float = 0.0,
) -> int:
    """Writes the cells of ``t``, a result with faces; those of the plane as .vtu alone.

    ``columns``: (N,) or (N, k) numbers of the machine's byte order, for .vtu. ``colors``: (N, 3) of sRGB, needed by
    .glb, possible for .ply. ``folder``: of .foam. Returns the number of edges below ``min_edge`` that stay. ValueError
    when a .glb would be larger than 4 GiB.
    """
    arrays = {**_arrays_of(t), "colors": None if colors is None else np.ascontiguousarray(colors)}
    edges = np.zeros(9) if t.cell is None else t.cell
    kept = ctypes.c_uint64()
    flags = dict(planar=t.planar, skip_open=int(skip_open), min_edge=min_edge, short_edges=ctypes.addressof(kept))
    _write(path, extension, arrays, columns, t.box, edges, folder, **flags)
    return kept.value


def short_edges_stay(count: int, min_edge: float) -> str:
    reasons = "cells would not remain polyhedra of about their volumes, or vertices would leave their walls"
    return f"{count} edges below min_edge={min_edge} stay: {reasons}"


def mesh_quality(t: SeedCells, skip_open: bool, min_edge: float) -> MeshQuality:
    """Measures the cells of ``t``, a result with faces."""
    edges = np.zeros(9) if t.cell is None else t.cell
    mesh = _mesh_of(_arrays_of(t), {}, t.box, edges, skip_open=int(skip_open), min_edge=min_edge)
    measured = _c_api.MeshQuality()
    raise_on_failure(watched(lib.votess_measure_mesh, mesh, measured))
    return _quality(measured)


def _quality(measured: _c_api.Struct) -> MeshQuality:
    return MeshQuality(**{name: getattr(measured, name) for name in MeshQuality.__dataclass_fields__})


def _piece_arrays(arrays: Arrays, **options: float) -> Any:
    kept = {name: np.ascontiguousarray(array) for name, array in arrays.items()}
    return _c_api.PieceArrays(rows=len(kept["ids"]), **kept, **options)


def write_pieces(path: str, extension: str, arrays: Arrays, min_edge: float = 0.0, folder: str = "") -> int:
    """Writes pieces. ``folder``: of .foam. Returns the number of edges below ``min_edge`` that stay."""
    kept = ctypes.c_uint64()
    given = _piece_arrays(arrays, min_edge=min_edge, short_edges=ctypes.addressof(kept))
    write_by(lambda write: lib.votess_write_pieces(given, extension.encode(), write, None), path, folder)
    return kept.value


def quality_of_pieces(arrays: Arrays, min_edge: float) -> MeshQuality:
    """Measures pieces as one mesh."""
    measured = _c_api.MeshQuality()
    raise_on_failure(watched(lib.votess_measure_pieces, _piece_arrays(arrays, min_edge=min_edge), measured))
    return _quality(measured)


def write_pieces_of_cells(path: str, t: SeedCells, columns: Arrays) -> None:
    """Writes the pieces of cells in a mesh as polyhedra of a .vtu. ``columns``: as for :func:`write_mesh`."""
    pieces = t.pieces()  # type: ignore[attr-defined]
    count = len(pieces.triangles)
    arrays: Dict[str, Any] = {
        "indptr": pieces.triangle_offsets,
        "indices": np.full(count, -1, np.int32),
        "face_offsets": np.arange(0, 3 * count + 1, 3, dtype=np.int64),
        "face_vertices": pieces._corners.astype(np.int32),
        "vertices": pieces.vertices,
        "cell_vertex_indptr": pieces.vertex_offsets,
        "cell_vertex_indices": np.arange(len(pieces.vertices), dtype=np.int32),
    }
    of_pieces = {name: array[pieces.cells] for name, array in columns.items()}
    of_pieces.update(volume=pieces.volumes, centroid=pieces.centroids)
    _write(path, ".vtu", arrays, of_pieces, np.zeros((2, 3)))


def _mesh_of(
    arrays: Arrays, columns: Arrays, box: npt.NDArray[np.float64], edges: npt.NDArray[np.float64], **flags: float
) -> Any:
    """Returns the struct of the library."""
    kept = [np.ascontiguousarray(array) for array in columns.values()]
    c_columns = (_c_api.Column * len(kept))()
    for column, name, array in zip(c_columns, columns, kept):
        column.name, column.values = name.encode(), array.ctypes.data
        column.width = array.shape[1] if array.ndim == 2 else 1
        column.kind, column.bytes = array.dtype.kind.encode(), array.itemsize
    mesh = _c_api.Mesh(
        column_count=len(kept),
        cells=len(arrays["indptr"]) - 1,
        vertex_count=len(arrays["vertices"]),
        columns=c_columns,
        box_lower=tuple(box[0]),
        box_upper=tuple(box[1]),
        edges=tuple(np.ravel(edges)),
        **flags,
        **arrays,
    )
    mesh.kept = kept  # lives as long
    return mesh


def _write(
    path: str,
    extension: str,
    arrays: Arrays,
    columns: Arrays,
    box: npt.NDArray[np.float64],
    edges: npt.NDArray[np.float64] = np.zeros(9),
    folder: str = "",
    **flags: float,
) -> None:
    mesh = _mesh_of(arrays, columns, box, edges, **flags)
    write_by(lambda write: lib.votess_write_mesh(mesh, extension.encode(), write, None), path, folder)
