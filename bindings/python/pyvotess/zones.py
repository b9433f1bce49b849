"""Zones of a watershed over the cells, see :meth:`pyvotess.Tessellation.watershed`."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Optional

import numpy as np

from ._arguments import as_number, counted
from ._call import Handle, WithHandle
from ._library import lib

if TYPE_CHECKING:
    from ._types import BoolArray, Float64Array, Int32Array


@dataclass(frozen=True, eq=False)
class Zones(WithHandle):
    """Z zones of N cells, with P pairs of adjacent zones. For ``maxima`` read "highest" for lowest, "falls" for rises."""

    labels: Int32Array  #: (N,) the zone of each cell; -1 for seeds without a cell
    cores: Int32Array  #: (Z,) seeds, ascending: the minimum of each zone
    pairs: Int32Array  #: (P, 2) adjacent zones, the lower number first; in the order of ascending saddles
    saddles: Float64Array  #: (P,) value to which a path from one zone into the other rises at least
    passes: Int32Array  #: (P, 2) seeds: the neighbors across which that path steps, the higher one first
    parents: Int32Array  #: (Z,) the zone across the saddle where each ends in the merge tree; -1 if it never ends
    persistence: Float64Array  #: (Z,) that saddle less the minimum, at least 0; infinity if the zone never ends
    #: (N,) True for a cell with a wall, and for one that reaches infinity; None unless the rows list walls
    at_walls: Optional[BoolArray]
    maxima: bool  #: whether the zones are those of maxima
    _handle: Optional[Handle] = field(repr=False, compare=False)

    def __len__(self) -> int:
        """Z, the number of zones."""
        return len(self.cores)

    def __repr__(self) -> str:
        return f"<pyvotess.Zones: {counted(len(self), 'zone')} of {counted(len(self.labels), 'cell')}>"

    def _repr_html_(self) -> str:
        """Returns a table for notebooks, and a small picture."""
        from .export.html import html_of_zones

        return html_of_zones(self)

    def merge(self, threshold: float) -> Zones:
        """Returns the zones that remain when each zone with ``persistence <= threshold`` joins its parent.

        ``threshold`` has the unit of the values. For ratios of densities, make the zones from logarithms. 0 joins zones
        that only equal values divide. Zones that remain keep core and persistence. Raises ValueError for NaN.

        >>> zones = t.watershed(t.volumes)
        >>> len(zones.merge(np.inf))
        1
        """
        level = as_number(threshold, "threshold")
        handle = Handle.made("zones", lib.votess_zones_merge, self._pointer("watershed()"), level)
        return read_zones(handle, self.at_walls is not None, self.maxima)


def read_zones(handle: Handle, lists_walls: bool, maxima: bool) -> Zones:
    return Zones(
        **handle.arrays("labels", "cores", "pairs", "saddles", "passes", "parents", "persistence"),
        at_walls=handle.array("at_walls").view(np.bool_) if lists_walls else None,
        maxima=maxima,
        _handle=handle,
    )
