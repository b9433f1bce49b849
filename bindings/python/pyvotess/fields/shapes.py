"""Shapes of cells: sphericity, and the ellipsoid with the same second moments."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Dict, Optional

import numpy as np

from .._arguments import counted
from .simplices import simplices

if TYPE_CHECKING:
    from .._state import SeedCells
    from .._types import Float64Array


@dataclass(frozen=True, eq=False)
class Shapes:
    """The shapes of N cells in d dimensions. Rows of seeds without a cell are nan."""

    #: (N,) surface of the ball of the same volume, divided by that of the cell: 1 for a ball. In the plane perimeters
    sphericity: Float64Array
    aspect_ratio: Float64Array  #: (N,) the longest semi-axis divided by the shortest
    semi_axes: Float64Array  #: (N, d) of the ellipsoid, in the plane of the ellipse, with these moments; the longest first
    directions: Float64Array  #: (N, d, d) rows are unit vectors along the axes
    moments: Float64Array  #: (N, d, d) means of (x - c)(x - c)^T over the cell, c its centroid

    def __len__(self) -> int:
        """N, the number of rows."""
        return len(self.sphericity)

    def __repr__(self) -> str:
        return f"<pyvotess.Shapes of {counted(len(self), 'cell')}>"

    @property
    def columns(self) -> Dict[str, Any]:
        """The arrays by name, (N,) or (N, k), for ``t.save(file, columns=shapes.columns)``."""
        return {name: array if array.ndim < 3 else array.reshape(len(self), -1) for name, array in self.__dict__.items()}


def make_shapes(t: SeedCells, open: Optional[str]) -> Shapes:
    places = t.wrapped_points if t.ids is None else np.asarray(t.points, np.float64)[t.ids]
    count, d = len(t), places.shape[1]
    ends = t.box if np.isfinite(t.box).all() else places
    extent = np.ptp(ends, axis=0).max() if len(ends) else 0.0
    unit = 2.0 ** np.frexp(extent)[1]  # so that products stay in range
    size, surface = np.zeros(count), np.zeros(count)
    first, second = np.zeros((d, count)), np.zeros((d, d, count))
    # Integrals over a simplex with corners 0 and x_k, of sum s: its size times s / (d + 1), and times
    # (sum of x_k x_k^T + s s^T) / ((d + 1) (d + 2)).
    for cell, corners, times in simplices(t, places, "shapes()", may_skip=True, open=open):
        if len(cell) == 0:
            continue
        begin, end = cell[0], cell[-1] + 1
        part, row = slice(begin, end), cell - begin

        def add(to: Any, values: Any) -> None:
            to[part] += np.bincount(row, values, minlength=end - begin)

        corners = corners / unit
        volume = times / unit**d / (6 if d == 3 else 2)
        total = corners.sum(axis=1)
        add(size, volume)
        edges = corners[:, 1:] - corners[:, :1]
        add(surface, np.linalg.norm(np.cross(edges[:, 0].T, edges[:, 1].T), axis=1) / 2 if d == 3
            else np.linalg.norm(edges[:, 0], axis=0))  # fmt: skip
        for i in range(d):
            add(first[i], volume * total[i] / (d + 1))
            for j in range(i + 1):
                product = np.einsum("km,km->m", corners[i], corners[j]) + total[i] * total[j]
                add(second[i, j], volume * product / ((d + 1) * (d + 2)))
    size = np.where(size > 0, size, np.nan)
    with np.errstate(invalid="ignore", divide="ignore"):
        center = first / size
        moments = np.empty((count, d, d))
        for i in range(d):
            for j in range(i + 1):
                moments[:, i, j] = moments[:, j, i] = second[i, j] / size - center[i] * center[j]
        ball = (36 * np.pi * size**2) ** (1 / 3) if d == 3 else 2 * np.sqrt(np.pi * size)
        sphericity = ball / surface
    semi_axes, directions = np.full((count, d), np.nan), np.full((count, d, d), np.nan)
    held = ~np.isnan(size)
    values, vectors = np.linalg.eigh(moments[held])
    semi_axes[held] = unit * np.sqrt((d + 2) * np.maximum(values[:, ::-1], 0))
    directions[held] = vectors.transpose(0, 2, 1)[:, ::-1]
    with np.errstate(invalid="ignore", divide="ignore"):
        aspect_ratio = semi_axes[:, 0] / semi_axes[:, -1]
    return Shapes(sphericity, aspect_ratio, semi_axes, directions, unit**2 * moments)
