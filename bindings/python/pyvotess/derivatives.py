"""Derivatives of volumes and areas as sparse matrices."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, List

import numpy as np

from ._arguments import as_word
from ._motion import motion_of, polygons

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
    from scipy.sparse import coo_matrix

    places = t.wrapped_points
    motion = motion_of(t, places)
    i, j = motion.i, motion.j
    if of == "volumes" and by == "weights" and "areas" in t.wanted:
        is_seed = j >= 0
        value = 0.5 * t.face_areas[is_seed] * motion.per_distance[is_seed]
        cell, neighbor = i[is_seed], j[is_seed]
        entry = (np.concatenate((value, -value)), (np.tile(cell, 2), np.concatenate((cell, neighbor))))
        return coo_matrix(entry, shape=(len(t), len(t))).tocsr()
    every = np.arange(len(i))
    faces = polygons(t, places, motion, every)
    terms = [(i, every, faces.centroids(), faces.size)] if of == "volumes" else faces.rims()
    entries: List[Any] = []  # row, seed, value: a number for weights, a vector for points
    for row, face, at, much in terms:
        scale = much * motion.per_distance[face]
        if by == "weights":
            entries.append((row, i[face], 0.5 * scale))
            entries.append((row, j[face], -0.5 * scale))
        else:
            entries.append((row, i[face], (scale * at).T))
            entries.append((row, j[face], (scale * (motion.vector[:, face] - at)).T))

    row, seed, value = (np.concatenate(parts) for parts in zip(*entries))
    kept = seed >= 0
    row, seed, value = row[kept], seed[kept], value[kept]
    shape = len(t) if of == "volumes" else len(i)
    if by == "weights":
        return coo_matrix((value, (row, seed)), shape=(shape, len(t))).tocsr()
    size = places.shape[1]
    column = (size * seed[:, None] + np.arange(size)).ravel()
    return coo_matrix((value.ravel(), (np.repeat(row, size), column)), shape=(shape, size * len(t))).tocsr()
