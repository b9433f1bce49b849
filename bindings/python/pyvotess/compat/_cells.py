"""Cells as dicts in the format of pyvoro, filled at their first use."""

from __future__ import annotations

import threading
from typing import TYPE_CHECKING, Any, Callable, Dict, List, Optional, Tuple

import numpy as np

from ._pause import garbage_collector_paused

if TYPE_CHECKING:
    from .._types import Float64Array, Int64Array
    from ..tessellation import Tessellation

#: Number of cells that are filled together: enough to spread the cost of NumPy's calls, few enough to be quick. It
#: doubles for consecutive blocks up to the second number, because the garbage collector scans all cells in between.
_BLOCK, _LARGEST_BLOCK = 128, 4096

Face = Dict[str, Any]


class Cell(Dict[str, Any]):
    """A filled cell. It pickles and copies as a dict."""

    __slots__ = ("_blocks", "_row")

    _blocks: CellBlocks
    _row: int

    def __reduce_ex__(self, protocol: Any) -> Any:
        return dict, (dict(self.items()),)


class LazyCell(Cell):
    """A cell with its first keys only. Any other use fills it and makes it a :class:`Cell`."""

    __slots__ = ()

    def __missing__(self, key: str) -> Any:
        self._blocks.fill(self._row)
        return self[key]  # raises KeyError for an unknown key


def _after_filling(name: str) -> Callable[..., Any]:
    def method(self: LazyCell, *arguments: Any, **keywords: Any) -> Any:
        if type(self) is LazyCell:
            self._blocks.fill(self._row)
        return getattr(dict, name)(self, *arguments, **keywords)

    method.__name__ = name
    return method


for _name in (
    "__contains__", "__delitem__", "__eq__", "__ge__", "__gt__", "__ior__", "__iter__", "__le__", "__len__", "__lt__",
    "__ne__", "__or__", "__repr__", "__reversed__", "__ror__", "__setitem__", "clear", "copy", "get", "items", "keys",
    "pop", "popitem", "setdefault", "update", "values",
):  # fmt: skip
    setattr(LazyCell, _name, _after_filling(_name))


class CellBlocks:
    """Fills the cells of a tessellation with faces, block by block.

    A filled cell has "vertices", "adjacency" and "faces". ``offsets``: (N, 3) added to the vertices of each cell.
    ``vector``: makes a vertex from a list of three floats.
    """

    def __init__(
        self,
        t: Tessellation,
        offsets: Optional[Float64Array],
        vector: Optional[Callable[[List[float]], Any]],
    ) -> None:
        self._t = t
        self._offsets = offsets
        self._vector = vector
        self._cells: List[Optional[LazyCell]] = []
        self._lock = threading.Lock()
        self._size, self._next = _BLOCK, -1

    def add(self, cell: LazyCell) -> LazyCell:
        """Registers the cell of the next seed, with its first keys, and returns it."""
        cell._blocks = self
        cell._row = len(self._cells)
        self._cells.append(cell)
        return cell

    def fill(self, row: int) -> None:
        """Fills the cell of a row and some of the following."""
        with self._lock, garbage_collector_paused():
            if self._cells[row] is None:
                return  # another thread filled it
            follows = row == self._next
            self._size = min(2 * self._size, _LARGEST_BLOCK) if follows else _BLOCK
            first = row if follows else row - row % _BLOCK
            last = self._next = min(first + self._size, len(self._cells))
            parts = self._parts(first, last)
            for index in range(first, last):
                cell = self._cells[index]
                if cell is not None:
                    dict.update(cell, {name: values[index - first] for name, values in parts})
                    setattr(cell, "__class__", Cell)
                self._cells[index] = None

    def _parts(self, first: int, last: int) -> List[Tuple[str, List[Any]]]:
        """Returns (name, one value for each cell) of the three keys."""
        rows, faces, cell_vertices = self._t.neighbors, self._t.faces, self._t.cell_vertices
        entries = rows.indptr[first : last + 1]
        polygons = faces.indptr[entries[0] : entries[-1] + 1]
        bounds = cell_vertices.indptr[first : last + 1]
        corners = faces.indices[polygons[0] : polygons[-1]].astype(np.int64)
        ids = cell_vertices.indices[bounds[0] : bounds[-1]].astype(np.int64)
        cells = np.arange(last - first, dtype=np.int64)
        cell_of_vertex = np.repeat(cells, np.diff(bounds))
        cell_of_corner = np.repeat(cells, np.diff(polygons[entries - entries[0]]))
        # The index of each corner among the vertices of the block, and its number in the cell.
        count = len(self._t.vertices)
        place = np.searchsorted(cell_of_vertex * count + ids, cell_of_corner * count + corners)
        number = place - (bounds[cell_of_corner] - bounds[0])

        places = self._t.vertices[ids]
        if self._offsets is not None:
            places += self._offsets[first:last][cell_of_vertex]
        vertices: List[Any] = places.tolist()
        if self._vector is not None:
            vertices = [self._vector(xyz) for xyz in vertices]
        begins = polygons - polygons[0]
        around = _adjacency(place, number, begins, len(ids))
        faces_of_block = self._faces(entries, begins, number)
        by_cell = _pairs((bounds - bounds[0]).tolist())
        return [
            ("vertices", [vertices[a:b] for a, b in by_cell]),
            ("adjacency", [around[a:b] for a, b in by_cell]),
            ("faces", [faces_of_block[a:b] for a, b in _pairs((entries - entries[0]).tolist())]),
        ]

    def _faces(self, entries: Int64Array, begins: Int64Array, number: Int64Array) -> List[Face]:
        # Seen from outside, faces are clockwise in Voro++ and counterclockwise in votess.
        mirrored = np.repeat(begins[:-1] + begins[1:] - 1, np.diff(begins)) - np.arange(len(number))
        corners = number[mirrored].tolist()
        adjacent = self._t.neighbors.indices[entries[0] : entries[-1]].tolist()
        return [
            {"adjacent_cell": j, "vertices": corners[a:b]} for j, (a, b) in zip(adjacent, _pairs(begins.tolist()))
        ]


def _pairs(bounds: List[int]) -> List[Tuple[int, int]]:
    return list(zip(bounds[:-1], bounds[1:]))


def _adjacency(place: Int64Array, number: Int64Array, begins: Int64Array, count: int) -> List[List[int]]:
    """Returns for each of ``count`` vertices the numbers of the vertices joined by an edge, in order around it.

    In a polygon ..., w, u, v, ... w follows v around u.
    """
    size = np.diff(begins)
    step = np.arange(len(number))
    first, last = np.repeat(begins[:-1], size), np.repeat(begins[1:], size) - 1
    after = number[np.where(step == last, first, step + 1)]
    before = number[np.where(step == first, last, step - 1)]
    order = np.argsort(place, kind="stable")
    after, before = after[order], before[order]
    valence = np.bincount(place, minlength=count)
    ends = np.cumsum(valence)
    starts = ends - valence
    simple = starts[valence == 3]
    triples = np.empty((len(simple), 3), dtype=np.int64)
    triples[:, 0], triples[:, 1] = after[simple], before[simple]
    triples[:, 2] = after[simple] + after[simple + 1] + after[simple + 2] - triples[:, 0] - triples[:, 1]
    if len(simple) == count:
        return triples.tolist()
    around: List[List[int]] = [[] for _ in range(count)]
    for vertex, triple in zip(np.flatnonzero(valence == 3).tolist(), triples.tolist()):
        around[vertex] = triple
    for vertex in np.flatnonzero(valence != 3).tolist():
        begin, end = int(starts[vertex]), int(ends[vertex])
        follows = dict(zip(after[begin:end].tolist(), before[begin:end].tolist()))
        at = int(after[begin])
        for _ in range(end - begin):
            around[vertex].append(at)
            at = follows[at]
    return around
