"""Queries among fixed seeds: the cell of a point, the cell of an added point, interpolated fields."""

from __future__ import annotations

import ctypes
import warnings
from typing import TYPE_CHECKING, Any, Iterable, Literal, Optional, Tuple, Union, overload

import numpy as np

from . import _c_api
from ._arguments import as_axis, as_each_axis, as_flag, as_word, counted
from ._arrays import WantName
from ._c_api import BeyondWord, DuplicatesWord, GridWord, NaturalWord
from ._call import Handle, Progress, run
from ._domain import Domain, DomainLike, as_domain, with_short_forms
from ._input import as_float64_or_float32, as_one_each, as_points, fill_weights
from ._library import lib
from ._run import implied_words, new_options
from ._state import Cells
from .mesh import NaturalCoordinates, Neighbors
from .rays import RayCells

if TYPE_CHECKING:
    import numpy.typing as npt
    from typing_extensions import Unpack

    from ._domain import DomainKeywords


def _as_weights(weights: Optional[npt.ArrayLike], queries: int) -> Optional[npt.NDArray[np.float64]]:
    return None if weights is None else as_one_each(weights, "weights", queries, "queries")


def _bounds(domain: Domain, points: npt.NDArray[np.float64]) -> npt.NDArray[np.float64]:
    """Returns the finite ends of the domain, and where it has none, of the mesh or the points."""
    around = points if domain.surface is None else domain.surface[0]
    if len(around) == 0:
        return np.zeros((2, points.shape[1]))
    ends, box = np.stack((around.min(axis=0), around.max(axis=0))), domain.limits
    return ends if box is None else np.where(np.isfinite(box), box, ends)


class Probes(Cells):
    """The cells of N queries, in their order, see :meth:`Diagram.probe`.

    Arrays are those of a :class:`Tessellation`, also read-only. Each cell is computed among the seeds alone, so cells of
    close queries overlap, and methods for a whole diagram are missing.
    """

    def __repr__(self) -> str:
        wanted = ", ".join(self.wanted) or "status only"
        return f"<pyvotess.Probes of {len(self)} queries in a {self._where()}: {wanted}>"


class Diagram:
    """A sorted, immutable set of seeds for queries. Cells are not computed. Any number of threads may query it.

    Parameters
    ----------
    points : (N, 3) array of real numbers, as for :func:`tessellate`; copied. Or (N, 2): then queries, rays and gradients
        have two components too, the cells of probes are polygons, and grids have two axes.
    domain : as for :func:`tessellate`, or its short forms. Default: all of space. A closed mesh cuts the domain: places outside have no answers,
        rays have their parts inside, and a cell of :meth:`probe` is its part inside. The surface is inside.
        :meth:`natural_neighbors` and :meth:`interpolate` answer as without the mesh, and grids are 0 outside.
    weights, radii, duplicates, threads, grid_resolution, instructions, progress : as for :func:`tessellate`. Queries run on
        the CPU.

    Each query has a ``progress`` too, and Ctrl-C stops it. A Diagram stays usable after a stopped query. A progress
    callback must not query the Diagram that calls it.

    Raises
    ------
    ValueError : bad input; the message names the first offending index and value.

    >>> d = vt.Diagram(points, box=box)
    >>> d
    <pyvotess.Diagram of 100 seeds in a box (0, 0, 0) to (1, 1, 1)>
    """

    @with_short_forms
    def __init__(
        self,
        points: npt.ArrayLike,
        domain: Optional[DomainLike] = None,
        *,
        weights: Optional[npt.ArrayLike] = None,
        radii: Optional[npt.ArrayLike] = None,
        duplicates: DuplicatesWord = "merge",
        threads: int = 0,
        grid_resolution: int = 0,
        instructions: str = "",
        progress: Union[None, bool, Progress] = None,
        **keywords: Unpack[DomainKeywords],
    ) -> None:
        array = np.require(as_points(points, planar=True), np.float64, ["C_CONTIGUOUS", "ALIGNED"])
        options = new_options(
            device="cpu", threads=threads, grid_resolution=grid_resolution, instructions=instructions,
            duplicates=duplicates, planar=array.shape[1] == 2,
        )  # fmt: skip
        given = as_domain(domain, keywords)
        given._fill(options, array)
        fill_weights(options, weights, radii, len(array))
        self._handle = Handle("diagram")
        arguments = (array, len(array), options, self._handle)
        run(lib.votess_diagram_new, *arguments, options=options, progress=progress)
        self._domain = given
        self._where = given._text() if given._has_ends else given._text().replace("default box", "domain without end")
        #: Corners of what a picture shows: the domain, or where the seeds are.
        self._shown = _bounds(given, array)

    def __repr__(self) -> str:
        return f"<pyvotess.Diagram of {counted(len(self), 'seed')} in a {self._where}>"

    def _repr_html_(self) -> str:
        """Returns a table for notebooks, and a small picture."""
        from .export.html import html_of_diagram

        return html_of_diagram(self)

    def __len__(self) -> int:
        """N, the number of seeds."""
        return int(lib.votess_diagram_size(self._handle))

    @property
    def planar(self) -> bool:
        """Whether seeds and queries have two components."""
        return bool(lib.votess_diagram_planar(self._handle))

    @property
    def domain(self) -> Domain:
        """The domain, for other calls; without one all of space, or in the plane all of the plane.

        >>> d.domain == vt.Domain.box(box)
        True
        """
        given = self._domain
        return given if given._has_ends or len(given.walls) or given.surface is not None else given.replace(box="none")

    @property
    def _dimensions(self) -> int:
        return 2 if self.planar else 3

    def _as_queries(self, queries: Any, name: str = "queries") -> npt.NDArray[np.float64]:
        array = as_points(queries, name, planar=True)
        if array.shape[1] != self._dimensions:
            count = "Q" if name == "queries" else "R"
            raise ValueError(f"{name} has shape {array.shape}: the seeds need ({count}, {self._dimensions})")
        return np.require(array, np.float64, ["C_CONTIGUOUS", "ALIGNED"])

    def _ask(self, query: Any, progress: Union[None, bool, Progress], *arguments: Any) -> None:
        """Runs a query of the library, which calls ``progress``."""

        def call(options: Any) -> int:
            view = Handle("diagram")
            return int(lib.votess_diagram_view(self._handle, options, view) or query(view, *arguments))

        options = new_options(device="cpu")
        run(call, options, options=options, progress=progress)

    def locate(
        self, queries: npt.ArrayLike, progress: Union[None, bool, Progress] = None
    ) -> npt.NDArray[np.int32]:
        """Returns (Q,) int32, the seed whose cell contains each query, exactly: ``|x - p|^2 - w`` is smallest for it.

        Of several cells that meet in the query, the lowest index is returned. -1 outside of the domain, to which walls
        belong, and without seeds. The GIL is released.

        queries : (Q, 3) array of finite numbers. In a periodic domain they are wrapped without rounding.
        progress : as for :func:`tessellate`.

        >>> d.locate(points[:3]).tolist()
        [0, 1, 2]
        """
        array = self._as_queries(queries)
        seeds = np.empty(len(array), np.int32)
        self._ask(lib.votess_diagram_locate, progress, array, len(array), seeds)
        return seeds

    def trace(
        self,
        origins: npt.ArrayLike,
        directions: npt.ArrayLike,
        lengths: Optional[npt.ArrayLike] = None,
        middles: bool = False,
        progress: Union[None, bool, Progress] = None,
    ) -> RayCells:
        """Returns the seeds whose cells each ray passes, in order, and its length in each.

        A ray ends after its length, or at a wall of the domain. One that begins outside of the domain has no cells. A
        periodic domain repeats, so a seed may appear several times. Cells and their order are exact: a ray through an
        edge or a vertex passes each cell where it has a length once. In a common face or edge of cells it passes the one
        of lowest index. Lengths sum to the ray's length inside the domain, to a relative 1e-13.

        The first call computes the neighbors of all cells, and keeps about 260 bytes a seed. The GIL is released.

        Parameters
        ----------
        origins, directions : (R, 3) arrays of finite numbers.
        lengths : (R,) numbers, or one for all. Infinity is allowed where a wall ends the ray. Default: the lengths of
            the directions, so that rays end at ``origins + directions``.
        middles : also compute the middles of pieces, which gradients in :meth:`RayCells.integrate` need. They triple the
            memory of the answer.
        progress : as for :func:`tessellate`.

        Raises
        ------
        ValueError : bad input; a direction of length 0; an infinite ray that no wall ends.

        >>> rays = d.trace([(0.1, 0.5, 0.5)], [(0.8, 0, 0)])
        >>> len(rays.seeds), round(float(rays.lengths.sum()), 6)
        (8, 0.8)
        """
        start, along = self._as_queries(origins, "origins"), self._as_queries(directions, "directions")
        if len(along) != len(start):
            raise ValueError(f"{len(start)} origins, but {len(along)} directions: give one for each ray")
        given = np.linalg.norm(along, axis=1) if lengths is None else as_float64_or_float32(lengths, "lengths")
        if given.ndim == 0:
            given = np.full(len(start), given)
        numbers = as_one_each(given, "lengths", len(start), "rays")
        with_middles = as_flag(middles, "middles")
        rays = Handle("rays")
        self._ask(lib.votess_rays_new, progress, start, along, numbers, len(start), with_middles, rays)
        return RayCells(
            rays.array("offsets"),
            rays.array("seeds"),
            rays.array("lengths"),
            rays.array("middles") if with_middles else None,
            len(self),
        )

    def probe(
        self,
        queries: npt.ArrayLike,
        want: Union[str, Iterable[WantName]] = ("neighbors", "volumes"),
        weights: Optional[npt.ArrayLike] = None,
        list_walls: bool = False,
        progress: Union[None, bool, Progress] = None,
    ) -> Probes:
        """Returns the cell that each query would have if it alone were added to the seeds.

        Row q equals that of :func:`tessellate` for query q as the last of the seeds, in the same domain: equal lists, and
        volumes and other numbers to 1e-10. Neighbors are indices of seeds. N, the number of seeds, is the query itself,
        which may touch its own images in a small periodic domain. Shifts count from the wrapped query.

        ``status`` is OUTSIDE outside of the box and its walls, also with ``outside="keep"``; DUPLICATE at the place of a seed,
        which ``duplicate_of`` names; EMPTY where heavier seeds leave no cell. At the place of a lighter seed the query takes its cell. The GIL is
        released.

        Parameters
        ----------
        queries : (Q, 3) array, as for :meth:`locate`.
        want, list_walls, progress : as for :func:`tessellate`.
        weights : (Q,) numbers, the weights of the queries in a power diagram; of radii their squares. Default: 0.

        Raises
        ------
        ValueError : bad input, or weights where the seeds have none.

        >>> added = d.probe([(0.5, 0.5, 0.5)])
        >>> bool((added.neighbors[0] >= 0).all()), len(added)
        (True, 1)
        """
        array = self._as_queries(queries)
        options = new_options(device="cpu", want=want, list_walls=list_walls)
        numbers = _as_weights(weights, len(array))
        result = Handle("result")
        arguments = (array, len(array), options.want, options.list_walls, numbers, result)
        self._ask(lib.votess_diagram_probe, progress, *arguments)
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
        """Returns the natural-neighbor coordinates of each query.

        Sibson's (1980) are shares of the query's cell: the part that each seed's cell had before, also of seeds that a
        heavy query buries. Laplace's (Belikov et al. 1997) are areas of faces over distances of neighbors, normalized.
        Both sum to 1 and reproduce linear fields away from walls. Sibson's are smooth except at the seeds. A query on a
        seed has that seed alone. Rows are empty outside of the domain, and where heavier seeds leave no cell.

        Parameters
        ----------
        queries : (Q, 3) array, as for :meth:`locate`.
        at_walls : without effect in all of space, where rows are empty outside of the convex hull. True: cells end at walls, as if the seeds had mirror images. Weights sum to 1, but linear fields are
            not reproduced there. False: empty rows where the cell of a query has a wall.
        gradient : also compute the gradient of each weight by the query; "sibson" only; NaN on seeds.
        weights : (Q,) numbers, the weights of the queries in a power diagram. Default: 0.
        progress : as for :func:`tessellate`.

        The first call of Sibson's method in a box with N/2 or more queries stores all Voronoi vertices, about 430 bytes
        for each seed. From then on it is two to three times faster. The GIL is released.

        Raises
        ------
        ValueError : bad input.
        VotessError : UNSUPPORTED in a periodic domain with so few seeds that the cell of a query meets its own image.

        >>> shares = d.natural_neighbors([(0.5, 0.5, 0.5)])
        >>> round(float(shares.weights.sum()), 6)
        1.0
        """
        array = self._as_queries(queries)
        numbers = _as_weights(weights, len(array))
        with_gradient = as_flag(gradient, "gradient")
        natural = Handle("natural")
        how = (as_word(method, "method", _c_api.NATURAL_METHODS), as_flag(at_walls, "at_walls"), with_gradient)
        self._ask(lib.votess_natural_new, progress, array, len(array), *how, numbers, natural)
        return NaturalCoordinates(
            Neighbors(natural.array("indptr"), natural.array("indices")),
            natural.array("weights"),
            natural.array("gradients") if with_gradient else None,
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
        beyond: BeyondWord = ...,
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
        beyond: BeyondWord = ...,
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
        beyond: BeyondWord = "nan",
    ) -> Union[npt.NDArray[np.float64], Tuple[npt.NDArray[np.float64], npt.NDArray[np.float64]]]:
        """Returns the field at each query: the seeds' values weighted by the coordinates of :meth:`natural_neighbors`.

        The result is (Q,) or (Q, m) float64, NaN without coordinates: without a box outside of the convex hull of the
        seeds. ``beyond="nearest"`` takes the value of the nearest seed there, with gradient 0. Values that are NaN stay NaN.
        With ``gradient`` the gradient follows, (Q, 3) or (Q, m, 3), per length unit, also NaN on seeds; 2 instead of 3 in
        two dimensions.

        values : (N,) or (N, m) real numbers. The other parameters and errors are those of :meth:`natural_neighbors`.

        >>> d.interpolate(points @ (1, 2, 3), [(0.5, 0.5, 0.5)]).round(6)  # linear fields are reproduced
        array([3.])
        """
        array = self._as_queries(queries)
        of_seeds = self._as_values(values)
        as_word(beyond, "beyond", dict.fromkeys(("nan", "nearest")))
        numbers = _as_weights(weights, len(array))
        asked = of_seeds
        if beyond == "nearest":  # a column of ones is NaN exactly where there are no coordinates
            asked = np.column_stack((of_seeds, np.ones(len(of_seeds))))
        field = np.empty((len(array), *asked.shape[1:]))
        slopes = np.empty((*field.shape, self._dimensions)) if as_flag(gradient, "gradient") else None
        given = (asked, asked.shape[1] if asked.ndim == 2 else 1, array, len(array))
        how = (as_word(method, "method", _c_api.NATURAL_METHODS), as_flag(at_walls, "at_walls"))
        self._ask(lib.votess_diagram_interpolate, progress, *given, *how, numbers, field, slopes)
        if beyond == "nearest":
            unknown = np.flatnonzero(np.isnan(field[:, -1]))
            nearest = self.locate(array[unknown], progress)
            unknown, nearest = unknown[nearest >= 0], nearest[nearest >= 0]
            field[unknown] = asked[nearest]
            if slopes is not None:
                slopes[unknown] = 0
                shape = (len(field), *of_seeds.shape[1:], self._dimensions)
                slopes = np.ascontiguousarray(slopes[:, :-1]).reshape(shape)
            field = np.ascontiguousarray(field[:, :-1]).reshape(len(field), *of_seeds.shape[1:])
        return field if slopes is None else (field, slopes)

    def to_grid(
        self,
        values: npt.ArrayLike,
        shape: Union[int, Iterable[int]],
        method: GridWord = "mean",
        project: Optional[int] = None,
        progress: Union[None, bool, Progress] = None,
    ) -> npt.NDArray[np.float64]:
        """Returns a field of the seeds' values on a regular grid over the domain.

        Grid cells divide the box along x, y and z, a triclinic box along a, b and c. The sum of the grid times the volume
        of a grid cell is the total, to a relative 1e-12: of values times volumes with ``mean``, of all mass with ``dtfe``.
        With ``outside="keep"`` tetrahedra may reach beyond the box, and the mass that lies there is not in the grid.
        ``mean`` and ``dtfe`` compute all cells with faces first. The GIL is released.

        Parameters
        ----------
        values : (N,) or (N, m) real numbers of the seeds.
        shape : (nx, ny, nz), in two dimensions (nx, ny), or one number for all.
        method : ``"mean"``: exact average over each grid cell of a field that is constant in the cells of the seeds.
            The field is 0 beyond walls. ``"dtfe"``: values are masses, and the field is their density by the Delaunay
            tessellation field estimator (Schaap, van de Weygaert 2000), linear in the tetrahedra or triangles
            of :meth:`Tessellation.delaunay` and averaged exactly. Duplicates add their mass to the seed that keeps the
            cell. ``"nearest"``, ``"sibson"``: the value of the nearest seed, or that of :meth:`interpolate`, at the
            center of the grid cell; 0 outside of the domain.
        project : 0, 1 or 2: sum along this axis times the length of a grid cell, a column density.
        progress : as for :func:`tessellate`.

        Returns
        -------
        (nx, ny, nz) or (nx, ny, nz, m) float64, without the projected axis. In two dimensions without nz.

        Warns
        -----
        UserWarning : ``dtfe`` omitted the mass of seeds in no tetrahedron: dropped seeds, seeds without a cell, and seeds
            at the rim of a domain without period, where the triangulation is incomplete.

        Raises
        ------
        ValueError : bad input.

        >>> grid = d.to_grid(np.ones(100), (8, 8, 8), "dtfe")
        >>> grid.shape
        (8, 8, 8)
        """
        of_seeds = self._as_values(values)
        numbers = as_each_axis(shape, "shape", self._dimensions)
        axis_of_sum = as_axis(project, "project")
        left = [n for axis, n in enumerate(numbers) if axis != axis_of_sum]
        grid = np.empty((*left, *of_seeds.shape[1:]))
        without = ctypes.c_size_t()
        given = (of_seeds, of_seeds.shape[1] if of_seeds.ndim == 2 else 1, (ctypes.c_size_t * 3)(*(*numbers, 1)[:3]))
        how = (as_word(method, "method", _c_api.GRID_METHODS), axis_of_sum)
        self._ask(lib.votess_diagram_to_grid, progress, *given, *how, grid, without)
        if without.value:
            warnings.warn(f"dtfe omitted the mass of {without.value} of {len(self)} seeds, which are in no {'triangle' if self._dimensions == 2 else 'tetrahedron'}", stacklevel=2)
        return grid

    def _as_values(self, values: npt.ArrayLike) -> npt.NDArray[np.float64]:
        array = as_float64_or_float32(values, "values").astype(np.float64, copy=False)
        if array.ndim not in (1, 2) or len(array) != len(self) or array.shape[1:] == (0,):
            raise ValueError(f"values has shape {array.shape}: give ({len(self)},) or ({len(self)}, m)")
        return array

    def __reduce__(self) -> Any:
        raise TypeError("a Diagram cannot be copied or pickled: create another one with the same points")
