"""Pairs of neighbors with their vectors."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Optional

import numpy as np

if TYPE_CHECKING:
    from ._state import SeedCells
    from ._types import Float64Array, Int8Array, Int32Array, Int64Array


@dataclass(frozen=True, eq=False)
class Pairs:
    """P entries of the rows, in order: ``j[k]`` is a neighbor of seed ``i[k]``."""

    i: Int64Array  #: (P,) int64
    j: Int32Array  #: (P,) int32
    shift: Optional[Int8Array]  #: (P, 3) int8 numbers of box vectors, from ``wrapped_points``; None unless periodic
    vector: Float64Array  #: (P, 3) float64: ``points[i] + vector`` is the touching image of ``points[j]``
    distance: Float64Array  #: (P,) float64 length of ``vector``
    area: Optional[Float64Array]  #: (P,) float64 area of the face; None without "areas" in want

    def __len__(self) -> int:
        return len(self.i)

    def __repr__(self) -> str:
        return f"<pyvotess.Pairs: {len(self)} entries>"


def edges_of(t: SeedCells) -> Float64Array:
    """Returns the (3, 3) edges of the domain as rows, 0 where it has no end."""
    if t.cell is not None:
        return t.cell
    sides = t.box[1] - t.box[0]
    edges: Float64Array = np.diag(np.where(np.isinf(sides), 0, sides))
    return edges


_PIECE = 1 << 17  # entries between chances for signal handlers to run


def make_pairs(t: SeedCells) -> Pairs:
    rows = t.neighbors
    i, j, shift = np.repeat(np.arange(len(t)), np.diff(rows.indptr)), rows.indices, t.shifts
    area = t.face_areas if "areas" in t.wanted else None
    is_seed = j >= 0
    if not is_seed.all():
        i, j = i[is_seed], j[is_seed]
        shift = None if shift is None else shift[is_seed]
        area = None if area is None else area[is_seed]
    places, edges = t.wrapped_points, edges_of(t)
    vector, distance = np.empty((len(i), places.shape[1])), np.empty(len(i))
    for begin in range(0, len(i), _PIECE):
        part = slice(begin, begin + _PIECE)
        v = np.take(places, j[part], axis=0) - np.take(places, i[part], axis=0)
        if shift is not None:
            v += shift[part] @ edges
        square = np.einsum("pk,pk->p", v, v)
        vector[part], distance[part] = v, np.sqrt(square)
        lost = ~((square > 1e-280) & (square < np.inf))  # squares leave the range of numbers long before lengths
        if lost.any():
            distance[part][lost] = np.hypot.reduce(v[lost], axis=1)
    return Pairs(i, j, shift, vector, distance, area)
