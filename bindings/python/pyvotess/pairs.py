"""Pairs of neighbors with their vectors, and derivatives of volumes and areas."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Optional, Tuple

import numpy as np

if TYPE_CHECKING:
    import numpy.typing as npt

    from ._state import SeedCells

    Float64Array = npt.NDArray[np.float64]
    Int32Array = npt.NDArray[np.int32]
    Int64Array = npt.NDArray[np.int64]
    Int8Array = npt.NDArray[np.int8]


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
    """Returns the (3, 3) edges of the domain as rows."""
    if t.cell is not None:
        return t.cell
    edges: Float64Array = np.diag(t.box[1] - t.box[0])
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


@dataclass(frozen=True)
class _Polygons:
    """The polygons of F entries of the rows, and their E edges in the same order, counterclockwise."""

    face: Int64Array  # (E,) the polygon of each edge
    begin: Float64Array  # (E, 3), relative to the seed of the cell
    end: Float64Array
    ends: Tuple[Int32Array, Int32Array]  # two (E,) arrays of vertex indices
    area: Float64Array  # (F, 3) normal times area
    centroid: Float64Array  # (F, 3) relative to the seed


def _polygons(t: SeedCells, place: Float64Array) -> _Polygons:
    indptr, corners = t.faces.indptr, t.faces.indices
    count = np.diff(indptr)
    face = np.repeat(np.arange(len(count)), count)
    first = np.repeat(indptr[:-1], count)
    entry = np.arange(len(corners))
    after = np.where(entry + 1 < np.repeat(indptr[1:], count), entry + 1, first)
    position = t.vertices[corners] - place[face]
    begin, end, fixed = position, position[after], position[first]
    part = 0.5 * np.cross(begin - fixed, end - fixed)  # area vectors of triangles
    if len(count) == 0:
        return _Polygons(face, begin, end, (corners, corners), np.zeros((0, 3)), np.zeros((0, 3)))
    area = np.add.reduceat(part, indptr[:-1])
    length = np.sqrt(np.einsum("fk,fk->f", area, area))
    normal = area / np.where(length > 0, length, 1)[:, None]
    size = np.einsum("ek,ek->e", part, normal[face])
    moment = np.add.reduceat(size[:, None] * (begin + end + fixed) / 3, indptr[:-1])
    centroid = moment / np.where(length > 0, length, 1)[:, None]
    return _Polygons(face, begin, end, (corners, corners[after]), area, centroid)


def _other_faces(cell: Int64Array, polygons: _Polygons) -> Int64Array:
    """Returns (E,) the face of the same cell on the other side of each edge."""
    a, b = polygons.ends
    order = np.lexsort((np.maximum(a, b), np.minimum(a, b), cell[polygons.face]))
    other = np.empty(len(order), np.int64)
    other[order[0::2]], other[order[1::2]] = polygons.face[order[1::2]], polygons.face[order[0::2]]
    return other


def make_derivatives(t: SeedCells, of: str, by: str) -> Any:
    """See :meth:`Tessellation.derivatives`.

    Walls do not move. A point y of another face, relative to the seed i, moves along the outward normal by
    y.dx_i / d + (v - y).dx_j / d + (dw_i - dw_j) / 2 d. Here v is the vector to the neighbor j, and d its length: the
    change of |y - v|^2 - w_j - |y|^2 + w_i, divided by the length of its gradient, 2 d. The change of a volume is the
    integral of this motion over its faces. The change of an area is the integral of the motion of its edges along their
    outward normals m in the face: (motion of the other face - n.n' motion of this face) / m.n'.
    """
    if of not in ("volumes", "areas"):
        raise ValueError(f"derivatives of {of!r} are not known: give 'volumes' or 'areas'")
    if by not in ("points", "weights"):
        raise ValueError(f"derivatives by {by!r} are not known: give 'points' or 'weights'")
    t._require_space("derivatives()")
    t._require_end("derivatives()")
    if t.least_face > 0:
        raise ValueError("derivatives need whole cells: leave out min_face and min_area")
    from scipy.sparse import coo_matrix

    rows, places = t.neighbors, t.wrapped_points
    i = np.repeat(np.arange(len(t)), np.diff(rows.indptr))
    j = rows.indices
    is_seed = j >= 0
    vector = places[np.where(is_seed, j, i)] - places[i]  # 0 for a wall
    if t.shifts is not None:
        vector += np.where(is_seed[:, None], t.shifts @ edges_of(t), 0)
    distance = np.sqrt(np.einsum("fk,fk->f", vector, vector))
    per_distance = np.divide(1, distance, out=np.zeros(len(i)), where=is_seed)
    if of == "volumes" and by == "weights" and "areas" in t.wanted:
        value = 0.5 * t.face_areas[is_seed] * per_distance[is_seed]
        cell, neighbor = i[is_seed], j[is_seed]
        entry = (np.concatenate((value, -value)), (np.tile(cell, 2), np.concatenate((cell, neighbor))))
        return coo_matrix(entry, shape=(len(t), len(t))).tocsr()
    polygons = _polygons(t, places[i])
    size = np.sqrt(np.einsum("fk,fk->f", polygons.area, polygons.area))

    entries = []  # row, seed, value: a number for weights, a vector for points

    def moves(row: Any, face: Any, at: Any, much: Any) -> None:
        """Adds `much` times the motion of `face` at the point `at` to row `row`."""
        scale = much * per_distance[face]
        if by == "weights":
            entries.append((row, i[face], 0.5 * scale))
            entries.append((row, j[face], -0.5 * scale))
        else:
            entries.append((row, i[face], scale[:, None] * at))
            entries.append((row, j[face], scale[:, None] * (vector[face] - at)))

    every = np.arange(len(i))
    if of == "volumes":
        moves(i, every, polygons.centroid, size)
    else:
        normal = polygons.area / np.where(size > 0, size, 1)[:, None]
        face, other = polygons.face, _other_faces(i, polygons)
        edge, middle = polygons.end - polygons.begin, 0.5 * (polygons.begin + polygons.end)
        outward = np.cross(edge, normal[face])  # with the length of the edge
        cosine = np.einsum("ek,ek->e", normal[face], normal[other])
        sine = np.einsum("ek,ek->e", outward, normal[other])
        squared = np.einsum("ek,ek->e", edge, edge)
        much = np.divide(squared, sine, out=np.zeros(len(sine)), where=sine > 0)
        moves(face, other, middle, much)
        moves(face, face, middle, -cosine * much)

    row, seed, value = (np.concatenate(parts) for parts in zip(*entries))
    kept = seed >= 0
    row, seed, value = row[kept], seed[kept], value[kept]
    shape = len(t) if of == "volumes" else len(i)
    if by == "weights":
        return coo_matrix((value, (row, seed)), shape=(shape, len(t))).tocsr()
    column = (3 * seed[:, None] + np.arange(3)).ravel()
    return coo_matrix((value.ravel(), (np.repeat(row, 3), column)), shape=(shape, 3 * len(t))).tocsr()
