"""Segments as closed triangle meshes."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Dict

import numpy as np

if TYPE_CHECKING:
    from .._types import Float64Array

SIDES = 6


def tubes(begin: Float64Array, vector: Float64Array, width: float) -> Dict[str, Any]:
    """Returns the arrays of ``votess_piece_arrays`` of tubes along segments, (M, 3) each, of this width."""
    count = len(begin)
    along = vector / np.maximum(np.linalg.norm(vector, axis=1), np.finfo(float).tiny)[:, None]
    # Across: the axis that is farthest from the direction, made perpendicular to it.
    axis = np.eye(3)[np.abs(along).argmin(axis=1)]
    right = np.cross(along, axis)
    right /= np.linalg.norm(right, axis=1)[:, None]
    up = np.cross(along, right)
    turn = 2 * np.pi * np.arange(SIDES) / SIDES
    ring = 0.5 * width * (np.cos(turn)[:, None] * right[:, None] + np.sin(turn)[:, None] * up[:, None])
    ends = np.stack([begin[:, None] + ring, (begin + vector)[:, None] + ring], axis=1)  # (M, 2, SIDES, 3)
    k = np.arange(SIDES)
    after = (k + 1) % SIDES
    inner = np.arange(1, SIDES - 1)
    first = np.zeros_like(inner)
    sides = np.concatenate([np.stack([k, after, after + SIDES], 1), np.stack([k, after + SIDES, k + SIDES], 1)])
    caps = np.concatenate([np.stack([first, inner + 1, inner], 1), SIDES + np.stack([first, inner, inner + 1], 1)])
    one = np.concatenate([sides, caps])
    return {
        "vertex_offsets": np.arange(count + 1, dtype=np.int64) * (2 * SIDES),
        "vertices": ends.reshape(-1, 3),
        "triangle_offsets": np.arange(count + 1, dtype=np.int64) * len(one),
        "triangles": np.tile(one, (count, 1)).astype(np.int32),
        "on_surface": np.ones(count * len(one), np.uint8),
        "centroids": begin + 0.5 * vector,
        "sources": np.zeros(count * len(one), np.int32),
    }
