"""Masses of cells under a density on a grid, see :meth:`pyvotess.Tessellation.masses`."""

from __future__ import annotations

import ctypes
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from ._arguments import as_count, counted
from ._call import Handle
from ._input import as_density, as_float64_or_float32
from ._library import lib

if TYPE_CHECKING:
    import numpy.typing as npt

    Float64Array = npt.NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Masses:
    """A density integrated over the cells and their faces."""

    masses: Float64Array  #: (N,) 0 without a cell
    centroids: Float64Array  #: (N, 3), in the plane (N, 2): centers of mass; NaN without mass
    #: (N,) the density times the squared distance from the center of mass, integrated over each cell
    second_moments: Float64Array
    #: (E,) the density integrated over the face of each entry of ``neighbors``. Between boxes of the grid the density is the
    #: mean of both sides
    face_masses: Float64Array

    def __len__(self) -> int:
        """N, the number of cells."""
        return len(self.masses)

    def __repr__(self) -> str:
        return f"<pyvotess.Masses of {counted(len(self), 'cell')}: {self.masses.sum():.6g}>"

    def cost(self, places: npt.ArrayLike) -> float:
        """Returns the density times the squared distance from places, one for each cell, integrated over the cells.

        places : (N, 3), in the plane (N, 2). In a periodic domain they lie in the cells: ``t.wrapped_points``.

        >>> t.masses(np.ones((1, 1, 1))).cost(points) == vt.transport_cost(t, np.ones((1, 1, 1)))
        True
        """
        given = as_float64_or_float32(places, "places")
        if given.shape != self.centroids.shape:
            raise ValueError(f"places have shape {given.shape}: it must be {self.centroids.shape}")
        if not np.isfinite(given).all():
            raise ValueError("places hold numbers that are not finite")
        ways = np.nan_to_num(self.centroids - given)
        return float(self.second_moments.sum() + self.masses @ (ways**2).sum(axis=1))


def masses_of(cells: Handle, dimensions: int, density: Any, threads: int = 0) -> Masses:
    """Returns the masses of cells with all their faces."""
    grid = as_density(density, dimensions)
    shape = (ctypes.c_size_t * 3)(*(*grid.shape, 1)[:3])
    handle = Handle.made("masses", lib.votess_masses_new, cells, grid, shape, as_count(threads, "threads", 32))
    return Masses(**handle.arrays("masses", "centroids", "second_moments", "face_masses"))
