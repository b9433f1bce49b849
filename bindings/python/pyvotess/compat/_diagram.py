"""Voronoi diagrams in the terms of Qhull: numbered ridges, and -1 for vertices at infinity."""

from __future__ import annotations

from functools import cached_property
from typing import TYPE_CHECKING, Any, Dict, Tuple

import numpy as np

from ..export.geometry import ranges
from ..tessellator import tessellate
from ._points import qhull_error

if TYPE_CHECKING:
    from .._types import BoolArray, Float64Array, Int64Array


class Diagram:
    """The Voronoi diagram of N points in a box, "none" for all of space. Vertices on the box count as infinity."""

    def __init__(self, points: Float64Array, box: Any, options: Dict[str, Any]) -> None:
        t = self.t = tessellate(points, box=box, want="faces", **options)
        is_wall = np.flatnonzero(t.neighbors.indices < 0)
        begin = t.faces.indptr[is_wall]
        is_inner = np.ones(len(t.vertices) + 1, dtype=bool)
        is_inner[t.faces.indices[ranges(begin, t.faces.indptr[is_wall + 1] - begin)]] = False
        is_inner[-1] = False
        #: The new number of each vertex, -1 on the box. The last one is that of -1.
        self._number: Int64Array = np.where(is_inner, np.cumsum(is_inner) - 1, -1)
        self.vertices: Float64Array = t.vertices[is_inner[:-1]]  #: (V, dimensions)

        self._seed: Int64Array = np.repeat(np.arange(len(t)), np.diff(t.neighbors.indptr))
        self._entry: Int64Array = np.flatnonzero(t.neighbors.indices > self._seed)  #: of each ridge
        #: (R, 2), ascending in each row
        self.ridge_seeds: Int64Array = np.column_stack((self._seed[self._entry], t.neighbors.indices[self._entry]))

    @property
    def duplicate_of(self) -> Int64Array:
        """(N,) the earlier point that a point equals, else -1."""
        duplicate_of = self.t.duplicate_of
        return np.full(len(self.t), -1) if duplicate_of is None else duplicate_of.astype(np.int64)

    @cached_property
    def ridges(self) -> Tuple[Int64Array, Int64Array]:
        """(indptr, corners), counterclockwise seen from the second seed or around the first one; -1 at infinity."""
        begin = self.t.faces.indptr[self._entry]
        size = self.t.faces.indptr[self._entry + 1] - begin
        return np.concatenate(([0], np.cumsum(size))), self._number[self.t.faces.indices[ranges(begin, size)]]

    @property
    def cells(self) -> Tuple[Int64Array, Int64Array]:
        """(indptr, corners) of each cell: -1 on the box, and nothing at infinity. In the plane counterclockwise."""
        return self.t.cell_vertices.indptr, self._number[self.t.cell_vertices.indices]

    @property
    def is_open(self) -> BoolArray:
        """(N,) whether each cell reaches infinity or the box."""
        indptr, corners = self.cells
        is_open = np.zeros(len(self.t), dtype=bool)
        is_open[self._seed[self.t.neighbors.indices < 0]] = True
        is_open[np.repeat(np.arange(len(self.t)), np.diff(indptr))[corners < 0]] = True
        return is_open


def diagram_of_space(points: Float64Array, options: Dict[str, Any]) -> Diagram:
    """Returns the diagram of all of space or of the plane. Raises QhullError if it has no vertex."""
    diagram = Diagram(points, "none", options)
    if len(diagram.vertices) == 0:
        few, flat = ("four", "plane") if points.shape[1] == 3 else ("three", "line")
        raise qhull_error()(f"the points are fewer than {few}, or all in one {flat}")
    return diagram
