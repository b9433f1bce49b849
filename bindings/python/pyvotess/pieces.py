"""The pieces of cells in a mesh, see :meth:`pyvotess.Tessellation.pieces`."""

from __future__ import annotations

import ctypes
import operator
import os
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any, Iterator, NamedTuple, Optional, Union

import numpy as np

from . import _c_api
from ._arguments import as_count, as_number, as_path
from ._call import Callbacks, Handle, Progress, raise_on_failure, showing
from ._input import as_array
from ._library import lib

if TYPE_CHECKING:
    import numpy.typing as npt

    from ._state import SeedCells
    from ._types import BoolArray, Float64Array, Int32Array, Int64Array
    from .export.viewer import View

_FORMATS = (".glb", ".obj", ".stl", ".3mf", ".html")


class Piece(NamedTuple):
    """A closed triangle mesh. ``trimesh.Trimesh(piece.vertices, piece.triangles, process=False)`` takes it."""

    vertices: Float64Array  #: (V, 3)
    triangles: Int32Array  #: (T, 3) rows of ``vertices``, counterclockwise seen from outside
    on_surface: BoolArray  #: (T,) True on the surface of the mesh, False on a plane between two cells
    sources: Int32Array  #: (T,) the triangle of the mesh, or the seed beyond the plane


@dataclass(frozen=True)
class Pieces:
    """The connected parts of cells in a mesh: P pieces. ``pieces[k]`` is one of them.

    Those of cell i are ``range(indptr[i], indptr[i + 1])``, the largest first. Closed surfaces bound each piece, one more
    for each cavity. An edge occurs once in each direction, and more often in two cases: where more than two triangles of
    the mesh meet in it, and where ties leave triangles without an area. Pieces that touch share no vertices. Where a
    surface intersects itself, pieces overlap.
    """

    indptr: Int64Array  #: (N + 1,) the first piece of each cell
    vertex_offsets: Int64Array  #: (P + 1,) the first vertex of each piece
    vertices: Float64Array  #: (V, 3) those of the mesh as given
    triangle_offsets: Int64Array  #: (P + 1,) the first triangle of each piece
    triangles: Int32Array  #: (T, 3) vertices, counted from the first of the piece
    on_surface: BoolArray  #: (T,) True on the surface of the mesh, False on a plane between two cells
    sources: Int32Array  #: (T,) the triangle of the mesh, or the seed beyond the plane
    volumes: Float64Array  #: (P,)
    centroids: Float64Array  #: (P, 3)
    ids: Int64Array  #: (N,) the seeds of the cells

    def __len__(self) -> int:
        """P, the number of pieces."""
        return len(self.volumes)

    def __getitem__(self, index: int) -> Piece:
        number = operator.index(index)
        k = number + len(self) if number < 0 else number
        if not 0 <= k < len(self):
            raise IndexError(f"piece {number} of {len(self)} pieces")
        part = slice(self.triangle_offsets[k], self.triangle_offsets[k + 1])
        return Piece(
            self.vertices[self.vertex_offsets[k] : self.vertex_offsets[k + 1]],
            self.triangles[part],
            self.on_surface[part],
            self.sources[part],
        )

    def __iter__(self) -> Iterator[Piece]:
        return (self[k] for k in range(len(self)))

    def __repr__(self) -> str:
        return f"<pyvotess.Pieces: {len(self)} pieces of {len(self.indptr) - 1} cells, {len(self.triangles)} triangles>"

    def _repr_html_(self) -> str:
        """Returns a table for notebooks, and a small picture."""
        from .export.html import html_of_pieces

        return html_of_pieces(self)

    @property
    def counts(self) -> Int64Array:
        """(N,) number of pieces of each cell, as a new array."""
        return np.diff(self.indptr)

    @property
    def cells(self) -> Int64Array:
        """(P,) the row of each piece, as a new array."""
        return np.repeat(np.arange(len(self.indptr) - 1), self.counts)

    def view(self) -> View:
        """Returns a page that shows the pieces in a browser, where the reader turns, cuts and parts them.

        See :meth:`Tessellation.view`.

        >>> corners = np.array([(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1)])
        >>> solid = (corners, [(0, 2, 1), (0, 1, 3), (0, 3, 2), (1, 2, 3)])
        >>> vt.tessellate(points, mesh=solid).pieces(gap=0.05).view().save("pieces.html")
        """
        from .export.viewer import view_of_pieces

        return view_of_pieces(self)

    def save(self, path: Union[str, os.PathLike[str]], ids: Optional[npt.ArrayLike] = None) -> None:
        """Writes the pieces to a file, whole or not at all.

        Each piece is an object. Its name is the index of its seed, as in "17"; or "17.0", "17.1" if a cell has several.
        Materials are ``surface`` and ``inside``.

        - ``.glb``: y is up, as glTF demands. The origin of each object is at its centroid. At most 4 GiB.
        - ``.obj``: with coordinates as given, and the names of the materials.
        - ``.3mf``: for printers, in millimeters.
        - ``.stl``: all pieces in one, without names and materials.
        - ``.html``: the page of :meth:`view`.

        ids : (N,) whole numbers to name cells by.

        Raises ValueError for an unknown extension, a wrong number of ids, and a file above 4 GiB; OSError when the file
        cannot be written.

        >>> corners = np.array([(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1)])
        >>> solid = (corners, [(0, 2, 1), (0, 1, 3), (0, 3, 2), (1, 2, 3)])
        >>> vt.tessellate(points, mesh=solid).pieces(gap=0.01).save("pieces.glb")
        """
        from .export.mesh_file import writing
        from .export.whole_file import whole_file

        file = as_path(path, "path")
        extension = os.path.splitext(file)[1].lower()
        if extension not in _FORMATS:
            raise ValueError(f"path is {file!r}: known are {' '.join(_FORMATS)}")
        numbers = as_array(self.ids if ids is None else ids, "ids")
        if numbers.shape != self.ids.shape or numbers.dtype.kind not in "iu":
            raise ValueError(
                f"ids have shape {numbers.shape} and type {numbers.dtype}: give a whole number for each of the "
                f"{len(self.ids)} cells"
            )
        if extension == ".html":
            replace(self, ids=numbers.astype(np.int64)).view().save(file)
            return
        names = ("indptr", "vertex_offsets", "vertices", "triangle_offsets", "triangles", "on_surface", "centroids")
        arrays = {name: np.ascontiguousarray(getattr(self, name)) for name in names}
        arrays["ids"] = np.ascontiguousarray(numbers, np.int64)
        given = _c_api.PieceArrays(
            struct_size=ctypes.sizeof(_c_api.PieceArrays),
            rows=len(self.ids),
            **{name: array.ctypes.data for name, array in arrays.items()},
        )
        with whole_file(file) as temporary, writing(temporary) as write:
            status = lib.votess_write_pieces(ctypes.byref(given), extension.encode(), write, None)
        raise_on_failure(status)


def make_pieces(
    t: SeedCells, result: Handle, gap: float, threads: int, progress: Union[None, bool, Progress]
) -> Pieces:
    handle = Handle("pieces")
    distance, count = as_number(gap, "gap"), as_count(threads, "threads", 32)
    with showing(progress) as show, Callbacks() as callbacks:
        status = lib.votess_pieces_new(
            result.pointer, distance, count, callbacks.progress(show), None, ctypes.byref(handle.pointer)
        )
    raise_on_failure(status)

    return Pieces(
        **handle.arrays("indptr", "vertex_offsets", "vertices", "triangle_offsets", "triangles"),
        **handle.arrays("sources", "volumes", "centroids"),
        on_surface=handle.array("on_surface").view(np.bool_),
        ids=np.arange(len(t)) if t.ids is None else np.asarray(t.ids, np.int64),
    )
