"""Exact orientations of simplices."""

from __future__ import annotations

from fractions import Fraction
from typing import TYPE_CHECKING, Any, List

import numpy as np

if TYPE_CHECKING:
    from .._types import Float64Array, Int64Array


def orientation(points: Float64Array, *ids: Int64Array) -> Int64Array:
    """Returns the exact sign of det(b-a, c-a, ...) for arrays of ids: a, b, c in the plane, and d in space."""
    rows = [list((points[corner] - points[ids[0]]).T) for corner in ids[1:]]
    with np.errstate(over="ignore", invalid="ignore"):
        value = _expand(rows, -1)
        # Bounds a few roundings of 2**-53 each with reserve. Products below the floor may be denormal.
        size = _expand([[np.abs(x) for x in row] for row in rows], 1)
        certain = np.abs(value) > np.maximum(2.0**-48 * size, 1e-280)
    sign: Int64Array = np.where(certain, np.sign(value), 0).astype(np.int64)
    # Corners with an equal coordinate, as on the sides of a box, are flat. Fractions decide the others.
    flat = np.logical_or.reduce([np.logical_and.reduce([x == 0 for x in column]) for column in zip(*rows)])
    for p in np.flatnonzero(~certain & ~flat):
        sign[p] = _exact_sign([points[corner[p]].tolist() for corner in ids])
    return sign


def _exact_sign(corners: List[List[float]]) -> int:
    first, *others = ([Fraction(x) for x in corner] for corner in corners)
    value = _expand([[x - y for x, y in zip(corner, first)] for corner in others], -1)
    return int(value > 0) - int(value < 0)


def _expand(rows: List[List[Any]], sign: int) -> Any:
    """Returns the determinant of rows of numbers or arrays if sign is -1, their permanent if it is 1."""
    if len(rows) == 1:
        return rows[0][0]
    minors = ([row[:k] + row[k + 1 :] for row in rows[1:]] for k in range(len(rows)))
    return sum(sign**k * x * _expand(minor, sign) for k, (x, minor) in enumerate(zip(rows[0], minors)))
