"""The motion of faces by seeds and weights, on which all derivatives of cells rest."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Iterator, Tuple

import numpy as np

from .pairs import edges_of

if TYPE_CHECKING:
    from ._state import SeedCells
    from ._types import Float64Array, Int32Array, Int64Array

_CORNERS = 20_000  # of the faces in a block, so that its arrays stay in the cache


def dot(a: Float64Array, b: Float64Array) -> Float64Array:
    """Returns the dot products of the columns."""
    products: Float64Array = np.einsum("ks,ks->s", a, b)
    return products


def _cross(a: Float64Array, b: Float64Array) -> Float64Array:
    (ax, ay, az), (bx, by, bz) = a, b
    return np.stack((ay * bz - az * by, az * bx - ax * bz, ax * by - ay * bx))


def _length(a: Float64Array) -> Float64Array:
    unit = unit_of(a)
    lengths: Float64Array = unit * np.sqrt(dot(a / unit, a / unit))
    return lengths


def _ratio(a: Float64Array, b: Float64Array) -> Float64Array:
    """Returns a / b, and 0 unless b is positive."""
    return np.divide(a, b, out=np.zeros_like(a), where=b > 0)


@dataclass(frozen=True, eq=False)
class Motion:
    """The motion of P faces, one for each entry of the rows. Walls do not move.

    Let v be the vector from seed i to its neighbor j, and d its length. A point y of the face, relative to i, moves along
    the outward normal by y.dx_i / d + (v - y).dx_j / d + (dw_i - dw_j) / 2 d. The face is the zero of
    |y - v|^2 - w_j - |y|^2 + w_i, and the gradient of that has the length 2 d.
    """

    i: Int64Array  # (P,) the cell
    j: Int32Array  # (P,) the neighbor, negative for a wall
    vector: Float64Array  # (3, P), 0 for a wall; in the plane (2, P), as all vectors here
    per_distance: Float64Array  # (P,) 1 / d, 0 for a wall
    unit: float  # of lengths here and in polygons(): a power of two


def unit_of(vectors: Float64Array) -> float:
    """Returns a power of two near the largest number. In this unit products of lengths stay in range."""
    return float(2.0 ** (int(np.frexp(np.abs(vectors).max(initial=0.0))[1]) - 1))


def unscaled(values: Float64Array, unit: float, power: int) -> Float64Array:
    """Returns values times a power of the unit, -1 to 2, which by itself may be beyond float64."""
    for _ in range(power):
        values = values * unit
    return values / unit if power < 0 else values


def motion_of(t: SeedCells, places: Float64Array) -> Motion:
    """Returns the motion of the faces of seeds, which are at ``places`` in the domain, in a unit near their vectors."""
    rows = t.neighbors
    i = np.repeat(np.arange(len(t)), np.diff(rows.indptr))
    j = rows.indices
    is_seed = j >= 0
    points = np.ascontiguousarray(places.T)
    vector = points.take(np.where(is_seed, j, i), axis=1) - points.take(i, axis=1)
    if t.shifts is not None:
        vector += edges_of(t).T @ np.where(is_seed, t.shifts.T, 0.0)
    unit = unit_of(vector)
    vector /= unit
    return Motion(i, j, vector, _ratio(np.ones(len(i)), _length(vector)), unit)


#: Terms of derivatives: the measure of a row changes by `much` times the motion of a face at a point, relative to the
#: seed. The arrays are row, face, point and much.
Terms = Tuple["Int64Array", "Int64Array", "Float64Array", "Float64Array"]


@dataclass(frozen=True, eq=False)
class Polygons:
    """F faces, and S simplices that fill them: fans of triangles, in the plane one segment for each.

    Coordinates are relative to the seed of the cell.
    """

    face: Int64Array  # (S,) the face of each simplex, from 0 on
    starts: Int64Array  # (F,) the first simplex of each face
    corners: Tuple[Float64Array, ...]  # three, in the plane two, of the simplices, each (3, S)
    parts: Float64Array  # (S,) sizes of simplices
    size: Float64Array  # (F,)
    normal: Float64Array  # (3, F)
    indptr: Int64Array  # (F + 1,) the corners of face k are indptr[k] to indptr[k + 1] of the following
    ids: Int32Array  # vertices
    position: Float64Array  # (3, indptr[F])

    def sums(self, values: Float64Array) -> Float64Array:
        """Returns the sums over the simplices of each face."""
        if len(self.starts) == values.shape[-1]:
            return values
        sums: Float64Array = np.add.reduceat(values, self.starts, axis=-1)
        return sums

    def centroids(self) -> Float64Array:
        """Returns the (3, F) centroids of the faces."""
        return self.sums(self.parts / len(self.corners) * sum(self.corners)) / np.where(self.size > 0, self.size, 1)

    def rims(self) -> Iterator[Terms]:
        """Yields terms of the derivatives of the sizes of the faces, which are those of whole cells.

        The change of an area is the integral of the motion of its edges, along their outward normals m in the face. An
        edge moves by (motion of the other face - n.n' motion of this face) / m.n'. In the plane the two ends move so.
        """
        face = np.repeat(np.arange(len(self.size)), np.diff(self.indptr))
        normal = self.normal.take(face, axis=1)
        entry = np.arange(len(face))
        if len(self.corners) == 3:
            after = entry + 1
            after[self.indptr[1:] - 1] = self.indptr[:-1]
            a, b = self.ids.astype(np.int64), self.ids[after].astype(np.int64)
            key = np.minimum(a, b) << 32 | np.maximum(a, b)
            begin, end = self.position, self.position.take(after, axis=1)
            at, edge = 0.5 * (begin + end), end - begin
            outward, squared = _cross(edge, normal), dot(edge, edge)  # both with the length of the edge
        else:
            key, at = self.ids, self.position
            tangent = np.stack((-normal[1], normal[0]))  # counterclockwise
            outward, squared = np.where(entry % 2, tangent, -tangent), np.ones(len(face))
        # Two faces of a cell have the edge. Faces ascend by cell and the sort is stable, so they are side by side.
        order = np.argsort(key, kind="stable")
        other = np.empty(len(order), np.int64)
        other[order[0::2]], other[order[1::2]] = face[order[1::2]], face[order[0::2]]
        normal_of_other = self.normal.take(other, axis=1)
        much = _ratio(squared, dot(outward, normal_of_other))
        yield face, other, at, much
        yield face, face, at, -dot(normal, normal_of_other) * much


def polygons(t: SeedCells, places: Float64Array, motion: Motion, faces: Int64Array) -> Polygons:
    """Returns these faces, entries of the rows in ascending order."""
    offsets = t.faces.indptr
    count = offsets[faces + 1] - offsets[faces]
    indptr = np.concatenate(([0], np.cumsum(count)))
    ids = t.faces.indices.take(np.arange(indptr[-1]) + np.repeat(offsets[faces] - indptr[:-1], count))
    position = (t.vertices.take(ids, axis=0) - places.take(np.repeat(motion.i[faces], count), axis=0)).T / motion.unit
    position = np.ascontiguousarray(position)
    each = np.arange(len(faces))
    if t.planar:
        a, b = position[:, 0::2], position[:, 1::2]
        edge = b - a
        size = _length(edge)
        normal = np.stack((edge[1], -edge[0])) / np.where(size > 0, size, 1)
        return Polygons(each, each, (a, b), size, size, normal, indptr, ids, position)
    face = np.repeat(each, count - 2)
    middle = np.arange(len(face)) + 2 * face + 1  # the second corner of each triangle
    corners = tuple(position.take(entry, axis=1) for entry in (indptr[face], middle, middle + 1))
    part = 0.5 * _cross(corners[1] - corners[0], corners[2] - corners[0])  # area vectors
    starts = indptr[:-1] - 2 * each
    area = np.add.reduceat(part, starts, axis=1) if len(faces) else np.zeros((3, 0))
    size = _length(area)
    normal = area / np.where(size > 0, size, 1)
    return Polygons(face, starts, corners, dot(part, normal.take(face, axis=1)), size, normal, indptr, ids, position)


def blocks(
    t: SeedCells, places: Float64Array, motion: Motion, faces: Int64Array
) -> Iterator[Tuple[slice, Polygons]]:
    """Yields these faces, those of some cells at a time, and which they are of ``faces``."""
    firsts = np.searchsorted(faces, t.neighbors.indptr)  # of the faces of each cell
    corners = np.concatenate(([0], np.cumsum(np.diff(t.faces.indptr)[faces])))[firsts]
    cell = 0
    while cell < len(t):
        end = max(cell + 1, int(np.searchsorted(corners, corners[cell] + _CORNERS, "right")) - 1)
        part = slice(int(firsts[cell]), int(firsts[end]))
        if part.start < part.stop:
            yield part, polygons(t, places, motion, faces[part])
        cell = end
