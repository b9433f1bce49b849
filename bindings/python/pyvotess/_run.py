"""Options of a run, and the run: from the points to the library's result."""

from __future__ import annotations

import ctypes
from typing import TYPE_CHECKING, Any, Dict, Optional, Tuple

import numpy as np

from . import _c_api
from ._arrays import WANT_BITS
from ._arguments import as_count, as_flag, as_number, as_text, as_want, as_word
from ._call import Handle, raise_on_failure, run
from ._domain import Domain, as_domain
from ._input import as_only, as_points, fill_weights
from ._library import lib

if TYPE_CHECKING:
    import numpy.typing as npt

    from ._types import Float64Array


def new_options(**given: Any) -> Any:
    """Returns the library's defaults with the given values."""
    options = _c_api.Options()
    raise_on_failure(lib.votess_options_init(options, ctypes.sizeof(options)))
    set_options(options, given)
    return options


def set_options(options: _c_api.Struct, given: Dict[str, Any]) -> None:
    """Sets ``want`` and the options that are one flag, number, word or text, by name."""
    types: Dict[str, Any] = {field[0]: field[1] for field in _c_api.Options._fields_}
    for name, value in given.items():
        if name == "want":
            options.want = as_want(value)
        elif name in _c_api.WORDS:
            setattr(options, name, as_word(value, name, _c_api.WORDS[name]))
        elif types[name] is ctypes.c_uint32:
            setattr(options, name, as_count(value, name, 32))
        elif types[name] is ctypes.c_char_p:
            setattr(options, name, as_text(value, name))
        else:
            setattr(options, name, (as_number if types[name] is ctypes.c_double else as_flag)(value, name))


def implied_words(options: _c_api.Struct) -> Tuple[str, ...]:
    """Returns the words of ``want`` for all arrays that the options imply."""
    implied = ctypes.c_uint32()
    raise_on_failure(lib.votess_options_implied_want(options, implied))
    return tuple(word for word, bit in WANT_BITS.items() if implied.value & bit)


def tessellate_points(
    tessellator: Optional[Handle], options: _c_api.Struct, given: Dict[str, Any]
) -> Tuple[Handle, npt.NDArray[Any], Tuple[str, ...], Domain, Optional[Float64Array]]:
    """Runs with the arguments of ``tessellate()`` by name, those of its Tessellator set in ``options``.

    Returns the library's result, the (N, 3) or (N, 2) points that it read, the words of ``want`` that it holds, the
    domain as it was given, and with ``only`` the weights of all points if they have some.
    """
    array, progress = as_points(given.pop("points"), planar=True), given.pop("progress")
    domain = as_domain(given.pop("domain"), given.pop("keywords", {}))
    weights, radii = given.pop("weights"), given.pop("radii")
    given["planar"] = array.shape[1] == 2
    only = as_only(given.pop("only", None), len(array))
    set_options(options, given)
    domain._fill(options, array)
    given_weights = fill_weights(options, weights, radii, len(array))
    if only is not None:
        options.has_only, options.only_count, options.only = 1, len(only), only
    wanted = implied_words(options)

    function = lib.votess_tessellate_f32 if array.dtype == np.float32 else lib.votess_tessellate
    result = Handle("result")
    run(function, tessellator, array, len(array), options, result, options=options, progress=progress)
    return result, array, wanted, domain, None if only is None or given_weights is None else given_weights.copy()
