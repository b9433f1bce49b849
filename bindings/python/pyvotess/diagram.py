"""Seeds that stay and are asked many times: cells of points, cells that points would have, fields of what seeds carry."""

from __future__ import annotations

import ctypes
import warnings
from typing import TYPE_CHECKING, Any, Iterable, Literal, Optional, Tuple, Union, overload

import numpy as np

from . import _c_api
from ._c_api import DuplicatesWord, GridWord, NaturalWord, OutsideWord, WantName
from ._call import Handle, Progress, array_of, run, showing
from ._input import Domain, as_one_each, as_points, as_want, as_word
from ._library import lib
from ._run import implied_words, new_options
from ._state import Cells
from .mesh import NaturalCoordinates, Neighbors

if TYPE_CHECKING:
    import numpy.typing as npt


def _as_queries(queries: Any) -> npt.NDArray[np.float64]:
    return np.require(as_points(queries, "queries"), np.float64, ["C_CONTIGUOUS", "ALIGNED"])


def _as_weights(weights: Optional[npt.ArrayLike], queries: int) -> Optional[npt.NDArray[np.float64]]:
    return None if weights is None else as_one_each(weights, "weights", queries, "queries")


def _address(array: Optional[npt.NDArray[Any]]) -> Optional[int]:
    return None if array is None else array.ctypes.data


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
    box, periodic, weights, radii, cell, origin, walls, outside, duplicates, threads, grid_resolution, instructions,
        progress : as for :func:`tessellate`. Queries run on the CPU.

    Each query takes ``progress`` too, as :func:`tessellate` does, and Ctrl-C stops it. A Diagram that was stopped in a
    query answers the next one. Its own progress callback may not ask it.

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
        progress: Union[None, bool, Progress] = None,
    ) -> None:
        array = np.require(as_points(points), np.float64, ["C_CONTIGUOUS", "ALIGNED"])
        options = new_options("cpu", threads, grid_resolution=grid_resolution, instructions=instructions)
        options.duplicates = as_word(duplicates, "duplicates", _c_api.DUPLICATES)
        kept = Domain(box, periodic, weights, radii, cell, origin, walls, outside).fill(options, len(array))
        self._handle = Handle(lib.votess_diagram_free)
        with showing(progress) as shown:
            arguments = (array.ctypes.data, len(array))
            run(lib.votess_diagram_new, arguments, options, ctypes.byref(self._handle.pointer), shown)
        del kept

    def __len__(self) -> int:
        """N, the number of seeds."""
        return int(lib.votess_diagram_size(self._handle.pointer))

    def _ask(self, query: Any, progress: Union[None, bool, Progress], *arguments: Any) -> None:
        """Runs a query of the library on a handle of these seeds that calls ``progress``."""

        def call(options: Any, _out: None) -> int:
            view = Handle(lib.votess_diagram_free)
            status = int(lib.votess_diagram_view(self._handle.pointer, options, ctypes.byref(view.pointer)))
            return status or int(query(view.pointer, *arguments))

        with showing(progress) as shown:
            run(call, (), new_options("cpu", 0), None, shown)

    def locate(
        self, queries: npt.ArrayLike, progress: Union[None, bool, Progress] = None
    ) -> npt.NDArray[np.int32]:
        """In whose cell each query lies.

        queries : (Q, 3) array of finite numbers; in a periodic domain anywhere, they are wrapped without rounding.
        progress : as for :func:`tessellate`.

        Returns (Q,) indices of seeds. ``|x - p|^2 - w`` is least for them, exactly; of several cells that meet in the
        query the lowest index is named; -1 where the domain is not (a wall belongs to it), or where there are no
        seeds. The GIL is released.
        """
        array = _as_queries(queries)
        seeds = np.empty(len(array), np.int32)
        self._ask(lib.votess_diagram_locate, progress, array.ctypes.data, len(array), seeds.ctypes.data)
        return seeds

    def probe(
        self,
        queries: npt.ArrayLike,
        want: Union[str, Iterable[WantName]] = ("neighbors", "volumes"),
        weights: Optional[npt.ArrayLike] = None,
        list_walls: bool = False,
        progress: Union[None, bool, Progress] = None,
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
        want, list_walls, progress : as for :func:`tessellate`.
        weights : (Q,) numbers, the weights of the queries in a power diagram; of radii their squares. Default: 0.

        Raises
        ------
        ValueError : bad input, or weights where the seeds have none.
        """
        array = _as_queries(queries)
        options = new_options("cpu", 0)
        options.want = as_want(want)
        options.list_walls = bool(list_walls)
        numbers = _as_weights(weights, len(array))
        result = Handle(lib.votess_result_free)
        self._ask(
            lib.votess_diagram_probe,
            progress,
            array.ctypes.data,
            len(array),
            options.want,
            options.list_walls,
            _address(numbers),
            ctypes.byref(result.pointer),
        )
        return Probes(result, implied_words(options))

    def natural_neighbors(
        self,
        queries: npt.ArrayLike,
        method: NaturalWord = "sibson",
        at_walls: bool = True,
        gradient: bool = False,
        weights: Optional[npt.ArrayLike] = None,
        progress: Union[None, bool, Progress] = None,
    ) -> NaturalCoordinates:
        """Natural-neighbor coordinates of each query.

        Sibson's (1980) are the shares of the cell that the query would have which each seed had before, also seeds that
        a heavy query buries; Laplace's (Belikov et al. 1997) the area of the face with a neighbor over its distance, over the sum of these. Both sum to
        1 and reproduce linear fields away from walls. Sibson's are smooth but at the seeds; a query on a seed has that one
        alone. Rows are empty outside of the domain and where heavier seeds leave a query no cell.

        Parameters
        ----------
        queries : (Q, 3) array, as for :meth:`locate`.
        at_walls : cells end at walls, as if the seeds had mirror images behind, so that weights sum to 1 there too, but
            linear fields are not reproduced. False: no coordinates where the cell of a query has a wall.
        gradient : the gradient of each weight with respect to the query too; "sibson" only; NaN on seeds.
        weights : (Q,) numbers, the weights of the queries in a power diagram. Default: 0.
        progress : as for :func:`tessellate`.

        The first call with N/2 queries or more, of Sibson's in a box, keeps all Voronoi vertices, some 430 bytes a seed,
        and answers two to three times faster from then on. The GIL is released.

        Raises
        ------
        ValueError : bad input.
        VotessError : UNSUPPORTED where so few seeds repeat that the cell of a query meets its own image.
        """
        array = _as_queries(queries)
        numbers = _as_weights(weights, len(array))
        natural = Handle(lib.votess_natural_free)
        self._ask(
            lib.votess_natural_new,
            progress,
            array.ctypes.data,
            len(array),
            as_word(method, "method", _c_api.NATURAL_METHODS),
            bool(at_walls),
            bool(gradient),
            _address(numbers),
            ctypes.byref(natural.pointer),
        )

        def read(name: str, dtype: Any, columns: int = 0) -> npt.NDArray[Any]:
            return array_of(natural, name, dtype, columns, prefix="votess_natural_")

        return NaturalCoordinates(
            Neighbors(read("indptr", np.int64), read("indices", np.int32)),
            read("weights", np.float64),
            read("gradients", np.float64, 3) if gradient else None,
        )

    @overload
    def interpolate(
        self,
        values: npt.ArrayLike,
        queries: npt.ArrayLike,
        method: NaturalWord = ...,
        at_walls: bool = ...,
        gradient: Literal[False] = ...,
        weights: Optional[npt.ArrayLike] = ...,
        progress: Union[None, bool, Progress] = ...,
    ) -> npt.NDArray[np.float64]: ...

    @overload
    def interpolate(
        self,
        values: npt.ArrayLike,
        queries: npt.ArrayLike,
        method: NaturalWord = ...,
        at_walls: bool = ...,
        *,
        gradient: Literal[True],
        weights: Optional[npt.ArrayLike] = ...,
        progress: Union[None, bool, Progress] = ...,
    ) -> Tuple[npt.NDArray[np.float64], npt.NDArray[np.float64]]: ...

    def interpolate(
        self,
        values: npt.ArrayLike,
        queries: npt.ArrayLike,
        method: NaturalWord = "sibson",
        at_walls: bool = True,
        gradient: bool = False,
        weights: Optional[npt.ArrayLike] = None,
        progress: Union[None, bool, Progress] = None,
    ) -> Union[npt.NDArray[np.float64], Tuple[npt.NDArray[np.float64], npt.NDArray[np.float64]]]:
        """The field at each query: the sum of the seeds' values by the coordinates of :meth:`natural_neighbors`.

        values : (N,) or (N, m) real numbers. The other parameters and errors are those of :meth:`natural_neighbors`.

        Returns (Q,) or (Q, m) float64, NaN where there are no coordinates; with ``gradient`` also its gradient, (Q, 3) or
        (Q, m, 3), per length unit, NaN on seeds too.
        """
        array = _as_queries(queries)
        of_seeds = self._as_values(values)
        numbers = _as_weights(weights, len(array))
        field = np.empty((len(array), *of_seeds.shape[1:]))
        slopes = np.empty((*field.shape, 3)) if gradient else None
        self._ask(
            lib.votess_diagram_interpolate,
            progress,
            of_seeds.ctypes.data,
            of_seeds.shape[1] if of_seeds.ndim == 2 else 1,
            array.ctypes.data,
            len(array),
            as_word(method, "method", _c_api.NATURAL_METHODS),
            bool(at_walls),
            _address(numbers),
            field.ctypes.data,
            _address(slopes),
        )
        return field if slopes is None else (field, slopes)

    def to_grid(
        self,
        values: npt.ArrayLike,
        shape: Union[int, Iterable[int]],
        method: GridWord = "mean",
        project: Optional[int] = None,
        progress: Union[None, bool, Progress] = None,
    ) -> npt.NDArray[np.float64]:
        """What the seeds carry, on a regular grid over the domain.

        Grid cells divide the box along x, y and z, a triclinic one along a, b and c. The volume of one times the sum of
        the grid is the total: with ``mean`` that of values times volumes, with ``dtfe`` all mass, to a relative 1e-12.
        ``mean`` and ``dtfe`` build all cells with their faces first. The GIL is released.

        Parameters
        ----------
        values : (N,) or (N, m) real numbers, of each seed.
        shape : (nx, ny, nz), or one number for all.
        method : ``"mean"``: the average over each grid cell of what is constant in the cells of the seeds. Cells are cut
            by the grid, nothing is sampled. Beyond walls the field is 0. ``"dtfe"``: values are masses, and their density
            is that of the Delaunay tessellation field estimator (Schaap, van de Weygaert 2000), linear in the tetrahedra
            of :meth:`Tessellation.delaunay` and averaged exactly. Duplicates add their mass to the seed that has the
            cell. ``"nearest"``, ``"sibson"``: the value of the cell that holds the center of the grid cell, or what
            :meth:`interpolate` finds there; 0 outside of the domain.
        project : 0, 1 or 2: sum along this axis times the length of a grid cell, as column densities are.
        progress : as for :func:`tessellate`.

        Returns
        -------
        (nx, ny, nz) or (nx, ny, nz, m) float64, without the axis that is projected.

        Warns
        -----
        UserWarning : ``dtfe`` left out the mass of seeds in no tetrahedron: those that were dropped, have no cell, or lie
            at the rim of a domain that is not periodic, where the triangulation is not complete.

        Raises
        ------
        ValueError : bad input.
        """
        of_seeds = self._as_values(values)
        cells = np.array(np.broadcast_to(np.asarray(shape), 3))  # refuses what is neither one number nor three
        if cells.dtype.kind not in "iu" or cells.min() < 1:
            raise ValueError(f"shape is {shape!r}: it must be three whole numbers from 1 on, or one for all")
        if project not in (None, 0, 1, 2):
            raise ValueError(f"project is {project!r}: it must be 0, 1 or 2, or None")
        numbers = [int(n) for n in cells]
        left = [n for axis, n in enumerate(numbers) if axis != project]
        grid = np.empty((*left, *of_seeds.shape[1:]))
        without = ctypes.c_size_t()
        self._ask(
            lib.votess_diagram_to_grid,
            progress,
            of_seeds.ctypes.data,
            of_seeds.shape[1] if of_seeds.ndim == 2 else 1,
            (ctypes.c_size_t * 3)(*numbers),
            as_word(method, "method", _c_api.GRID_METHODS),
            -1 if project is None else project,
            grid.ctypes.data,
            ctypes.byref(without),
        )
        if without.value:
            warnings.warn(f"dtfe left out the mass of {without.value} seeds, of {len(self)}: they are in no tetrahedron", stacklevel=2)
        return grid

    def _as_values(self, values: npt.ArrayLike) -> npt.NDArray[np.float64]:
        array = np.ascontiguousarray(values, np.float64)
        if array.ndim not in (1, 2) or len(array) != len(self):
            raise ValueError(f"values have the shape {array.shape}: it must be ({len(self)},) or ({len(self)}, m)")
        return array

    def __reduce__(self) -> Any:
        raise TypeError("a Diagram cannot be copied or pickled: make another one of the same points")
