"""VTK's .vtu: a polyhedron for each cell. XML says where each array begins behind it, where they lie raw."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Dict, List, Tuple
from xml.sax.saxutils import quoteattr

import numpy as np

from .columns import neighbor_counts
from .geometry import begins, mesh_of, polyhedra, ranges

if TYPE_CHECKING:
    import numpy.typing as npt

    from ..tessellation import Tessellation

    Arrays = Dict[str, npt.NDArray[Any]]
    Int64Array = npt.NDArray[np.int64]

#: Names of the file's own cell data, that no column of the caller may have.
NAMES = frozenset(("id", "volume", "neighbors", "centroid", "status"))
POLYHEDRON = 42  # of VTK
_TYPES = {"f": "Float", "i": "Int", "u": "UInt"}


def cell_data(t: Tessellation) -> Arrays:
    """(N, ...) what the file holds of each cell; volume and centroid where they were wanted."""
    data: Arrays = {"id": np.arange(len(t), dtype=np.int64)}
    if "volumes" in t.wanted:
        data["volume"] = t.volumes
    data["neighbors"] = neighbor_counts(t)
    if "centroids" in t.wanted:
        data["centroid"] = t.centroids
    data["status"] = t.status
    return data


def _order(t: Tessellation) -> Int64Array:
    """The cells in the order of the file: without empty ones, ascending by their number of vertices, as meshio reads."""
    counts = np.diff(t.cell_vertices.indptr)
    cells = np.flatnonzero(counts)
    return cells[np.argsort(counts[cells], kind="stable")]


def _topology(t: Tessellation, cells: Int64Array) -> Arrays:
    mesh = mesh_of(t, "a .vtu file")
    own = t.cell_vertices
    counts = np.diff(own.indptr)[cells]
    words, begin = polyhedra(mesh, cells)
    return {
        "connectivity": own.indices[ranges(own.indptr[cells], counts)],
        "offsets": begins(counts)[1:],
        "types": np.full(len(cells), POLYHEDRON, np.uint8),
        "faces": words.astype(np.int32),
        "faceoffsets": begin[1:],
    }


def _header(sections: List[Tuple[str, Arrays]], points: int, cells: int) -> str:
    lines = [
        '<?xml version="1.0"?>',
        '<VTKFile type="UnstructuredGrid" version="1.0" byte_order="LittleEndian" header_type="UInt64">',
        "<UnstructuredGrid>",
        f'<Piece NumberOfPoints="{points}" NumberOfCells="{cells}">',
    ]
    offset = 0
    for section, arrays in sections:
        lines.append(f"<{section}>")
        for name, array in arrays.items():
            kind = f"{_TYPES[array.dtype.kind]}{8 * array.dtype.itemsize}"
            width = f' NumberOfComponents="{array.shape[1]}"' if array.ndim == 2 else ""
            lines.append(
                f'<DataArray type="{kind}" Name={quoteattr(name)}{width} format="appended" offset="{offset}"/>'
            )
            offset += 8 + array.nbytes
        lines.append(f"</{section}>")
    lines += ["</Piece>", "</UnstructuredGrid>", '<AppendedData encoding="raw">', "_"]
    return "\n".join(lines)


def write_vtu(path: str, t: Tessellation, columns: Arrays) -> None:
    cells = _order(t) if "vertices" in t.wanted else np.arange(0)
    topology = _topology(t, cells)
    data = {name: array[cells] for name, array in {**cell_data(t), **columns}.items()}
    sections: List[Tuple[str, Arrays]] = [("Points", {"Points": t.vertices}), ("Cells", topology), ("CellData", data)]
    with open(path, "wb") as file:
        file.write(_header(sections, len(t.vertices), len(cells)).encode())
        for _, arrays in sections:
            for array in arrays.values():
                file.write(np.array(array.nbytes, "<u8").tobytes())
                file.write(np.ascontiguousarray(array, array.dtype.newbyteorder("<")).data)
        file.write(b"\n</AppendedData>\n</VTKFile>\n")
