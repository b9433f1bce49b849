"""Seeds that stay and are asked many times: which cell holds a point, and what cell a point would have."""

from __future__ import annotations

import ctypes
from typing import TYPE_CHECKING, Any, Iterable, Optional, Union

import numpy as np

from . import _c_api
from ._c_api import DuplicatesWord, OutsideWord, WantWord
from ._call import Handle, raise_on_failure
from ._input import Domain, as_one_each, as_points, as_want, as_word
from ._library import lib
from ._state import Cells
from .tessellator import implied_words, new_options

if TYPE_CHECKING:
    import numpy.typing as npt


def _as_queries(queries: Any) -> npt.NDArray[np.float64]:
    return np.require(as_points(queries, "queries"), np.float64, ["C_CONTIGUOUS", "ALIGNED"])


class Probes(Cells):
    """The cells that N queries would have, see :meth:`Diagram.probe`; rows follow the queries.

    Arrays are those of a :class:`Tessellation`, read-only too. But each cell is one among the seeds alone: cells of
    queries that lie near each other overlap, and what is made of a whole diagram is not there.
    """

    def __repr__(self) -> str:
        wanted = ", ".join(self.wanted) or "status only"
        return f"<pyvotess.Probes of {len(self)} queries in a {self._domain()}: {wanted}>"


class Diagram:
    """Seeds, sorted and searched once; their cells are not built. It never changes, and any number of threads may ask it.

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
        array = _as_queries(queries)
        seeds = np.empty(len(array), np.int32)
        raise_on_failure(
            lib.votess_diagram_locate(self._handle.pointer, array.ctypes.data, len(array), seeds.ctypes.data)
        )
        return seeds

    def probe(
        self,
        queries: npt.ArrayLike,
        want: Union[str, Iterable[WantWord]] = ("neighbors", "volumes"),
        weights: Optional[npt.ArrayLike] = None,
        list_walls: bool = False,
    ) -> Probes:
        """The cell that each query would have if it alone were added to the seeds.

        Row q is what :func:`tessellate` finds for the last of the seeds and query q in the same domain: the same lists,
        volumes and the like to 1e-10. Neighbors are seeds by their index; N, the number of seeds, is the query itself,
        which may touch its own images in a small periodic domain. Shifts count from where the query lies in the domain.

        ``status`` is OUTSIDE where the domain is not, DUPLICATE at the place of a seed, which ``duplicate_of`` names,
        and EMPTY where heavier seeds leave no cell. At the place of a lighter seed the query has its cell. The GIL is
        released.

        Parameters
        ----------
        queries : (Q, 3) array, as for :meth:`locate`.
        want, list_walls : as for :func:`tessellate`.
        weights : (Q,) numbers, the weights of the queries in a power diagram; of radii their squares. Default: 0.

        Raises
        ------
        ValueError : bad input, or weights where the seeds have none.
        """
        array = _as_queries(queries)
        options = new_options("cpu", 0)
        options.want = as_want(want)
        options.list_walls = bool(list_walls)
        numbers = None if weights is None else as_one_each(weights, "weights", len(array), "queries")
        result = Handle(lib.votess_result_free)
        raise_on_failure(
            lib.votess_diagram_probe(
                self._handle.pointer,
                array.ctypes.data,
                len(array),
                options.want,
                options.list_walls,
                None if numbers is None else numbers.ctypes.data,
                ctypes.byref(result.pointer),
            )
        )
        return Probes(result, implied_words(options))

    def __reduce__(self) -> Any:
        raise TypeError("a Diagram cannot be copied or pickled: make another one of the same points")
