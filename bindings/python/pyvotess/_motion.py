"""The motion of faces by seeds and weights, on which all derivatives of cells rest."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Iterator, Tuple

import numpy as np

from .pairs import edges_of

if TYPE_CHECKING:
    import numpy.typing as npt

    from ._state import SeedCells

    Float64Array = npt.NDArray[np.float64]
    Int32Array = npt.NDArray[np.int32]
    Int64Array = npt.NDArray[np.int64]

_CORNERS = 20_000  # of the faces in a block, so that its arrays stay in the cache


@dataclass(frozen=True)
class Motion:
    """The motion of P faces, one for each entry of the rows. Walls do not move.

    A point y of a face, relative to the seed i, moves along the outward normal by
    y.dx_i / d + (v - y).dx_j / d + (dw_i - dw_j) / 2 d. Here v is the vector to the neighbor j, and d its length: the
    change of |y - v|^2 - w_j - |y|^2 + w_i, divided by the length of its gradient, 2 d.
    """

    i: Int64Array  # (P,) the cell
    j: Int32Array  # (P,) the neighbor, negative for a wall
    vector: Float64Array  # (P, 3), 0 for a wall
    per_distance: Float64Array  # (P,) 1 / d, 0 for a wall


def motion_of(t: SeedCells, places: Float64Array) -> Motion:
    """Returns the motion of the faces of seeds, which are at ``places`` in the domain."""
    rows = t.neighbors
    i = np.repeat(np.arange(len(t)), np.diff(rows.indptr))
    j = rows.indices
    is_seed = j >= 0
    vector = places[np.where(is_seed, j, i)] - places[i]
    if t.shifts is not None:
        vector += np.where(is_seed[:, None], t.shifts @ edges_of(t), 0)
    distance = np.sqrt(np.einsum("pk,pk->p", vector, vector))
    return Motion(i, j, vector, np.divide(1, distance, out=np.zeros(len(i)), where=is_seed))


#: Terms of derivatives: a face or cell whose measure changes by `much` times the motion of a face at a point, relative
#: to the seed.
Terms = Tuple["Int64Array", "Int64Array", "Float64Array", "Float64Array"]


@dataclass(frozen=True)
class Polygons:
    """F faces of whole cells, from ``first`` on, cut into S simplices: fans of triangles, in the plane one segment each.

    Coordinates are relative to the seed of the cell.
    """

    first: int
    cell: Int64Array  # (F,)
    face: Int64Array  # (S,) from 0, the face of each simplex
    starts: Int64Array  # (F,) the first simplex of each face
    corners: Tuple[Float64Array, ...]  # three, in the plane two, (S, 3); the last two are the ends of an edge of the face
    ids: Tuple[Int32Array, Int32Array]  # two (S,) vertices: the ends of that edge
    parts: Float64Array  # (S,) sizes of simplices, which sum to those of the faces
    size: Float64Array  # (F,)
    normal: Float64Array  # (F, 3)

    def sums(self, values: Float64Array) -> Float64Array:
        """Returns the sums over the simplices of each face."""
        return np.add.reduceat(values, self.starts) if len(values) else values

    def centroid(self) -> Float64Array:
        """Returns the (F, 3) centroids of the faces."""
        middle = sum(self.corners) / len(self.corners)
        return self.sums(self.parts[:, None] * middle) / np.where(self.size > 0, self.size, 1)[:, None]

    def rims(self) -> Iterator[Terms]:
        """Yields the derivatives of the sizes of the faces, as terms of motions of faces at points.

        The change of an area is the integral of the motion of its edges along their outward normals m in the face:
        (motion of the other face - n.n' motion of this face) / m.n'. In the plane the ends of the face move.
        """
        begin, end = self.corners[-2:]
        a, b = (ids.astype(np.int64) for ids in self.ids)
        if len(self.corners) == 3:
            face, key = self.face, np.minimum(a, b) * (1 + max(a.max(initial=0), b.max(initial=0))) + np.maximum(a, b)
            edge, at = end - begin, 0.5 * (begin + end)
            outward = np.cross(edge, self.normal[face])  # with the length of the edge
            squared = np.einsum("ek,ek->e", edge, edge)
        else:
            face, key = np.tile(self.face, 2), np.concatenate((a, b))
            at = np.concatenate((begin, end))
            outward = np.stack((-self.normal[:, 1], self.normal[:, 0]), 1)  # counterclockwise
            outward = np.concatenate((-outward, outward))
            squared = np.ones(len(face))
        # An edge of a cell is on two faces. The sort is stable, and faces ascend by cell: both are side by side.
        order = np.lexsort((self.cell[face], key))
        other = np.empty(len(order), np.int64)
        other[order[0::2]], other[order[1::2]] = face[order[1::2]], face[order[0::2]]
        cosine = np.einsum("ek,ek->e", self.normal[face], self.normal[other])
        sine = np.einsum("ek,ek->e", outward, self.normal[other])
        much = np.divide(squared, sine, out=np.zeros(len(sine)), where=sine > 0)
        yield face, other, at, much
        yield face, face, at, -cosine * much


def polygons(t: SeedCells, places: Float64Array, first: int, last: int) -> Polygons:
    """Returns the faces of the cells from ``first`` to before ``last``."""
    rows, faces = t.neighbors, t.faces
    begin, end = int(rows.indptr[first]), int(rows.indptr[last])
    indptr = faces.indptr[begin : end + 1] - faces.indptr[begin]
    ids = faces.indices[faces.indptr[begin] : faces.indptr[end]]
    cell = np.repeat(np.arange(first, last), np.diff(rows.indptr[first : last + 1]))
    count = np.diff(indptr)
    place = places[np.repeat(cell, count)]
    position = t.vertices[ids] - place
    if t.planar:
        a, b = position[0::2], position[1::2]
        edge = b - a
        size = np.sqrt(np.einsum("fk,fk->f", edge, edge))
        normal = np.stack((edge[:, 1], -edge[:, 0]), 1) / np.where(size > 0, size, 1)[:, None]
        each = np.arange(len(count))
        return Polygons(begin, cell, each, each, (a, b), (ids[0::2], ids[1::2]), size, size, normal)
    face = np.repeat(np.arange(len(count)), count)
    entry = np.arange(len(ids))
    start = np.repeat(indptr[:-1], count)
    after = np.where(entry + 1 < np.repeat(indptr[1:], count), entry + 1, start)
    corners = position[start], position, position[after]
    part = 0.5 * np.cross(corners[1] - corners[0], corners[2] - corners[0])  # area vectors
    area = np.add.reduceat(part, indptr[:-1]) if len(count) else np.zeros((0, 3))
    size = np.sqrt(np.einsum("fk,fk->f", area, area))
    normal = area / np.where(size > 0, size, 1)[:, None]
    parts = np.einsum("sk,sk->s", part, normal[face])
    return Polygons(begin, cell, face, indptr[:-1], corners, (ids, ids[after]), parts, size, normal)


def blocks(t: SeedCells, places: Float64Array) -> Iterator[Polygons]:
    """Yields the faces of all cells, of some cells at a time."""
    ends = t.faces.indptr[t.neighbors.indptr]  # of the corners of each cell
    first = 0
    while first < len(t):
        last = max(first + 1, int(np.searchsorted(ends, ends[first] + _CORNERS, "right")) - 1)
        if ends[last] > ends[first]:
            yield polygons(t, places, first, last)
        first = last
