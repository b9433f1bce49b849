"""pyvoro's compute_voronoi for three dimensions: ``from pyvotess.compat import pyvoro``.

Differences from pyvoro 1.3:

- Faces and vertices have the order of votess. Faces below Voro++'s tolerance are included, and vertices that are equal in
  exact arithmetic are one.
- ``dispersion`` is not used.
- ``radii`` with another length than the points are an error; pyvoro ignores them silently. No points give no cells.
- Equal points and NaN raise ValueError.
- A cell is a subclass of dict, which computes vertices, adjacency and faces at first use. Code in C that reads a dict
  without calling its methods may see it before.
- compute_2d_voronoi is missing: use :func:`pyvotess.tessellate` with points of shape (N, 2).
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Callable, Dict, List, Optional, Sequence

import numpy as np

from .._c_api import CellStatus
from .._input import as_box, as_points
from ..tessellator import tessellate
from ._cells import CellBlocks, LazyCell
from ._pause import garbage_collector_paused

if TYPE_CHECKING:
    import numpy.typing as npt

__all__ = ["VoronoiPlusPlusError", "compute_2d_voronoi", "compute_voronoi"]


class VoronoiPlusPlusError(Exception):
    """Some points have no cell: they are outside of the limits, or points with larger radii cover them."""


def _constructor(point: Any) -> Optional[Callable[[List[float]], Any]]:
    """Returns a function that converts a list to the type of this point; None for a list."""
    if isinstance(point, (np.ndarray, np.generic)):
        return np.array
    return None if type(point) is list else type(point)


def compute_voronoi(
    points: Sequence[Any],
    limits: npt.ArrayLike,
    dispersion: float,
    radii: Sequence[float] = (),
    periodic: Sequence[bool] = (False, False, False),
    **options: Any,
) -> List[Dict[str, Any]]:
    """Returns the cells of ``points``, in their order, as a list of dicts.

    Parameters
    ----------
    points : N vectors of three numbers, such as an (N, 3) array. Their class must be a sequence that a list of three
        floats can construct.
    limits : ((x0, x1), (y0, y1), (z0, z1)), the box.
    dispersion : not used.
    radii : N numbers for a power diagram with their squares as weights. Empty for a Voronoi diagram.
    periodic : whether the box is periodic along x, y, z. The cell of a point surrounds it, also outside of the box.
    options : of :func:`pyvotess.tessellate`: ``threads``, ``device``, ``instructions``, ``progress``.

    Each dict has ``original``, the point as given; ``volume``; ``vertices``, vectors of the class of the points;
    ``adjacency``, for each vertex the numbers of the vertices joined by an edge; and ``faces``, each a dict of
    ``adjacent_cell``, an index into the list or a wall from -1 to -6 (xmin, xmax, ymin, ymax, zmin, zmax), and
    ``vertices``, the numbers of its corners in order.

    Raises VoronoiPlusPlusError for a point without a cell, ValueError for bad input.
    """
    del dispersion
    if len(points) == 0:
        return []
    # Points may be objects of any class. Those that NumPy may not know are read number by number.
    known = isinstance(points, np.ndarray) or isinstance(points[0], (list, tuple))
    array = as_points(points if known else [[float(point[k]) for k in range(3)] for point in points])
    box = as_box(np.asarray(limits, dtype=np.float64).T)
    t = tessellate(
        array,
        box=box,
        periodic=tuple(bool(axis) for axis in periodic),
        radii=np.asarray(radii, dtype=np.float64) if len(radii) else None,
        want=("volumes", "faces"),
        duplicates="error",
        outside="drop",
        **options,
    )
    if t.stats.empty_cells:
        missing = np.flatnonzero(t.status != CellStatus.CERTIFIED)
        raise VoronoiPlusPlusError(
            f"{len(missing)} of {len(points)} points have no cell, the first is points[{missing[0]}]: they are outside of "
            "the limits, or points with larger radii cover them"
        )
    offsets = np.asarray(array, dtype=np.float64) - t.wrapped_points if any(t.periodic) else None
    blocks = CellBlocks(t, offsets, _constructor(points[0]))
    with garbage_collector_paused():
        return [
            blocks.add(LazyCell(original=point, volume=volume)) for point, volume in zip(points, t.volumes.tolist())
        ]


def compute_2d_voronoi(*arguments: Any, **keywords: Any) -> List[Dict[str, Any]]:
    """Raises NotImplementedError."""
    raise NotImplementedError("compute_2d_voronoi: use pyvotess.tessellate with points of shape (N, 2)")
