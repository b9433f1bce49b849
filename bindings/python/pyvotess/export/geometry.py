"""The mesh of all cells: polygons, polyhedra of VTK, triangles."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple, Optional, Tuple

import numpy as np

if TYPE_CHECKING:
    import numpy.typing as npt

    from .._state import SeedCells
    from .._types import Float64Array, Int64Array


POLYGON, POLYHEDRON = 7, 42  #: cell types of VTK


class Mesh(NamedTuple):
    """The polygons of all cells. Face k has the corners ``loops[offsets[k]:offsets[k+1]]``, rows of vertices."""

    indptr: Int64Array  #: (N + 1,): the faces of cell i begin at indptr[i]
    offsets: Int64Array  #: (F + 1,)
    loops: Int64Array  #: (offsets[F],) counterclockwise seen from outside the cell
    vertices: Float64Array  #: (V, 3)

    @property
    def cell_of_face(self) -> Int64Array:
        return np.repeat(np.arange(len(self.indptr) - 1), np.diff(self.indptr))


def mesh_of(t: SeedCells, caller: str, planar: bool = False, may_skip: bool = False, open: Optional[str] = None) -> Mesh:
    """Returns the mesh of a result. Raises ValueError, which names ``caller``, without faces; without ``planar`` in the plane.

    There vertices are (V, 2), and a face has two corners. Cells that reach infinity are refused, or with ``open="skip"``
    have no faces, where the caller has this parameter (``may_skip``).
    """
    if not planar:
        t._require_space(caller)
    if not may_skip:
        t._require_end(caller)
    try:
        closed = t._closed_cells(caller, open)
        indptr, offsets, loops = (np.asarray(a, np.int64) for a in (t.neighbors.indptr, t.faces.indptr, t.faces.indices))
        vertices = np.asarray(t.vertices, np.float64)
    except AttributeError:
        raise ValueError(f"{caller} needs {_polygons_of(t)}") from None
    if closed is None:
        return Mesh(indptr, offsets, loops, vertices)
    faces = np.diff(indptr)
    kept = np.flatnonzero(np.repeat(closed, faces))
    corners = np.diff(offsets)[kept]
    return Mesh(begins(np.where(closed, faces, 0)), begins(corners), loops[ranges(offsets[kept], corners)], vertices)


def _polygons_of(t: SeedCells) -> str:
    """Returns the end of a message: where the polygons of the cells come from."""
    if t.in_mesh:
        return "polygons of whole cells, and a mesh cuts these: use image(), or view() and save() of pieces()"
    text = "the polygons of the cells: put 'faces' into want"
    if t.weights is None:
        return text
    return f"{text}. After a fit: vt.tessellate(t.points, t.domain, weights=t.weights, want='faces,volumes') makes the same cells"


def begins(counts: npt.NDArray[np.integer]) -> Int64Array:
    """Returns (len(counts) + 1,) the starts of rows of these lengths, and the end of the last."""
    result = np.zeros(len(counts) + 1, np.int64)
    np.cumsum(counts, out=result[1:])
    return result


def ranges(first: npt.NDArray[np.integer], counts: npt.NDArray[np.integer]) -> Int64Array:
    """Returns first[0], first[0] + 1, ... (counts[0] numbers), then first[1], ..."""
    begin = begins(counts)
    return np.repeat(first - begin[:-1], counts) + np.arange(begin[-1])


def polyhedra(mesh: Mesh, cells: Int64Array) -> Tuple[Int64Array, Int64Array]:
    """Returns these cells, none of them empty, as polyhedra of VTK, and their starts (one value more).

    A cell is its number of faces, then for each face its number of corners and the corners.
    """
    face_count = mesh.indptr[cells + 1] - mesh.indptr[cells]
    faces = ranges(mesh.indptr[cells], face_count)
    sizes = mesh.offsets[faces + 1] - mesh.offsets[faces]
    # A face follows the earlier faces with their numbers of corners, and one number for each cell up to its own.
    place = begins(sizes + 1)[:-1] + np.repeat(np.arange(1, len(cells) + 1), face_count)
    face_begin = begins(face_count)
    begin = begins(sizes + 1)[face_begin] + np.arange(len(cells) + 1)
    words = np.empty(begin[-1], np.int64)
    words[begin[:-1]] = face_count
    words[place] = sizes
    words[ranges(place + 1, sizes)] = mesh.loops[ranges(mesh.offsets[faces], sizes)]
    return words, begin


def with_lengths(words: Int64Array, lengths: Int64Array) -> Int64Array:
    """Returns the words of all cells, each cell after its number of words."""
    place = begins(lengths + 1)
    stream = np.empty(place[-1], np.int64)
    stream[place[:-1]] = lengths
    stream[ranges(place[:-1] + 1, lengths)] = words
    return stream


def triangles(mesh: Mesh, faces: Int64Array) -> Tuple[Int64Array, Int64Array]:
    """Returns fans of triangles (M, 3) of these faces, with their orientation, and the face of each triangle (M,)."""
    sizes = mesh.offsets[faces + 1] - mesh.offsets[faces]
    count = np.maximum(sizes - 2, 0)
    first = mesh.offsets[faces]
    second = ranges(first + 1, count)
    corners = np.stack((np.repeat(first, count), second, second + 1), axis=1)
    return mesh.loops[corners], np.repeat(faces, count)
