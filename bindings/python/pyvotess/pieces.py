"""The pieces of cells in a mesh, see :meth:`pyvotess.Tessellation.pieces`."""

from __future__ import annotations

import operator
import os
import warnings
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any, Dict, Iterator, List, NamedTuple, Optional, Tuple, Union

import numpy as np

from ._arguments import as_count, as_number, as_path, counted
from ._call import Callbacks, Handle, Progress, raise_on_failure, showing
from ._input import as_array, as_one_each
from ._library import lib

if TYPE_CHECKING:
    import numpy.typing as npt

    from ._state import SeedCells
    from ._types import BoolArray, Float64Array, Int32Array, Int64Array
    from .export.image import Image
    from .export.viewer import View
    from .stats import MeshQuality

_FORMATS = (".glb", ".obj", ".stl", ".3mf", ".foam", ".msh", ".cgns", ".html")
_JOINED = (".foam", ".msh", ".cgns")  # one mesh of all pieces
_FLAT_FORMATS = (".geojson",)


class Piece(NamedTuple):
    """A closed triangle mesh. ``trimesh.Trimesh(piece.vertices, piece.triangles, process=False)`` takes it."""

    vertices: Float64Array  #: (V, 3)
    triangles: Int32Array  #: (T, 3) rows of ``vertices``, counterclockwise seen from outside
    on_surface: BoolArray  #: (T,) True on the surface of the mesh, False on a plane between two cells
    sources: Int32Array  #: (T,) the triangle of the mesh, or the seed beyond the plane


@dataclass(frozen=True, eq=False)
class Pieces:
    """The connected parts of cells in a mesh: P pieces. ``pieces[k]`` is one of them.

    Those of cell i are ``range(indptr[i], indptr[i + 1])``, the largest first. Closed surfaces bound each piece, one more
    for each cavity. An edge occurs once in each direction, and more often in two cases: where more than two triangles of
    the mesh meet in it, and where ties leave triangles without an area. Pieces that touch share no vertices. Where a
    surface intersects itself, pieces overlap.

    In the plane pieces are polygons with holes. Arrays then have two columns instead of three, and ``triangles`` are
    edges, ring after ring, the outline first, with the piece on the left. :meth:`rings` returns places, and
    ``shapely.geometry.shape(f["geometry"]) for f in pieces.__geo_interface__["features"]`` makes polygons of Shapely.
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

    @property
    def planar(self) -> bool:
        """Whether the pieces are polygons of the plane."""
        return bool(self.vertices.shape[1] == 2)

    @property
    def _piece_of(self) -> Int64Array:
        """(T,) the piece of each triangle."""
        return np.repeat(np.arange(len(self)), np.diff(self.triangle_offsets))

    @property
    def _corners(self) -> Int64Array:
        """(T, 3) the corners of triangles, counted from the first vertex of all pieces."""
        return self.triangles + self.vertex_offsets[self._piece_of, None]

    def rings(self, index: int) -> List[Float64Array]:
        """Returns the rings of a piece of the plane: (n, 2) places each, the outline counterclockwise, holes clockwise.

        Raises ValueError for pieces in three dimensions.

        >>> square = {"type": "Polygon", "coordinates": [[(0, 0), (1, 0), (1, 1), (0, 1)]]}
        >>> [len(ring) for ring in vt.tessellate([(0.5, 0.5)], mesh=square).pieces().rings(0)]
        [4]
        """
        if not self.planar:
            raise ValueError("rings() needs pieces of the plane: these are triangle meshes, take pieces[k]")
        piece = self[index]
        starts = piece.triangles[:, 0]
        found, begin = [], 0
        for k, end in enumerate(piece.triangles[:, 1]):
            if end == starts[begin]:
                found.append(piece.vertices[starts[begin : k + 1]])
                begin = k + 1
        return found

    @property
    def __geo_interface__(self) -> Dict[str, Any]:
        """GeoJSON of pieces of the plane: a feature for each cell that has pieces, with the ``id`` of its seed."""
        features = []
        for row, number in enumerate(self.ids.tolist()):
            polygons = [
                [ring.tolist() + ring[:1].tolist() for ring in self.rings(k)]
                for k in range(self.indptr[row], self.indptr[row + 1])
            ]
            if polygons:
                geometry = {"type": "MultiPolygon", "coordinates": polygons}
                features.append({"type": "Feature", "id": number, "properties": {"id": number}, "geometry": geometry})
        return {"type": "FeatureCollection", "features": features}

    def __iter__(self) -> Iterator[Piece]:
        return (self[k] for k in range(len(self)))

    def __repr__(self) -> str:
        what = "edges" if self.planar else "triangles"
        return f"<pyvotess.Pieces: {counted(len(self), 'piece')} of {len(self.indptr) - 1} cells, {len(self.triangles)} {what}>"

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

    def image(
        self,
        file: Union[None, str, os.PathLike[str]] = None,
        *,
        color: Union[str, npt.ArrayLike] = "volume",
        colormap: str = "tide",
        cut: str = "none",
        view: Tuple[float, float] = (36.0, 27.0),
        size: Tuple[int, int] = (800, 600),
        limits: Optional[Tuple[float, float]] = None,
        threads: int = 0,
    ) -> Image:
        """Returns a picture of the pieces that the library draws. Arguments are those of :meth:`Tessellation.image`.

        color : "volume", or (P,) values, one for each piece; NaN is gray.

        Raises ValueError for no pieces and values that do not fit; OSError when the file cannot be written.

        >>> corners = np.array([(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1)])
        >>> solid = (corners, [(0, 2, 1), (0, 1, 3), (0, 3, 2), (1, 2, 3)])
        >>> vt.tessellate(points, mesh=solid).pieces(gap=0.05).image(size=(200, 150))
        <pyvotess image of 200 x 150 pixels>
        """
        from .export.image import image_of_pieces

        values, label = (self.volumes, "area" if self.planar else "volume") if isinstance(color, str) and color == "volume" else (color, "")
        if isinstance(values, str):
            raise ValueError(f"color is {values!r}: give 'volume', or a value for each of the {len(self)} pieces")
        numbers = as_one_each(values, "color", len(self), "pieces")
        names = ("vertex_offsets", "vertices", "triangle_offsets", "triangles", "on_surface", "centroids", "sources")
        look = dict(colormap=colormap, cut=cut, view=view, size=size, limits=limits, threads=threads)
        return image_of_pieces({name: getattr(self, name) for name in names}, numbers, label, file, self.planar, **look)

    def view(self) -> View:
        """Returns a page that shows the pieces in a browser, where the reader turns, cuts and parts them.

        See :meth:`Tessellation.view`.

        >>> corners = np.array([(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1)])
        >>> solid = (corners, [(0, 2, 1), (0, 1, 3), (0, 3, 2), (1, 2, 3)])
        >>> vt.tessellate(points, mesh=solid).pieces(gap=0.05).view().save("pieces.html")
        """
        from .export.viewer import view_of_pieces

        return view_of_pieces(self)

    def mesh_quality(self, min_edge: float = 0.0) -> MeshQuality:
        """Returns how well the pieces suit solvers as a mesh with shared faces, as :meth:`save` writes it to .foam.

        Raises ValueError for pieces of the plane, of some cells alone, and with a gap.

        >>> corners = np.array([(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1)])
        >>> solid = (corners, [(0, 2, 1), (0, 1, 3), (0, 3, 2), (1, 2, 3)])
        >>> vt.tessellate(points, mesh=solid).pieces().mesh_quality().wrong_cells
        0
        """
        from .export.mesh_file import quality_of_pieces

        self._check_joined("mesh_quality()")
        return quality_of_pieces(self._arrays(self.ids), as_number(min_edge, "min_edge"))

    def _arrays(self, ids: npt.NDArray[Any]) -> Dict[str, npt.NDArray[Any]]:
        """Returns the arrays that files are made of."""
        names = ("indptr", "vertex_offsets", "vertices", "triangle_offsets", "triangles", "on_surface", "centroids", "sources")
        return {"ids": ids.astype(np.int64), **{name: getattr(self, name) for name in names}}

    def _check_joined(self, caller: str) -> None:
        if self.planar:
            raise ValueError(f"{caller} needs pieces in three dimensions: these are polygons")
        if not np.array_equal(self.ids, np.arange(len(self.ids))):
            raise ValueError(f"{caller} needs the pieces of all cells: leave out only=")

    def save(
        self, path: Union[str, os.PathLike[str]], ids: Optional[npt.ArrayLike] = None, min_edge: float = 0.0
    ) -> None:
        """Writes the pieces to a file, whole or not at all.

        Each piece is an object. Its name is the index of its seed, as in "17"; or "17.0", "17.1" if a cell has several.
        Materials are ``surface`` and ``inside``.

        - ``.glb``: y is up, as glTF demands. The origin of each object is at its centroid. At most 4 GiB.
        - ``.obj``: with coordinates as given, and the names of the materials.
        - ``.3mf``: for printers, in millimeters.
        - ``.stl``: all pieces in one, without names and materials.
        - ``.foam``, ``.msh``, ``.cgns``: one mesh of all pieces, with shared faces, for OpenFOAM, Gmsh and CGNS, as
          :meth:`Tessellation.save` writes it of whole cells. Corners at one place become one. Cell k of OpenFOAM and CGNS is
          piece k; a physical volume of Gmsh is the row of a seed. The surface is the patch ``surface``, or ``surface1`` and on where it is in several parts.
          There must be no gap.
        - ``.html``: the page of :meth:`view`.
        - ``.geojson``: pieces of the plane alone, a feature for each cell.

        ids : (N,) whole numbers to name cells by; not for .foam, .msh and .cgns.
        min_edge : in .foam, .msh and .cgns, as for :meth:`Tessellation.save`. Vertices stay on their triangles of the mesh.

        Raises ValueError for an unknown extension, a wrong number of ids, a file above 4 GiB, and for .foam, .msh and .cgns
        when pieces do not share their faces; OSError when the file cannot be written.

        >>> corners = np.array([(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1)])
        >>> solid = (corners, [(0, 2, 1), (0, 1, 3), (0, 3, 2), (1, 2, 3)])
        >>> vt.tessellate(points, mesh=solid).pieces(gap=0.01).save("pieces.glb")
        """
        from .export.mesh_file import short_edges_stay, write_pieces
        from .export.whole_file import whole_file

        file = as_path(path, "path")
        extension = os.path.splitext(file)[1].lower()
        known = _FLAT_FORMATS if self.planar else _FORMATS
        if extension not in known:
            where = " for pieces of the plane" if self.planar else ""
            raise ValueError(f"path is {file!r}: known{where} are {' '.join(known)}")
        numbers = as_array(self.ids if ids is None else ids, "ids")
        if numbers.shape != self.ids.shape or numbers.dtype.kind not in "iu":
            raise ValueError(
                f"ids have shape {numbers.shape} and type {numbers.dtype}: give a whole number for each of the "
                f"{len(self.ids)} cells"
            )
        joined = extension in _JOINED
        length = as_number(min_edge, "min_edge")
        if joined:
            self._check_joined(f"a {extension} file")
        elif length:
            raise ValueError(f"{extension} keeps all edges, and min_edge is given: .foam, .msh and .cgns collapse short ones")
        if joined and ids is not None:
            raise ValueError(f"a {extension} file numbers cells by their rows: leave out ids")
        if extension == ".html":
            replace(self, ids=numbers.astype(np.int64)).view().save(file)
            return
        with whole_file(file) as temporary:
            folder = os.path.dirname(os.path.realpath(file))
            kept = write_pieces(temporary, extension, self._arrays(numbers), length, folder)
        if kept:
            warnings.warn(short_edges_stay(kept, length), stacklevel=2)


def make_pieces(
    t: SeedCells, result: Handle, gap: float, threads: int, progress: Union[None, bool, Progress]
) -> Pieces:
    handle = Handle("pieces")
    distance, count = as_number(gap, "gap"), as_count(threads, "threads", 32)
    with showing(progress) as show, Callbacks() as callbacks:
        status = lib.votess_pieces_new(result, distance, count, callbacks.progress(show), None, handle)
    raise_on_failure(status)

    return Pieces(
        **handle.arrays("indptr", "vertex_offsets", "vertices", "triangle_offsets", "triangles"),
        **handle.arrays("sources", "volumes", "centroids"),
        on_surface=handle.array("on_surface").view(np.bool_),
        ids=np.arange(len(t)) if t.ids is None else np.asarray(t.ids, np.int64),
    )
