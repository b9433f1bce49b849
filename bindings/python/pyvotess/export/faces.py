"""The faces of all cells, each once, as text: .ply with the two cells of each, and .obj."""

from __future__ import annotations

from typing import IO, TYPE_CHECKING, Any, List, Optional

import numpy as np

from .geometry import Mesh, faces_once, mesh_of, ranges, triangles

if TYPE_CHECKING:
    import numpy.typing as npt

    from ..tessellation import Tessellation

    Int64Array = npt.NDArray[np.int64]
    UInt8Array = npt.NDArray[np.uint8]

_ROWS = 1 << 16  # formatted at a time


def _put_rows(file: IO[str], row: str, table: npt.NDArray[Any]) -> None:
    """Each row of the table through the format ``row``; the loop over rows is that of Python's % operator."""
    for begin in range(0, len(table), _ROWS):
        part = table[begin : begin + _ROWS]
        file.write(row * len(part) % tuple(part.ravel().tolist()))


def _corners(mesh: Mesh, faces: Int64Array, size: int) -> Int64Array:
    """(len(faces), size) the corners of faces that all have so many."""
    corners: Int64Array = mesh.loops[mesh.offsets[faces][:, None] + np.arange(size)]
    return corners


def write_ply(path: str, t: Tessellation, colors: Optional[UInt8Array]) -> None:
    """In text, the polygons ascending by their number of corners; with ``colors`` (N, 3), in triangles.

    Readers differ in what they take. One that knows lists of one length only in binary reads polygons from text; one
    that groups faces by their number of corners finds the data of each only when the faces come in that order; and one
    that makes triangles of polygons would give their colors to the wrong ones.
    """
    mesh = mesh_of(t, "a .ply file")
    faces = faces_once(t, mesh)
    cell, neighbor = mesh.cell_of_face, t.neighbors.indices
    tables: List[npt.NDArray[Any]] = []  # rows of equal length: corners, then what goes with the face
    if colors is None:
        sizes = np.diff(mesh.offsets)[faces]
        for size in np.unique(sizes):
            some = faces[sizes == size]
            tables.append(np.column_stack((_corners(mesh, some, int(size)), cell[some], neighbor[some])))
    else:
        corners, face = triangles(mesh, faces)
        tables.append(np.column_stack((corners, cell[face], neighbor[face], colors[cell[face]])))
    tail = 2 if colors is None else 5
    longest = max((table.shape[1] - tail for table in tables), default=0)
    head = [
        "ply",
        "format ascii 1.0",
        "comment Voronoi cells by pyvotess: each face once, counterclockwise seen from outside `cell`",
        "comment cell and neighbor are rows of the input from 0; a negative neighbor is a wall",
        f"element vertex {len(mesh.vertices)}",
        *(f"property double {axis}" for axis in "xyz"),
        f"element face {sum(map(len, tables))}",
        f"property list {'uchar' if longest < 256 else 'int'} int vertex_indices",
        "property int cell",
        "property int neighbor",
        *(f"property uchar {name}" for name in ("red", "green", "blue") if colors is not None),
        "end_header",
    ]
    with open(path, "w", encoding="ascii", newline="\n") as file:
        file.write("\n".join(head) + "\n")
        _put_rows(file, "%r %r %r\n", mesh.vertices)
        for table in tables:
            size = table.shape[1] - tail
            _put_rows(file, f"{size}" + " %d" * table.shape[1] + "\n", table)


def write_obj(path: str, t: Tessellation) -> None:
    """The polygons in the order of the rows, with corners from 1 as the format has them."""
    mesh = mesh_of(t, "an .obj file")
    faces = faces_once(t, mesh)
    sizes = np.diff(mesh.offsets)[faces]
    with open(path, "w", encoding="ascii", newline="\n") as file:
        file.write("# Voronoi cells by pyvotess: each face once\n")
        _put_rows(file, "v %r %r %r\n", mesh.vertices)
        for begin in range(0, len(faces), _ROWS):
            part = slice(begin, begin + _ROWS)
            # One format for the numbers of many rows of different lengths.
            rows = {int(size): "f" + " %d" * int(size) + "\n" for size in np.unique(sizes[part])}
            text = "".join(map(rows.__getitem__, sizes[part].tolist()))
            corners = mesh.loops[ranges(mesh.offsets[faces[part]], sizes[part])]
            file.write(text % tuple((corners + 1).tolist()))
