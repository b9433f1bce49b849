"""The common base of scipy's diagrams and triangulations."""

from __future__ import annotations

from functools import cached_property, lru_cache
from typing import TYPE_CHECKING, Any, Type

import numpy as np

from .._input import as_points

if TYPE_CHECKING:
    from .._types import Float64Array


class QhullError(RuntimeError):
    """The points span too little for a diagram: all are in one plane, or in the plane all are on one line."""


@lru_cache(maxsize=None)
def qhull_error() -> Type[RuntimeError]:
    """Returns the class to raise: that of SciPy if it is installed, because programs catch it, else the one above."""
    try:
        from scipy.spatial import QhullError as of_scipy
    except ImportError:
        return QhullError
    return of_scipy  # type: ignore[no-any-return]


class OfPoints:
    """Holds ``points`` (N, 3) or (N, 2) float64. Raises for arguments that scipy or votess does not support."""

    furthest_site = False

    def __init__(self, points: Any, furthest_site: bool, incremental: bool) -> None:
        if furthest_site:
            raise NotImplementedError("furthest_site: votess has no furthest-site diagram; use scipy.spatial")
        if incremental:
            self.add_points(points)
        self.points: Float64Array = np.ascontiguousarray(as_points(points, planar=True), dtype=np.float64)
        if np.isnan(self.points).any():
            raise ValueError("points cannot contain NaN")
        self.npoints, self.ndim = self.points.shape

    @cached_property
    def min_bound(self) -> Float64Array:
        """(ndim,) float64, the smallest coordinates of the points."""
        lower: Float64Array = self.points.min(axis=0)
        return lower

    @cached_property
    def max_bound(self) -> Float64Array:
        """(ndim,) float64, the largest coordinates of the points."""
        upper: Float64Array = self.points.max(axis=0)
        return upper

    def add_points(self, points: Any, restart: bool = False) -> None:
        """Raises NotImplementedError."""
        raise NotImplementedError("incremental: create a new object with all points, or use scipy.spatial")

    def close(self) -> None:
        """Does nothing, because no points can be added."""
