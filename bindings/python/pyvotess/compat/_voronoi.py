"""scipy.spatial.Voronoi for two and three dimensions."""

from __future__ import annotations

from functools import cached_property
from typing import TYPE_CHECKING, Any, Dict, List, Optional, Tuple

import numpy as np

from ._diagram import Diagram, diagram_of_space
from ._pause import garbage_collector_paused
from ._points import OfPoints

if TYPE_CHECKING:
    import numpy.typing as npt

    from .._types import BoolArray, Int32Array, Int64Array


def _rows(indptr: Int64Array, values: Int64Array, kept: BoolArray) -> List[List[int]]:
    """Returns the rows of values as lists, with the kept values only."""
    ends = np.concatenate(([0], np.cumsum(kept)))[indptr].tolist()
    flat = values[kept].tolist()
    with garbage_collector_paused():
        return [flat[a:b] for a, b in zip(ends[:-1], ends[1:])]


def _one_of_each_gap(indptr: Int64Array, corners: Int64Array) -> BoolArray:
    """Returns which corners to keep: the first of consecutive corners on the box, also if a row has no others."""
    is_inner = corners >= 0
    begin, end = indptr[:-1], indptr[1:]
    begin, end = begin[begin < end], end[begin < end]
    before = np.empty_like(is_inner)
    before[1:] = is_inner[:-1]
    before[begin] = is_inner[end - 1]
    kept: BoolArray = is_inner | before
    if len(begin):
        kept[begin] |= ~np.logical_or.reduceat(is_inner, begin)
    return kept


class Voronoi(OfPoints):
    """The Voronoi diagram of points in space or in the plane, with the attributes of scipy.spatial.Voronoi.

    Parameters
    ----------
    points : (N, 3) numbers, not all in one plane, or (N, 2), not all on one line.
    furthest_site, incremental : must be False.
    qhull_options : not used.
    box : as for :func:`pyvotess.tessellate`. Vertices beyond it become -1, and pairs of cells that meet only there are
        missing. Default: no box.
    options : of :func:`pyvotess.tessellate`: ``threads``, ``device``, ``instructions``, ``progress``.

    Attributes: ``points``, ``vertices``, ``ridge_points``, ``ridge_vertices``, ``regions``, ``point_region``,
    ``ridge_dict``, ``npoints``, ``ndim``, ``min_bound``, ``max_bound``, ``furthest_site``, as in scipy. Lists are
    computed at first use.

    Differences from scipy:

    - Five or more points on one sphere, or four on one circle, have one vertex. Qhull returns several at one place, or
      merges close ones.
    - Ridges with a single vertex, which Qhull omits in space, are included.
    - Point i has region i. There is no empty region for Qhull's point at infinity.
    - The region of a point that equals an earlier one is empty; ``point_region`` is that of the earlier one.
    """

    def __init__(
        self,
        points: npt.ArrayLike,
        furthest_site: bool = False,
        incremental: bool = False,
        qhull_options: Optional[str] = None,
        *,
        box: Optional[npt.ArrayLike] = None,
        **options: Any,
    ) -> None:
        del qhull_options
        super().__init__(points, furthest_site, incremental)
        if box is None:
            self._diagram = diagram_of_space(self.points, options)
        else:
            self._diagram = Diagram(self.points, box, options)
        self.vertices = self._diagram.vertices
        self.ridge_points: Int32Array = self._diagram.ridge_seeds.astype(np.int32)
        duplicate_of = self._diagram.duplicate_of
        self.point_region: Int64Array = np.where(duplicate_of >= 0, duplicate_of, np.arange(self.npoints))

    @cached_property
    def ridge_vertices(self) -> List[List[int]]:
        """For each row of ``ridge_points`` the vertices around the common polygon, -1 where it is open.

        In the plane the two ends of the common edge, ascending.
        """
        indptr, corners = self._diagram.ridges
        if self.ndim == 2:
            with garbage_collector_paused():
                pairs: List[List[int]] = np.sort(corners.reshape(-1, 2), axis=1).tolist()
            return pairs
        return _rows(indptr, corners, _one_of_each_gap(indptr, corners))

    @cached_property
    def regions(self) -> List[List[int]]:
        """The vertices of each cell, after a -1 where the cell is open. They ascend.

        In the plane they are counterclockwise, with a -1 for each part of the cell on the box or at infinity.
        """
        indptr, corners = self._diagram.cells
        kept = _one_of_each_gap(indptr, corners) if self.ndim == 2 else corners >= 0
        regions = _rows(indptr, corners, kept)
        for row in np.flatnonzero(self._diagram.is_open).tolist():
            region = regions[row]
            gap = region.index(-1) if -1 in region else len(region)
            regions[row] = [-1, *region[gap + 1 :], *region[:gap]]
        return regions

    @cached_property
    def ridge_dict(self) -> Dict[Tuple[int, int], List[int]]:
        """The vertices of each ridge, by its row of ``ridge_points``."""
        with garbage_collector_paused():
            return dict(zip(map(tuple, self.ridge_points.tolist()), self.ridge_vertices))
