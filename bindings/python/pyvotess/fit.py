"""fit_volumes(): weights that give each cell of a power diagram its volume."""

from __future__ import annotations

import ctypes
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Iterable, Optional, Union

import numpy as np

from . import _c_api
from ._arguments import as_count, as_flag, as_number, counted
from ._arrays import WantName
from ._c_api import ErrorCode, PrecisionWord
from ._call import Handle, Progress, VotessError, last_error, raise_on_failure, run
from ._domain import DomainLike, as_domain, with_short_forms
from ._input import as_density, as_one_each, as_points, fill_weights
from ._library import lib
from ._run import implied_words, new_options
from .tessellation import Tessellation

if TYPE_CHECKING:
    import numpy.typing as npt
    from typing_extensions import Unpack

    from ._domain import DomainKeywords

    Float64Array = npt.NDArray[np.float64]


@dataclass(frozen=True)
class FitSeconds:
    """Seconds of wall clock of a fit."""

    tessellate: float  #: all tessellations, with the one that is returned
    assemble: float  #: derivatives of volumes
    solve: float  #: linear systems
    total: float


@dataclass(frozen=True, eq=False)
class VolumeFit:
    """The outcome of :func:`fit_volumes`. With a density volumes are masses."""

    weights: Float64Array  #: (N,) float64; their mean is that at the start, unless seeds outside are kept
    tessellation: Tessellation  #: the cells with these weights
    residual: float  #: largest abs(volume - target) / target
    steps: int  #: Newton steps
    tessellations: int  #: in all steps, also of fewer points, and the one that is returned
    seconds: FitSeconds

    def __repr__(self) -> str:
        return f"<pyvotess.VolumeFit of {counted(len(self.weights), 'seed')}: {counted(self.steps, 'step')}, residual {self.residual:.1e}>"

    def _repr_html_(self) -> str:
        """Returns a table for notebooks, and a small picture."""
        from .export.html import html_of_fit

        return html_of_fit(self)


class FitError(VotessError):
    """A fit ended before it reached the tolerance. Start from its ``weights`` to continue."""

    def __init__(self, message: str, weights: Float64Array, residual: float, steps: int) -> None:
        super().__init__(message, ErrorCode.NOT_CONVERGED)
        self.weights = weights  #: (N,) the best weights so far; no cell is empty
        self.residual = residual
        self.steps = steps

    def __reduce__(self) -> Any:
        return FitError, (str(self), self.weights, self.residual, self.steps)


@with_short_forms
def fit_volumes(
    points: npt.ArrayLike,
    volumes: npt.ArrayLike,
    domain: Optional[DomainLike] = None,
    *,
    tolerance: float = 1e-9,
    weights: Optional[npt.ArrayLike] = None,
    max_steps: int = 200,
    normalize: bool = False,
    density: Optional[npt.ArrayLike] = None,
    want: Union[str, Iterable[WantName]] = ("neighbors", "volumes"),
    list_walls: bool = False,
    device: str = "auto",
    threads: int = 0,
    precision: PrecisionWord = "single",
    progress: Union[None, bool, Progress] = None,
    **keywords: Unpack[DomainKeywords],
) -> VolumeFit:
    """Returns the power diagram in which the cell of point i has the volume ``volumes[i]``, and its weights.

    The weights are those of optimal transport from the domain to the points: unique up to a constant. Newton steps for the
    cube roots of volumes find them (after Kitagawa, Mérigot, Thibert 2019).

    Parameters
    ----------
    points : (N, 3) array of real numbers, as for :func:`tessellate`; no two are equal. (N, 2) in the plane, whose volumes
        are areas.
    volumes : (N,) positive numbers that sum to the volume of the domain or of the mesh, or to its mass, to a relative 1e-9.
    normalize : scale ``volumes`` to that sum: they are shares of the domain.
    density : (nx, ny, nz) array of numbers >= 0, in the plane (nx, ny): constant in the boxes of a grid over the domain, as
        that of :meth:`Diagram.to_grid`, with x first. Turn an image whose rows run down by ``image[::-1].T``. Then
        ``volumes`` are masses, which :meth:`Tessellation.masses` returns. It may be 0 in places. Not in a mesh.
    tolerance : largest abs(volume - target) / target of the result.
    weights : (N,) weights to start from. Default, and where they leave a cell empty: 0.
    max_steps : maximum number of Newton steps; each takes one tessellation or more.
    domain : as for :func:`tessellate`, or its short forms. In a mesh without weights each point must have a cell. Points outside that are kept
        have cells of their volumes inside; in a periodic domain each must have a cell without weights. Dropped ones have no
        cell, their volumes do not count, and their weights are 0.
    want, list_walls, device, threads, precision : as for :func:`tessellate`, for the tessellation that is returned. The steps
        use double precision.
    progress : as for :func:`tessellate`; the fraction is the share of the digits.

    Ctrl-C in the main thread stops the fit and raises KeyboardInterrupt.

    Raises
    ------
    ValueError : bad input; the message names the first offending index and value.
    FitError : the steps ended before the tolerance; it has the best weights so far.
    MemoryError, VotessError : as for :func:`tessellate`.

    >>> fit = vt.fit_volumes(points, np.full(100, 0.01), box=box)
    >>> print(fit.tessellation.volumes.round(6)[:3])
    [0.01 0.01 0.01]
    """
    array = as_points(points, planar=True).astype(np.float64, order="C", copy=False)
    count = len(array)
    targets = as_one_each(volumes, "volumes", count, "points")
    given = as_domain(domain, keywords)
    options = new_options(
        want=want, list_walls=list_walls, device=device, threads=threads, precision=precision, planar=array.shape[1] == 2
    )
    given._fill(options, array)
    fill_weights(options, weights, None, count)
    wanted = implied_words(options)
    fit_options = _c_api.FitOptions()
    raise_on_failure(lib.votess_fit_options_init(fit_options, ctypes.sizeof(fit_options)))
    fit_options.tolerance = as_number(tolerance, "tolerance")
    fit_options.max_steps = as_count(max_steps, "max_steps", 32)
    fit_options.normalize = as_flag(normalize, "normalize")
    if density is not None:
        grid = fit_options.density = as_density(density, array.shape[1])
        fit_options.density_shape[:] = (*grid.shape, 1)[:3]

    fit = Handle("fit")
    arguments = (array, count, targets, options, fit_options, fit)
    status = run(
        lib.votess_fit_volumes, *arguments, options=options, progress=progress, returned=ErrorCode.NOT_CONVERGED
    )
    if not fit.pointer:
        raise_on_failure(status)
    stats = _c_api.FitStats()
    message = last_error()
    raise_on_failure(lib.votess_fit_get_stats(fit, stats))
    found = fit.array("weights")
    if status == ErrorCode.NOT_CONVERGED:
        raise FitError(message, found.copy(), stats.residual, stats.steps)
    result = Handle("result")
    raise_on_failure(lib.votess_fit_result(fit, result))
    seconds = FitSeconds(stats.seconds_tessellate, stats.seconds_assemble, stats.seconds_solve, stats.seconds_total)
    tessellation = Tessellation(result, array, wanted, given)
    return VolumeFit(found, tessellation, stats.residual, stats.steps, stats.tessellations, seconds)
