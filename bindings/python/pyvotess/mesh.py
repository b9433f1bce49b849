"""Lists of neighbors and polygons, the dual Delaunay complex, and natural-neighbor coordinates."""

from __future__ import annotations

import operator
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Iterator, List, NamedTuple, Optional, Union, overload

import numpy as np

from ._arguments import as_count, counted
from .export.optional import imported

if TYPE_CHECKING:
    from ._call import Handle
    from ._types import Float64Array, Int8Array, Int32Array, Int64Array


class Lists:
    """Rows of ids of any length. Row k is ``lists[k]``, a view of ``indices[indptr[k]:indptr[k+1]]``.

    A slice returns a list of rows. Ids of :mod:`pyvotess.mpi` and of streams are int64.
    """

    def __init__(self, indptr: Int64Array, indices: Int32Array) -> None:
        self._indptr = indptr
        self._indices = indices

    @property
    def indptr(self) -> Int64Array:
        """(rows + 1,) int64."""
        return self._indptr

    @property
    def indices(self) -> Int32Array:
        """(indptr[rows],) int32."""
        return self._indices

    def __len__(self) -> int:
        return len(self._indptr) - 1

    @overload
    def __getitem__(self, index: int) -> Int32Array: ...

    @overload
    def __getitem__(self, index: slice) -> List[Int32Array]: ...

    def __getitem__(self, index: Union[int, slice]) -> Union[Int32Array, List[Int32Array]]:
        if isinstance(index, slice):
            return [self[row] for row in range(*index.indices(len(self)))]
        number = operator.index(index)
        row = number + len(self) if number < 0 else number
        if not 0 <= row < len(self):
            raise IndexError(f"row {number} of {len(self)} rows")
        return self._indices[self._indptr[row] : self._indptr[row + 1]]

    def __iter__(self) -> Iterator[Int32Array]:
        for row in range(len(self)):
            yield self[row]

    def __repr__(self) -> str:
        return f"<pyvotess.{type(self).__name__}: {counted(len(self), 'row')}, {counted(len(self._indices), 'id')}>"


class Neighbors(Lists):
    """The neighbor lists, in compressed sparse rows without values.

    ``neighbors[i]`` is the row of seed i: ascending ids, walls (negative) first. A slice returns a list of rows.
    """

    def to_scipy(self) -> Any:
        """Returns the (N, N) adjacency matrix as a scipy.sparse.csr_array of True, without walls.

        >>> t.neighbors.to_scipy().shape
        (100, 100)
        """
        csr_array = imported("scipy.sparse", "to_scipy()", "scipy").csr_array
        is_seed = self._indices >= 0
        seeds_before = np.concatenate(([0], np.cumsum(is_seed, dtype=np.int64)))
        indices = self._indices[is_seed]
        values = np.ones(len(indices), dtype=bool)
        return csr_array((values, indices, seeds_before[self._indptr]), shape=(len(self), len(self)))


class Rows(NamedTuple):
    """Neighbor lists and status in int32, the form that differentiable renderers read."""

    adjacency: Int32Array  #: (offsets[N],) int32: ``indices``, walls (negative) included
    offsets: Int32Array  #: (N + 1,) int32: row i of the lists is ``adjacency[offsets[i]:offsets[i+1]]``
    status: Int32Array  #: (N,) int32, values of :class:`CellStatus`


class Faces(Lists):
    """Polygons as rows of ``vertices``, counterclockwise seen from outside the cell.

    Polygon k is the face for ``neighbors.indices[k]``. Those of cell i have k in ``range(neighbors.indptr[i],
    neighbors.indptr[i+1])``.
    """


@dataclass(frozen=True, eq=False)
class Delaunay:
    """The dual of the cells: tetrahedra where four cells meet, convex polytopes where more meet.

    In the plane: triangles where three cells meet, convex polygons where more meet, all of them counterclockwise. A simplex is missing if the center of its empty sphere is outside of the domain or on a wall.
    """

    #: (T, 4) seeds, the lowest first, positive: det(b-a, c-a, d-a) > 0. In the plane (T, 3), the same as ``triangles``
    tetrahedra: Int32Array
    #: (T,) indices of vertices: ``t.vertices[centers[k]]`` is the center of the empty sphere
    centers: Int32Array
    polytopes: Lists  #: P ascending rows of five or more seeds on one empty sphere; in the plane four or more, in turn
    polytope_centers: Int32Array  #: (P,) indices of vertices, as ``centers``
    shifts: Optional[Int8Array]  #: (T, 4, 3) numbers of box vectors from each seed to its image; None unless periodic
    polytope_shifts: Optional[Int8Array]  #: (polytopes.indptr[P], 3) the same

    @property
    def triangles(self) -> Int32Array:
        """(T, 3) seeds of the triangles of the plane, counterclockwise, the lowest first."""
        if self.tetrahedra.shape[1] != 3:
            raise AttributeError("triangles are those of the plane: in space use tetrahedra")
        return self.tetrahedra

    def __repr__(self) -> str:
        simplices, unions = ("triangles", "polygons") if self.tetrahedra.shape[1] == 3 else ("tetrahedra", "polytopes")
        return f"<pyvotess.Delaunay: {len(self.tetrahedra)} {simplices}, {len(self.polytopes)} {unions}>"


@dataclass(frozen=True, eq=False)
class NaturalCoordinates:
    """Natural-neighbor coordinates of Q queries: one weight for each entry of ``neighbors``."""

    neighbors: Neighbors  #: Q rows of seeds, ascending
    weights: Float64Array  #: (neighbors.indptr[Q],) positive; each row sums to 1
    #: (neighbors.indptr[Q], 3) of each weight, (neighbors.indptr[Q], 2) in two dimensions, per length unit; None unless
    #: requested
    gradients: Optional[Float64Array]

    def to_scipy(self, seeds: int) -> Any:
        """Returns the (Q, seeds) scipy.sparse.csr_array of the weights. Its product with values interpolates them.

        >>> d.natural_neighbors(points[:5] * 0.9 + 0.05).to_scipy(100).shape
        (5, 100)
        """
        rows, columns = self.neighbors, as_count(seeds, "seeds", 31)
        least = int(rows.indices.max(initial=-1)) + 1
        if columns < least:
            raise ValueError(f"seeds is {columns}, but the rows name seed {least - 1}: give the number of seeds")
        csr_array = imported("scipy.sparse", "to_scipy()", "scipy").csr_array
        return csr_array((self.weights, rows.indices, rows.indptr), shape=(len(rows), columns))

    def __repr__(self) -> str:
        return f"<pyvotess.NaturalCoordinates of {len(self.neighbors)} queries>"


def count_edges(rows: Lists, faces: Faces, vertices: Float64Array, edge_threshold: float) -> Int64Array:
    """See :meth:`Tessellation.voronoi_indices`."""
    count = np.diff(faces.indptr)
    if edge_threshold > 0:
        begin = np.repeat(faces.indptr[:-1], count)
        entry = np.arange(len(faces.indices))
        end = np.where(entry + 1 < np.repeat(faces.indptr[1:], count), entry + 1, begin)  # around the polygon
        edge = vertices[faces.indices[end]] - vertices[faces.indices]
        short = np.einsum("ek,ek->e", edge, edge) < edge_threshold * edge_threshold
        count = count - np.bincount(np.repeat(np.arange(len(count)), count)[short], minlength=len(count))
    cell = np.repeat(np.arange(len(rows)), np.diff(rows.indptr))
    kept = count >= 3
    table = np.zeros((len(rows), int(count.max(initial=2)) - 2), dtype=np.int64)
    np.add.at(table, (cell[kept], count[kept] - 3), 1)
    return table


def make_delaunay(handle: Handle, dimensions: int, periodic: bool) -> Delaunay:
    read = handle.array
    return Delaunay(
        tetrahedra=read("tetrahedra"),
        centers=read("tetrahedra_centers"),
        polytopes=Lists(read("polytope_indptr"), read("polytope_indices")),
        polytope_centers=read("polytope_centers"),
        shifts=read("tetrahedra_shifts").reshape(-1, dimensions + 1, dimensions) if periodic else None,
        polytope_shifts=read("polytope_shifts") if periodic else None,
    )
