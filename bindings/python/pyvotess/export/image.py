"""Pictures drawn by the library, without other packages."""

from __future__ import annotations

import ctypes
import os
import struct
import zlib
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Mapping, Optional, Tuple, Union

import numpy as np

from .. import _c_api
from .._arguments import as_count, as_flag, as_number, as_path, as_word, shown
from .._call import raise_on_failure, watched
from .._input import as_array
from .._library import lib
from .colors import COLORMAPS
from .columns import color_values
from .whole_file import whole_file

if TYPE_CHECKING:
    import numpy.typing as npt

    from .._call import Handle
    from .._state import SeedCells

CUTS = {"corner": 0, "half": 1, "cells": 2, "none": 3}


@dataclass(frozen=True, eq=False)
class Image:
    """A picture. Notebooks show it."""

    pixels: npt.NDArray[np.uint8]  #: (height, width, 4) red, green, blue and opacity
    left_out: int  #: cells that reach infinity, with ``open="skip"``

    def __repr__(self) -> str:
        height, width = self.pixels.shape[:2]
        return f"<pyvotess image of {width} x {height} pixels>"

    def _repr_png_(self) -> bytes:
        height, width = self.pixels.shape[:2]
        # Each row begins with its filter, which is none. See the PNG specification, https://www.w3.org/TR/png-3/.
        rows = np.concatenate([np.zeros((height, 1), np.uint8), self.pixels.reshape(height, -1)], axis=1)

        def chunk(name: bytes, data: bytes) -> bytes:
            return struct.pack(">I", len(data)) + name + data + struct.pack(">I", zlib.crc32(name + data))

        head = struct.pack(">IIBBBBB", width, height, 8, 6, 0, 0, 0)
        return b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", head) + chunk(b"IDAT", zlib.compress(rows.tobytes())) + chunk(b"IEND", b"")

    def save(self, path: Union[str, os.PathLike[str]]) -> None:
        """Writes a ``.png``, whole or not at all. Raises ValueError for another extension, OSError if that fails."""
        with whole_file(png_path(path, "path")) as name, open(name, "wb") as out:
            out.write(self._repr_png_())


def png_path(path: Union[str, os.PathLike[str]], name: str) -> str:
    """Returns a path that ends in .png. Raises ValueError."""
    file = as_path(path, name)
    if os.path.splitext(file)[1].lower() != ".png":
        raise ValueError(f"{name} is {file!r}: give a name that ends in .png")
    return file


def _options(
    values: npt.NDArray[np.float64],
    label: str,
    colormap: str,
    cut: str,
    view: Tuple[float, float],
    size: Tuple[int, int],
    limits: Optional[Tuple[float, float]],
    threads: int,
) -> Any:
    """Returns options for any picture."""
    options = _c_api.PictureOptions()
    raise_on_failure(lib.votess_picture_options_init(options, ctypes.sizeof(options)))
    options.values, options.value_count = values, len(values)
    options.label = label.encode()
    options.colormap = as_word(colormap, "colormap", COLORMAPS)
    options.cut = as_word(cut, "cut", CUTS)
    options.azimuth, options.elevation = pair(view, "view")
    options.width, options.height = (as_count(pixels, "size", 32) for pixels in two(size, "size"))
    if not 64 <= min(options.width, options.height) <= max(options.width, options.height) <= 16384:
        raise ValueError(f"size is {shown(size)}: give 64 to 16384 pixels each")
    if limits is not None:
        options.range[:] = pair(limits, "limits")
        if not -np.inf < options.range[0] < options.range[1] < np.inf:
            raise ValueError(f"limits is {shown(limits)}: give two finite numbers, the lower one first")
    options.threads = as_count(threads, "threads", 32)
    return options


def image(
    t: SeedCells,
    handle: Handle,
    color: Union[str, npt.ArrayLike],
    slice: Optional[Tuple[str, float]],
    seeds: bool,
    gap: float,
    open: Optional[str],
    **look: Any,
) -> Image:
    """See :meth:`pyvotess.Tessellation.image`. ``look``: further arguments of _options()."""
    numbers, label = color_values(t, color)
    values = np.ascontiguousarray(numbers, dtype=np.float64)
    options = _options(values, label, **look)
    if slice is not None:
        axis, value = two(slice, "slice")
        options.slice_axis = as_word(axis, "slice", {"x": 0, "y": 1, "z": 2})
        options.slice_value = as_number(value, "slice")
    options.seeds = as_flag(seeds, "seeds")
    options.gap = as_number(gap, "gap")
    options.skip_open = open is not None and as_word(open, "open", {"skip": 1})
    pixels = np.empty((options.height, options.width, 4), np.uint8)
    points = np.ascontiguousarray(t.points, dtype=np.float64)
    left_out = ctypes.c_uint64()
    raise_on_failure(watched(lib.votess_render, handle, points, len(points), options, pixels, pixels.nbytes, left_out))
    return Image(pixels, left_out.value)


def image_of_pieces(
    arrays: Mapping[str, Any],
    values: npt.NDArray[np.float64],
    label: str,
    file: Any,
    planar: bool,
    **look: Any,
) -> Image:
    """Draws closed triangle meshes, or polygons of the plane.

    ``arrays``: those of ``votess_piece_arrays``, of which each row is one piece. ``file``: a .png to write, or None.
    """
    path = None if file is None else png_path(file, "file")
    count = len(arrays["vertex_offsets"]) - 1
    if count == 0:
        raise ValueError("there are no pieces to draw")
    rows = {"indptr": np.arange(count + 1, dtype=np.int64), "ids": np.arange(count, dtype=np.int64)}
    given = _c_api.PieceArrays(rows=count, **{name: np.ascontiguousarray(a) for name, a in {**arrays, **rows}.items()})
    numbers = np.ascontiguousarray(values, np.float64)
    options = _options(numbers, label, **look)
    options.planar = planar
    pixels = np.empty((options.height, options.width, 4), np.uint8)
    raise_on_failure(watched(lib.votess_render_pieces, given, options, pixels, pixels.nbytes))
    picture = Image(pixels, 0)
    if path is not None:
        picture.save(path)
    return picture


def two(values: Any, name: str) -> Tuple[Any, Any]:
    """Returns the two values of an argument. Raises ValueError."""
    given = tuple(values) if isinstance(values, (tuple, list)) or as_array(values, name).ndim == 1 else ()
    if len(given) != 2:
        raise ValueError(f"{name} is {shown(values)}: give two values")
    return given[0], given[1]


def pair(values: Any, name: str) -> Tuple[float, float]:
    """Returns the two numbers of an argument. Raises ValueError."""
    first, second = two(values, name)
    return as_number(first, name), as_number(second, name)
