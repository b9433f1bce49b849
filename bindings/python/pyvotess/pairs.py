"""Pairs of neighbors with their vectors."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Optional

import numpy as np

if TYPE_CHECKING:
    from ._state import SeedCells
    from ._types import Float64Array, Int8Array, Int32Array, Int64Array


@dataclass(frozen=True)
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


def make_pairs(t: SeedCells) -> Pairs:
    rows = t.neighbors
    i = np.repeat(np.arange(len(t)), np.diff(rows.indptr))
    is_seed = rows.indices >= 0
    i, j = i[is_seed], rows.indices[is_seed]
    places = t.wrapped_points
    vector = places[j] - places[i]
    shift = None
    if t.shifts is not None:
        shift = t.shifts[is_seed]
        vector += shift @ edges_of(t)
    area = t.face_areas[is_seed] if "areas" in t.wanted else None
    return Pairs(i, j, shift, vector, np.sqrt(np.einsum("pk,pk->p", vector, vector)), area)
