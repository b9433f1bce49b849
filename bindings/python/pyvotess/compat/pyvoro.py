"""pyvoro's compute_voronoi for three dimensions: ``from pyvotess.compat import pyvoro``.

What differs from pyvoro 1.3:

- Faces and vertices come in the order of votess. Faces that are smaller than Voro++'s tolerance are there, and
  vertices that are equal in exact arithmetic are one.
- ``dispersion`` is not used.
- ``radii`` of another length than the points are an error; pyvoro leaves them out silently. No points give no cells.
- Equal points are a ValueError; so is a point with NaN.
- A cell is a dict of a subclass, which makes its vertices, adjacency and faces when they are first looked at. Only code
  in C that reads a dict without calling its methods can see it before.
- compute_2d_voronoi is not there: votess has three dimensions only.
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
    """There are points without a cell: outside of the limits, or covered by heavier ones."""


def _constructor(point: Any) -> Optional[Callable[[List[float]], Any]]:
    """What makes a vector of the kind of this point out of a list; None for a list."""
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
    """The cells of ``points``, in their order, as a list of dicts.

    Parameters
    ----------
    points : N vectors of three numbers, of any class that is a sequence and is made from a list of three floats. An
        (N, 3) array is one too.
    limits : ((x0, x1), (y0, y1), (z0, z1)), the box.
    dispersion : not used.
    radii : N numbers: a power diagram with their squares as weights. Empty: a Voronoi diagram.
    periodic : whether the box repeats along x, y, z. The cell of a point lies around it, be the point outside or not.
    options : of :func:`pyvotess.tessellate`: ``threads``, ``device``, ``instructions``, ``progress``.

    Each dict has ``original``, the point as given; ``volume``; ``vertices``, vectors of the class of the points;
    ``adjacency``, for each vertex the numbers of those it has an edge to; and ``faces``, each a dict of
    ``adjacent_cell``, an index into the list or a wall from -1 to -6 (xmin, xmax, ymin, ymax, zmin, zmax), and
    ``vertices``, the numbers of its corners in order.

    Raises VoronoiPlusPlusError when a point has no cell.
    """
    del dispersion
    if len(points) == 0:
        return []
    # Points may be objects of any class: what NumPy may not know is read number by number.
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
            f"{len(missing)} of {len(points)} points have no cell, the first is points[{missing[0]}]: they lie outside "
            "of the limits, or points with larger radii cover them"
        )
    offsets = np.asarray(array, dtype=np.float64) - t.wrapped_points if any(t.periodic) else None
    blocks = CellBlocks(t, offsets, _constructor(points[0]))
    with garbage_collector_paused():
        return [
            blocks.add(LazyCell(original=point, volume=volume)) for point, volume in zip(points, t.volumes.tolist())
        ]


def compute_2d_voronoi(*arguments: Any, **keywords: Any) -> List[Dict[str, Any]]:
    """Raises NotImplementedError: votess has three dimensions only."""
    raise NotImplementedError("votess has three dimensions only: give scipy.spatial.Voronoi the points of a plane")
