"""What materials scientists derive from the rows: pairs with their vectors, and Voronoi indices."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Optional

import numpy as np

if TYPE_CHECKING:
    import numpy.typing as npt

    from .tessellation import Tessellation

    Float64Array = npt.NDArray[np.float64]
    Int32Array = npt.NDArray[np.int32]
    Int64Array = npt.NDArray[np.int64]
    Int8Array = npt.NDArray[np.int8]


@dataclass(frozen=True)
class Pairs:
    """P entries of the rows, in their order: neighbor ``j[k]`` of seed ``i[k]``."""

    i: Int64Array  #: (P,) int64
    j: Int32Array  #: (P,) int32
    shift: Optional[Int8Array]  #: (P, 3) int8, box vectors, counted from ``wrapped_points``; None unless periodic
    vector: Float64Array  #: (P, 3) float64: ``points[i] + vector`` is the image of ``points[j]`` that touches
    distance: Float64Array  #: (P,) float64, its length
    area: Optional[Float64Array]  #: (P,) float64, of the face; None unless "areas" was wanted

    def __len__(self) -> int:
        return len(self.i)

    def __repr__(self) -> str:
        return f"<pyvotess.Pairs: {len(self)} entries>"


def _edges(t: Tessellation) -> Float64Array:
    """The vectors of the box, a row each."""
    if t.cell is not None:
        return t.cell
    edges: Float64Array = np.diag(t.box[1] - t.box[0])
    return edges


def make_pairs(t: Tessellation) -> Pairs:
    rows = t.neighbors
    i = np.repeat(np.arange(len(t)), np.diff(rows.indptr))
    is_seed = rows.indices >= 0
    i, j = i[is_seed], rows.indices[is_seed]
    places = t.wrapped_points
    vector = places[j] - places[i]
    shift = None
    if t.shifts is not None:
        shift = t.shifts[is_seed]
        vector += shift @ _edges(t)
    area = t.face_areas[is_seed] if "areas" in t._wanted else None
    return Pairs(i, j, shift, vector, np.sqrt(np.einsum("pk,pk->p", vector, vector)), area)


def count_edges(t: Tessellation, edge_threshold: float) -> Int64Array:
    faces, rows = t.faces, t.neighbors
    count = np.diff(faces.indptr)
    if edge_threshold > 0:
        begin = np.repeat(faces.indptr[:-1], count)
        entry = np.arange(len(faces.indices))
        end = np.where(entry + 1 < np.repeat(faces.indptr[1:], count), entry + 1, begin)  # around the polygon
        edge = t.vertices[faces.indices[end]] - t.vertices[faces.indices]
        short = np.einsum("ek,ek->e", edge, edge) < edge_threshold * edge_threshold
        count = count - np.bincount(np.repeat(np.arange(len(count)), count)[short], minlength=len(count))
    cell = np.repeat(np.arange(len(t)), np.diff(rows.indptr))
    kept = count >= 3
    table = np.zeros((len(t), int(count.max(initial=2)) - 2), dtype=np.int64)
    np.add.at(table, (cell[kept], count[kept] - 3), 1)
    return table
