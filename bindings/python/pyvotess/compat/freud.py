"""freud.locality.Voronoi in space and in the plane: ``from pyvotess.compat.freud import Voronoi``.

It needs freud (``pip install freud-analysis``) for boxes, systems and lists of neighbors.

Differences from freud 3.4:

- Faces and vertices that Voro++'s tolerance drops are there. Vertices that are equal in exact arithmetic are one.
- Vertices in space have the order of votess. Those in the plane are counterclockwise, as in freud.
- Equal points are an error.
"""

from __future__ import annotations

from functools import cached_property
from typing import TYPE_CHECKING, Any, List, Optional

import numpy as np

from ..export.optional import imported
from ..tessellator import tessellate

if TYPE_CHECKING:
    from .._types import Float64Array
    from ..tessellation import Tessellation

__all__ = ["Voronoi"]


class Voronoi:
    """The Voronoi diagram of a periodic system, with the attributes of freud.locality.Voronoi.

    Parameters
    ----------
    options : of :func:`pyvotess.tessellate`: ``threads``, ``device``, ``instructions``, ``progress``.
    """

    def __init__(self, **options: Any) -> None:
        self._freud = imported("freud", "pyvotess.compat.freud", "freud-analysis")
        self._options = options
        self._t: Optional[Tessellation] = None
        self._box: Any = None
        self._points: Float64Array = np.empty((0, 3))

    def compute(self, system: Any) -> Voronoi:
        """Computes the diagram of a system that freud reads, such as ``(box, points)``, and returns the object.

        All sides of the box are periodic, as in freud. The coordinates are those of freud, in float32.
        """
        query = self._freud.locality.NeighborQuery.from_system(system)
        size = 2 if query.box.is2D else 3
        edges = np.asarray(query.box.to_matrix(), dtype=np.float64)[:size, :size].T
        points = np.asarray(query.points, dtype=np.float64)
        self._t = tessellate(
            np.ascontiguousarray(points[:, :size]),
            cell=edges,
            origin=-edges.sum(axis=0) / 2,
            want=("volumes", "areas", "faces"),
            duplicates="error",
            **self._options,
        )
        self._box, self._points = query.box, points
        for name in ("polytopes", "nlist"):
            vars(self).pop(name, None)
        return self

    def _computed(self) -> Tessellation:
        if self._t is None:
            raise AttributeError("no system has been computed: call compute() first")
        return self._t

    @property
    def volumes(self) -> Float64Array:
        """(N,) float64, the volume of each cell, in the plane its area."""
        return self._computed().volumes

    @cached_property
    def polytopes(self) -> List[Float64Array]:
        """The vertices of each cell around its point as given, (n, 3) float64."""
        t = self._computed()
        rows = t.cell_vertices
        size = t.vertices.shape[1]
        vertices = np.zeros((len(rows.indices), 3))
        vertices[:, :size] = t.vertices[rows.indices]
        shifts = self._points[:, :size] - t.wrapped_points
        vertices[:, :size] += np.repeat(shifts, np.diff(rows.indptr), axis=0)
        return np.split(vertices, rows.indptr[1:-1])

    @cached_property
    def nlist(self) -> Any:
        """freud.locality.NeighborList, with the areas of the faces as weights, in the plane the lengths of the edges."""
        return self._computed().to_freud()

    def plot(self, ax: Any = None, color_by: Optional[str] = None, cmap: Any = None) -> Any:
        """Draws the polygons by ``freud.plot``, and returns the axes. Returns None in space."""
        self._computed()
        if not self._box.is2D:
            return None
        return imported("freud.plot", "plot()", "freud-analysis").voronoi_plot(self, self._box, ax, color_by, cmap)

    def _repr_png_(self) -> Any:
        try:
            return imported("freud.plot", "plot()", "freud-analysis")._ax_to_bytes(self.plot())
        except (AttributeError, ImportError):
            return None

    def __repr__(self) -> str:
        return f"{__name__}.{type(self).__name__}()"
