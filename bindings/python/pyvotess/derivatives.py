"""Derivatives of volumes and areas as sparse matrices."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, List

import numpy as np

from ._arguments import as_word
from ._motion import blocks, motion_of

if TYPE_CHECKING:
    from ._state import SeedCells


def make_derivatives(t: SeedCells, of: str, by: str) -> Any:
    """See :meth:`Tessellation.derivatives`.

    The change of a volume is the integral of the motion of its faces.
    """
    as_word(of, "of", dict.fromkeys(("volumes", "areas")))
    as_word(by, "by", dict.fromkeys(("points", "weights")))
    t._require_end("derivatives()")
    t._require_whole_faces("derivatives()")
    from scipy.sparse import coo_matrix, csr_matrix

    places = t.wrapped_points
    size = places.shape[1]
    columns = len(t) if by == "weights" else size * len(t)
    motion = motion_of(t, places)
    i, j = motion.i, motion.j
    if of == "volumes" and by == "weights" and "areas" in t.wanted:
        is_seed = j >= 0
        value = 0.5 * t.face_areas[is_seed] * motion.per_distance[is_seed]
        cell, neighbor = i[is_seed], j[is_seed]
        entry = (np.concatenate((value, -value)), (np.tile(cell, 2), np.concatenate((cell, neighbor))))
        return coo_matrix(entry, shape=(len(t), columns)).tocsr()
    # Blocks of cells, and so of rows, need little more memory than the matrix.
    lengths = np.zeros(len(t) if of == "volumes" else len(i), np.int64)
    indices: List[Any] = []
    values: List[Any] = []
    for part, faces in blocks(t, places, motion, np.arange(len(i))):
        i_of, j_of, vector, per_distance = i[part], j[part], motion.vector[:, part], motion.per_distance[part]
        every = np.arange(len(i_of))
        first = int(i_of[0]) if of == "volumes" else part.start
        count = int(i_of[-1]) + 1 - first if of == "volumes" else len(i_of)
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
        row, column, value = row[kept], seed[kept], value[kept]
        if by == "points":
            row, value = np.repeat(row, size), value.ravel()
            column = (size * column.astype(np.int64)[:, None] + np.arange(size)).ravel()
        block = coo_matrix((value, (row, column)), shape=(count, columns)).tocsr()
        lengths[first : first + count] = np.diff(block.indptr)
        indices.append(block.indices)
        values.append(block.data)
    indptr = np.concatenate(([0], np.cumsum(lengths)))
    if not values:
        return csr_matrix((len(lengths), columns))
    return csr_matrix((np.concatenate(values), np.concatenate(indices), indptr), shape=(len(lengths), columns))
