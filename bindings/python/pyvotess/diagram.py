"""Seeds that stay and are asked many times: which cell holds a point."""

from __future__ import annotations

import ctypes
from typing import TYPE_CHECKING, Any, Iterable, Optional, Union

import numpy as np

from . import _c_api
from ._c_api import DuplicatesWord, OutsideWord
from ._call import Handle, raise_on_failure
from ._input import Domain, as_points, as_word
from ._library import lib
from .tessellator import new_options

if TYPE_CHECKING:
    import numpy.typing as npt


class Diagram:
    """Seeds, sorted and searched once; no cell is built. It never changes, and any number of threads may ask it.

    Parameters
    ----------
    points : (N, 3) array of real numbers, as for :func:`tessellate`; copied.
    box, periodic, weights, radii, cell, origin, walls, outside, duplicates, threads, grid_resolution, instructions : as
        for :func:`tessellate`. Queries run on the CPU.

    Raises
    ------
    ValueError : bad input; the message names the first offending index and value.
    """

    def __init__(
        self,
        points: npt.ArrayLike,
        box: Optional[npt.ArrayLike] = None,
        periodic: Optional[Union[bool, str, Iterable[bool]]] = None,
        weights: Optional[npt.ArrayLike] = None,
        radii: Optional[npt.ArrayLike] = None,
        cell: Optional[npt.ArrayLike] = None,
        walls: npt.ArrayLike = (),
        threads: int = 0,
        duplicates: DuplicatesWord = "merge",
        origin: Optional[npt.ArrayLike] = None,
        outside: OutsideWord = "error",
        grid_resolution: int = 0,
        instructions: str = "",
    ) -> None:
        array = np.require(as_points(points), np.float64, ["C_CONTIGUOUS", "ALIGNED"])
        options = new_options("cpu", threads, grid_resolution=grid_resolution, instructions=instructions)
        options.duplicates = as_word(duplicates, "duplicates", _c_api.DUPLICATES)
        kept = Domain(box, periodic, weights, radii, cell, origin, walls, outside).fill(options, len(array))
        self._handle = Handle(lib.votess_diagram_free)
        raise_on_failure(
            lib.votess_diagram_new(
                array.ctypes.data, len(array), ctypes.byref(options), ctypes.byref(self._handle.pointer)
            )
        )
        del kept

    def __len__(self) -> int:
        """N, the number of seeds."""
        return int(lib.votess_diagram_size(self._handle.pointer))

    def locate(self, queries: npt.ArrayLike) -> npt.NDArray[np.int32]:
        """In whose cell each query lies.

        queries : (Q, 3) array of finite numbers; in a periodic domain anywhere, they are wrapped without rounding.

        Returns (Q,) indices of seeds. ``|x - p|^2 - w`` is least for them, exactly; of several cells that meet in the
        query the lowest index is named; -1 where the domain is not (a wall belongs to it), or where there are no
        seeds. The GIL is released.
        """
        array = np.require(as_points(queries, "queries"), np.float64, ["C_CONTIGUOUS", "ALIGNED"])
        seeds = np.empty(len(array), np.int32)
        raise_on_failure(
            lib.votess_diagram_locate(self._handle.pointer, array.ctypes.data, len(array), seeds.ctypes.data)
        )
        return seeds

    def __reduce__(self) -> Any:
        raise TypeError("a Diagram cannot be copied or pickled: make another one of the same points")
