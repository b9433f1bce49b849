"""Colors of values, as in the library's pictures."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Tuple

import numpy as np

from .._call import raise_on_failure
from .._arguments import as_word
from .._input import as_array
from .._library import lib
from .columns import color_values

if TYPE_CHECKING:
    from .._state import SeedCells
    from .._types import Float64Array, UInt8Array

COLORMAPS = {"tide": 0, "ember": 1, "gray": 2}


def limits(values: Float64Array) -> Tuple[float, float, bool]:
    """Returns the limits of the color scale, and whether their ratio calls for a logarithmic scale."""
    finite = values[np.isfinite(values)]
    if len(finite) == 0:
        return 0.0, 1.0, False
    low, high = (float(x) for x in np.quantile(finite, (0.005, 0.995)))
    return low, high, low > 0 and high / low > 30


def map_values(values: Float64Array, colormap: str) -> UInt8Array:
    """Returns (M, 3) uint8 sRGB colors of the values, gray for NaN, on a logarithmic scale for a wide range."""
    number = as_word(colormap, "colormap", COLORMAPS)
    values = np.ascontiguousarray(values, dtype=np.float64)
    colors = np.empty((len(values), 3), np.uint8)
    raise_on_failure(lib.votess_value_colors(values, len(values), number, colors))
    return colors


def cell_colors(t: SeedCells, color: Any, colormap: str) -> UInt8Array:
    """Returns (N, 3) uint8 sRGB colors. ``color``: as for :func:`color_values`, or (N, 3) colors, uint8 or 0 to 1."""
    given = np.zeros(0) if isinstance(color, str) else as_array(color, "color")
    if given.ndim == 2:
        if given.shape != (len(t), 3) or given.dtype.kind not in "uif":
            raise ValueError(f"color has shape {given.shape}: give ({len(t)},) values, or ({len(t)}, 3) red, green and blue")
        if given.dtype == np.uint8:
            return np.asarray(given, np.uint8)
        if given.dtype.kind != "f" or not ((given >= 0) & (given <= 1)).all():
            raise ValueError("color has red, green and blue outside of 0 to 1: give uint8, or numbers from 0 to 1")
        return np.asarray(np.rint(255 * given), np.uint8)
    return map_values(color_values(t, color)[0], colormap)
