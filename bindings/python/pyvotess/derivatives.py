"""Derivatives of volumes and areas as sparse matrices."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, List, Optional

import numpy as np

from ._arguments import as_word
from ._motion import blocks, motion_of, unit_of, unscaled
from .export.optional import imported

if TYPE_CHECKING:
    from ._state import SeedCells
    from ._types import Float64Array


def _volumes_in_mesh(t: SeedCells, places: Any, of: str, by: str) -> Any:
    """Returns the derivatives of volumes of parts in a mesh, from the triangles or edges of pieces between two cells.

    The surface stays where it is, so that it adds nothing.
    """
    coo_matrix = imported("scipy.sparse", "derivatives()", "scipy").coo_matrix
    if of != "volumes":
        raise ValueError("of is 'areas': in a mesh give 'volumes', or tessellate without mesh=")
    if t.shifts is not None:
        raise ValueError("derivatives() in a mesh need a domain that does not repeat: leave out periodic= or mesh=")
    pieces = t.pieces()  # type: ignore[attr-defined]
    inner = ~pieces.on_surface
    i, j = pieces.cells[pieces._piece_of[inner]], pieces.sources[inner].astype(np.int64)
    vector = places[j] - places[i]
    unit, size = unit_of(vector), places.shape[1]
    vector /= unit
    corners = (pieces.vertices[pieces._corners[inner]] - places[i][:, None]) / unit
    along = corners[:, 1] - corners[:, 0]
    area = np.linalg.norm(along if size == 2 else 0.5 * np.cross(along, corners[:, 2] - corners[:, 0]), axis=1)
    at = corners.mean(axis=1)
    scale = area / np.linalg.norm(vector, axis=1)
    row, seed = np.tile(i, 2), np.concatenate((i, j))
    if by == "weights":
        value = 0.5 * unscaled(np.concatenate((scale, -scale)), unit, size - 2)
        return coo_matrix((value, (row, seed)), shape=(len(t), len(t))).tocsr()
    value = np.concatenate((scale[:, None] * at, scale[:, None] * (vector - at))).ravel()
    column = (size * seed[:, None] + np.arange(size)).ravel()
    entry = (unscaled(value, unit, size - 1), (np.repeat(row, size), column))
    return coo_matrix(entry, shape=(len(t), size * len(t))).tocsr()


def make_derivatives(t: SeedCells, of: str, by: str, open: Optional[str]) -> Any:
    """See :meth:`Tessellation.derivatives`.

    The change of a volume is the integral of the motion of its faces.
    """
    as_word(of, "of", dict.fromkeys(("volumes", "areas")))
    as_word(by, "by", dict.fromkeys(("points", "weights")))
    closed = t._closed_cells("derivatives()", open)
    t._require_whole_faces("derivatives()")
    sparse = imported("scipy.sparse", "derivatives()", "scipy")
    coo_matrix, csr_matrix = sparse.coo_matrix, sparse.csr_matrix
    places = t.wrapped_points
    size = places.shape[1]
    columns = len(t) if by == "weights" else size * len(t)
    by_areas = of == "volumes" and by == "weights" and "areas" in t.wanted
    if t.in_mesh and not by_areas:
        return _volumes_in_mesh(t, places, of, by)
    motion = motion_of(t, places)
    i, j = motion.i, motion.j
    chosen = np.arange(len(i)) if closed is None else np.flatnonzero(closed[i])
    if by_areas:
        is_seed = chosen[j[chosen] >= 0]
        value = 0.5 * t.face_areas[is_seed] / motion.unit * motion.per_distance[is_seed]
        cell, neighbor = i[is_seed], j[is_seed]
        entry = (np.concatenate((value, -value)), (np.tile(cell, 2), np.concatenate((cell, neighbor))))
        return coo_matrix(entry, shape=(len(t), columns)).tocsr()
    power = size - (1 if of == "volumes" else 2) - (by == "weights")
    # Blocks of cells, and so of rows, need little more memory than the matrix.
    lengths = np.zeros(len(t) if of == "volumes" else len(i), np.int64)
    indices: List[Any] = []
    values: List[Any] = []
    for taken, faces in blocks(t, places, motion, chosen):
        part = chosen[taken]
        i_of, j_of, vector, per_distance = i[part], j[part], motion.vector[:, part], motion.per_distance[part]
        every = np.arange(len(i_of))
        first = int(i_of[0])
        rows = np.arange(first, int(i_of[-1]) + 1) if of == "volumes" else part
        terms = [(i_of - first, every, faces.centroids(), faces.size)] if of == "volumes" else faces.rims()
        entries: List[Any] = []  # row, seed, value: a number for weights, a vector for points
        for row, face, at, much in terms:
            scale = much * per_distance[face]
            if by == "weights":
                entries.append((row, i_of[face], 0.5 * scale))
                entries.append((row, j_of[face], -0.5 * scale))
            else:
                entries.append((row, i_of[face], (scale * at).T))
                entries.append((row, j_of[face], (scale * (vector[:, face] - at)).T))
        row, seed, value = (np.concatenate(parts) for parts in zip(*entries))
        kept = seed >= 0
        row, column, value = row[kept], seed[kept], unscaled(value[kept], motion.unit, power)
        if by == "points":
            row, value = np.repeat(row, size), value.ravel()
            column = (size * column.astype(np.int64)[:, None] + np.arange(size)).ravel()
        block = coo_matrix((value, (row, column)), shape=(len(rows), columns)).tocsr()
        lengths[rows] = np.diff(block.indptr)
        indices.append(block.indices)
        values.append(block.data)
    indptr = np.concatenate(([0], np.cumsum(lengths)))
    if not values:
        return csr_matrix((len(lengths), columns))
    return csr_matrix((np.concatenate(values), np.concatenate(indices), indptr), shape=(len(lengths), columns))
