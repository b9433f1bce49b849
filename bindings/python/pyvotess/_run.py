"""Options of a run, and the run: from the points to the library's result."""

from __future__ import annotations

import ctypes
from typing import TYPE_CHECKING, Any, Iterable, Optional, Tuple, Union

import numpy as np

from . import _c_api
from ._c_api import DuplicatesWord, PrecisionWord, WantName
from ._call import Handle, Progress, raise_on_failure, run, showing
from ._input import Domain, as_count, as_points, as_text, as_want, as_word
from ._library import lib

if TYPE_CHECKING:
    import numpy.typing as npt


def new_options(
    device: str,
    threads: int,
    precision: PrecisionWord = "single",
    grid_resolution: int = 0,
    k_init: int = 0,
    chunk_size: int = 0,
    instructions: str = "",
) -> _c_api.Options:
    options = _c_api.Options()
    raise_on_failure(lib.votess_options_init(ctypes.byref(options), ctypes.sizeof(options)))
    options.device = as_text(device, "device")
    options.threads = as_count(threads, "threads", 32)
    options.precision = as_word(precision, "precision", _c_api.PRECISIONS)
    options.grid_resolution = as_count(grid_resolution, "grid_resolution", 32)
    options.k_init = as_count(k_init, "k_init", 32)
    options.chunk_size = as_count(chunk_size, "chunk_size", 32)
    options.instructions = as_text(instructions, "instructions")
    return options


def implied_words(options: _c_api.Options) -> Tuple[str, ...]:
    """Returns the words of ``want`` for all arrays that the options imply."""
    implied = ctypes.c_uint32()
    raise_on_failure(lib.votess_options_implied_want(ctypes.byref(options), ctypes.byref(implied)))
    return tuple(word for word, bit in _c_api.WANT_BITS.items() if implied.value & bit)


def tessellate_points(
    tessellator: Optional[Handle],
    options: _c_api.Options,
    points: Any,
    domain: Domain,
    want: Union[str, Iterable[WantName]],
    list_walls: bool,
    duplicates: DuplicatesWord,
    progress: Union[None, bool, Progress],
    min_face: float,
    min_area: float,
) -> Tuple[Handle, npt.NDArray[Any], Tuple[str, ...]]:
    """Returns the library's result, the (N, 3) points that it read, and the words of ``want`` that it holds."""
    array = as_points(points)
    options.want = as_want(want)
    options.min_face = float(min_face)
    options.min_area = float(min_area)
    options.list_walls = bool(list_walls)
    options.duplicates = as_word(duplicates, "duplicates", _c_api.DUPLICATES)
    kept = domain.fill(options, len(array))
    wanted = implied_words(options)

    function = lib.votess_tessellate_f32 if array.dtype == np.float32 else lib.votess_tessellate
    result = Handle(lib.votess_result_free)
    arguments = (tessellator.pointer if tessellator else None, array.ctypes.data, len(array))
    with showing(progress) as call:
        run(function, arguments, options, ctypes.byref(result.pointer), call)
    del kept
    return result, array, wanted
