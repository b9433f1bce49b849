"""The arrays of results. tools/arrays.py writes this file from the table include/votess/arrays.h."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Dict, Literal, NamedTuple, Optional, Tuple

if TYPE_CHECKING:
    import numpy.typing as npt

    from ._types import Float64Array, Int8Array, Int32Array, Int64Array, UInt8Array, UInt32Array

WANT_BITS: Dict[str, int] = {
    "neighbors": 1, "volumes": 2, "centroids": 4, "counts": 8, "areas": 16, "normals": 32, "surfaces": 64,
    "radii": 128, "vertices": 256, "faces": 512,
}  # fmt: skip
WantWord = Literal[
    "neighbors", "volumes", "centroids", "counts", "areas", "normals", "surfaces", "radii", "vertices", "faces"
]  # fmt: skip
#: Names that ``want`` accepts: words, and the arrays in their groups.
WantName = Literal[
    WantWord, "cell_vertices",
    "indices", "shifts", "face_areas", "face_normals", "surface_areas", "security_radii", "face_counts",
    "edge_counts", "vertex_counts", "status", "duplicate_of", "indptr", "mesh_areas", "cell_vertex_indptr",
    "cell_vertex_indices", "face_offsets", "face_vertices", "ids"
]  # fmt: skip


class Array(NamedTuple):
    """A row of the table."""

    group: str  #: that wants it; "" for an array of every result
    per: str  #: "cell", "entry", "vertex" or "other"
    column: str  #: its name in tables of cells; "" for none
    optional: bool  #: whether it may be missing


TABLE: Dict[str, Array] = {
    "indices": Array("neighbors", "entry", "", False),
    "shifts": Array("neighbors", "entry", "", True),
    "face_areas": Array("areas", "entry", "", False),
    "face_normals": Array("normals", "entry", "", False),
    "volumes": Array("volumes", "cell", "volume", False),
    "centroids": Array("centroids", "cell", "centroid", False),
    "surface_areas": Array("surfaces", "cell", "surface_area", False),
    "security_radii": Array("radii", "cell", "security_radius", False),
    "face_counts": Array("counts", "cell", "face_count", False),
    "edge_counts": Array("counts", "cell", "edge_count", False),
    "vertex_counts": Array("counts", "cell", "vertex_count", False),
    "status": Array("", "cell", "", False),
    "duplicate_of": Array("", "cell", "", True),
    "indptr": Array("neighbors", "other", "", False),
    "mesh_areas": Array("surfaces", "cell", "mesh_area", True),
    "vertices": Array("vertices", "vertex", "", False),
    "cell_vertex_indptr": Array("vertices", "other", "", False),
    "cell_vertex_indices": Array("vertices", "other", "", False),
    "face_offsets": Array("faces", "other", "", False),
    "face_vertices": Array("faces", "other", "", False),
    "ids": Array("", "cell", "", True),
    "weights": Array("", "other", "", True),
}
#: The arrays of each word of want that are always there.
ARRAYS: Dict[str, Tuple[str, ...]] = {
    group: tuple(name for name, array in TABLE.items() if array.group == group and not array.optional) for group in WANT_BITS
}


class ArrayAttributes:
    """The arrays of a result as attributes."""

    if TYPE_CHECKING:

        def _array(self, name: str) -> npt.NDArray[Any]: ...

        def _held(self, name: str) -> Optional[npt.NDArray[Any]]: ...

    @property
    def indices(self) -> Int32Array:
        """(indptr[N],) int32: the concatenated rows: ids of neighbors, ascending, then by shift; walls come first, being
        negative.
        """
        return self._array("indices")

    @property
    def shifts(self) -> Optional[Int8Array]:
        """(indptr[N], 3) int8: numbers of box vectors that carry each neighbor to where it touches, if both seeds are
        inside the box; None except in a periodic domain.
        """
        return self._held("shifts")

    @property
    def face_areas(self) -> Float64Array:
        """(indptr[N],) float64: areas of faces, length unit squared, with walls where the rows list them. The absolute
        error is at most 1e-10 of the surface of the cell, or 1e-5 in single precision, so a tiny face may have area 0.
        """
        return self._array("face_areas")

    @property
    def face_normals(self) -> Float64Array:
        """(indptr[N], 3) float64: outward unit normals of faces."""
        return self._array("face_normals")

    @property
    def volumes(self) -> Float64Array:
        """(N,) float64: volumes, length unit cubed; 0 for a seed without a cell."""
        return self._array("volumes")

    @property
    def centroids(self) -> Float64Array:
        """(N, 3) float64: centers of mass, in the coordinates of the points; NaN for a seed without a cell."""
        return self._array("centroids")

    @property
    def surface_areas(self) -> Float64Array:
        """(N,) float64: surface areas of the cells, walls included, length unit squared."""
        return self._array("surface_areas")

    @property
    def security_radii(self) -> Float64Array:
        """(N,) float64: twice the distance from each seed to the farthest vertex of its cell, length unit."""
        return self._array("security_radii")

    @property
    def face_counts(self) -> UInt32Array:
        """(N,) uint32: numbers of faces, walls included."""
        return self._array("face_counts")

    @property
    def edge_counts(self) -> UInt32Array:
        """(N,) uint32: numbers of edges."""
        return self._array("edge_counts")

    @property
    def vertex_counts(self) -> UInt32Array:
        """(N,) uint32: numbers of vertices."""
        return self._array("vertex_counts")

    @property
    def status(self) -> UInt8Array:
        """(N,) uint8: values of :class:`CellStatus`."""
        return self._array("status")

    @property
    def duplicate_of(self) -> Optional[Int32Array]:
        """(N,) int32: the seed that keeps the cell, -1 for seeds with a cell; None except with duplicates."""
        return self._held("duplicate_of")

    @property
    def indptr(self) -> Int64Array:
        """(N + 1,) int64: row i of the neighbors begins at indices[indptr[i]]."""
        return self._array("indptr")

    @property
    def mesh_areas(self) -> Optional[Float64Array]:
        """(N,) float64: areas of the surface of the mesh in each cell, length unit squared; None except in a mesh."""
        return self._held("mesh_areas")

    @property
    def vertices(self) -> Float64Array:
        """(V, 3) float64: coordinates of the vertices. Those that are equal in exact arithmetic occur once, except for
        their periodic images.
        """
        return self._array("vertices")

    @property
    def cell_vertex_indptr(self) -> Int64Array:
        """(N + 1,) int64: the vertices of cell i begin at cell_vertex_indices[cell_vertex_indptr[i]]."""
        return self._array("cell_vertex_indptr")

    @property
    def cell_vertex_indices(self) -> Int32Array:
        """(cell_vertex_indptr[N],) int32: rows of vertices, ascending for each cell; in the plane counterclockwise.
        """
        return self._array("cell_vertex_indices")

    @property
    def face_offsets(self) -> Int64Array:
        """(indptr[N] + 1,) int64: the polygon of entry k begins at face_vertices[face_offsets[k]]."""
        return self._array("face_offsets")

    @property
    def face_vertices(self) -> Int32Array:
        """(face_offsets[indptr[N]],) int32: rows of vertices, the concatenated polygons, counterclockwise seen from
        outside the cell; -1 at infinity.
        """
        return self._array("face_vertices")

    @property
    def ids(self) -> Optional[Int32Array]:
        """(N,) int32: the seeds of the rows; None except in a subset."""
        return self._held("ids")

    @property
    def weights(self) -> Optional[Float64Array]:
        """(N,) float64: the weights of the points; None except in a power diagram."""
        return self._held("weights")


@dataclass(frozen=True, eq=False)
class RowFields:
    """The arrays that streams and ranks have, except the rows."""

    #: (entries, 3) int8: numbers of box vectors that carry each neighbor to where it touches, if both seeds are inside
    #: the box; None except in a periodic domain.
    shifts: Optional[Int8Array]
    #: (entries,) float64: areas of faces, length unit squared, with walls where the rows list them. The absolute error
    #: is at most 1e-10 of the surface of the cell, or 1e-5 in single precision, so a tiny face may have area 0.
    face_areas: Optional[Float64Array]
    #: (entries, 3) float64: outward unit normals of faces.
    face_normals: Optional[Float64Array]
    #: (N,) float64: volumes, length unit cubed; 0 for a seed without a cell.
    volumes: Optional[Float64Array]
    #: (N, 3) float64: centers of mass, in the coordinates of the points; NaN for a seed without a cell.
    centroids: Optional[Float64Array]
    #: (N,) float64: surface areas of the cells, walls included, length unit squared.
    surface_areas: Optional[Float64Array]
    #: (N,) float64: twice the distance from each seed to the farthest vertex of its cell, length unit.
    security_radii: Optional[Float64Array]
    #: (N,) uint32: numbers of faces, walls included.
    face_counts: Optional[UInt32Array]
    #: (N,) uint32: numbers of edges.
    edge_counts: Optional[UInt32Array]
    #: (N,) uint32: numbers of vertices.
    vertex_counts: Optional[UInt32Array]
    #: (N,) uint8: values of :class:`CellStatus`.
    status: UInt8Array
    #: (N,) int32: the seed that keeps the cell, -1 for seeds with a cell; None except with duplicates.
    duplicate_of: Optional[Int64Array]
