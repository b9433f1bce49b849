"""Lloyd's method: seeds move to the centroids of their cells until both are equal."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, List, Optional, Tuple, Union

import numpy as np

from .._arguments import as_count, as_flag, as_number, counted
from .._call import Progress, showing
from .._domain import DomainLike, as_domain, with_short_forms
from .._input import as_array, as_density, as_points
from ..fit import fit_volumes
from ..pairs import edges_of
from ..tessellator import Tessellator
from .moments import Density, uniform_energy, weighted_centroids

if TYPE_CHECKING:
    import numpy.typing as npt
    from typing_extensions import Unpack

    from .._domain import DomainKeywords
    from .._types import BoolArray, Float64Array
    from ..tessellation import Tessellation

# A seed nearer to a wall than this, in units of the box, moves to its centroid at most.
_MARGIN = 1e-9
_WANT = "volumes,centroids"
# The energy is a difference of moments of the domain up to this ratio, at which it loses nine of sixteen digits.
_MAX_RATIO = 1e6


@dataclass(frozen=True, eq=False)
class Relaxation:
    """The outcome of S steps of :func:`lloyd`. S is smaller than requested if the tolerance was reached."""

    points: Float64Array  #: (N, 3) or (N, 2) float64, the final seeds, not wrapped
    energies: Float64Array  #: (S + 1,) float64, before the first step and after each
    moved: Float64Array  #: (S,) float64, the largest move in each step, in units of the mean spacing
    tessellation: Tessellation  #: the cells of ``points``: volumes, centroids and, outside meshes, faces

    def __repr__(self) -> str:
        first, last = self.energies[[0, -1]]
        return f"<pyvotess.Relaxation of {counted(len(self.points), 'seed')}, {counted(len(self.moved), 'step')}: energy {first:.6g} to {last:.6g}>"


def _as_mask(fixed: Any, count: int) -> BoolArray:
    array = as_array(fixed, "fixed")
    mask = np.zeros(count, dtype=bool)
    if array.dtype == bool:
        if array.shape != (count,):
            raise ValueError(f"fixed has shape {array.shape} for {count} points: a mask must be ({count},)")
        mask[:] = array
    elif array.size:
        if array.dtype.kind not in "iu" or array.ndim != 1:
            raise ValueError(f"fixed has dtype {array.dtype} and shape {array.shape}: give a mask or a list of indices")
        wrong = np.flatnonzero((array < 0) | (array >= count))
        if len(wrong):
            raise ValueError(f"fixed[{wrong[0]}] is {array[wrong[0]]}: indices of {count} points are 0 to {count - 1}")
        mask[array] = True
    return mask


def _inside(t: Tessellation, places: Float64Array) -> BoolArray:
    """Returns which places are inside the domain by more than rounding."""
    edges = edges_of(t)
    shares = (places - (t.box[0] if t.origin is None else t.origin)) @ np.linalg.inv(edges)
    inside: BoolArray = ((np.abs(shares - 0.5) < 0.5 - _MARGIN) | np.array(t.periodic)).all(axis=1)
    normals, ends = t.walls[:, :-1], t.walls[:, -1]
    slack = _MARGIN * np.linalg.norm(normals, axis=1) * np.linalg.norm(edges)
    inside &= (places @ normals.T <= ends - slack).all(axis=1)
    return inside


def _measure(t: Tessellation, places: Float64Array, density: Any, threads: int) -> Tuple[Float64Array, float]:
    """Returns centroids relative to the seeds (N, 3) or (N, 2), NaN without one, and the energy."""
    if density is None:
        return t.centroids - places, uniform_energy(t, places)
    if not callable(density):
        masses = t.masses(density, threads)
        return masses.centroids - places, masses.cost(places)
    return weighted_centroids(t, places, density)


def _moment(t: Tessellation, places: Float64Array) -> float:
    """Returns the sum over cells of the integral of |x|^2 - |x - p|^2, where x is relative to the middle of the box.

    Cells fill a domain without periods, so the energy is a constant less this sum.
    """
    middle = t.box.mean(axis=0)
    sizes, ends = t.volumes, np.where(t.volumes[:, None] > 0, t.centroids, places)
    return float(sizes @ ((places - middle) * (2 * (ends - middle) - (places - middle))).sum(axis=1))


def _share(show: Progress, step: int, count: int) -> Progress:
    """Returns the progress function of one run of ``count``."""
    return lambda fraction: show((step + fraction) / count)


@with_short_forms
def lloyd(
    points: npt.ArrayLike,
    domain: Optional[DomainLike] = None,
    *,
    steps: int = 100,
    density: Union[None, Density, npt.ArrayLike] = None,
    fixed: npt.ArrayLike = (),
    tolerance: float = 0.0,
    over_relaxation: float = 1.0,
    volumes: Optional[npt.ArrayLike] = None,
    normalize: bool = False,
    device: str = "auto",
    threads: int = 0,
    progress: Union[None, bool, Progress] = None,
    **keywords: Unpack[DomainKeywords],
) -> Relaxation:
    """Moves each seed to the centroid of its cell, ``steps`` times, towards a centroidal Voronoi diagram.

    The energy is the sum over all cells of the integral of ``density(x) |x - p|^2``, where p is the seed. It decreases in
    each step up to rounding (Lloyd 1982; Du, Faber, Gunzburger 1999). Without a density, and with one on a grid, it has a
    closed form. With a function, masses, centroids and energies are sums over the tetrahedra between the seed and the triangles of each face,
    by the four-point rule of Hammer and Stroud (1956); in the plane over triangles, by their three-point rule. The rule is exact for polynomials of degree 2, so the centroids of
    a linear density are exact. Its points move with the cells, so the energy decreases up to the error of the rule.

    Parameters
    ----------
    points : (N, 3) or (N, 2) array of real numbers, as for :func:`tessellate`; not changed. Of equal seeds the first has the cell;
        the others stay until it moves away. A seed whose cell has no mass also stays.
    steps : maximum number of steps; 0 returns the energy of the given points.
    density : a function of (K, 3) points, in the plane (K, 2), inside the domain, up to rounding; in a mesh, inside its box. It returns (K,) finite numbers >= 0. It is
        called with about twenty thousand points at a time, wrapped into a periodic domain. Or an array of the shape (nx, ny, nz),
        in the plane (nx, ny): constant in the boxes of a grid over the domain, as for :func:`fit_volumes`; not in a mesh.
        Default: 1 everywhere.
    domain : as for :func:`tessellate`, or its short forms. The default box and the hull, around the initial points, stay fixed. In a mesh the
        centroid is that of the cell's part inside. It may lie outside. Points outside that are kept move to the centroids of
        their cells inside, or stay without one; not with a function, which is read between seeds and faces. Dropped ones stay.
    fixed : (N,) bool, or a list of indices: seeds that do not move. Default: none.
    tolerance : stop when no seed moved farther than this, in units of the mean spacing: the cube root of the volume for
        each seed, in the plane the square root of its area. 0 stops only when nothing moves.
    over_relaxation : factor of the move towards the centroid, above 0 and below 2, for which the energy decreases. 1.8
        needs about six steps instead of ten. A seed that would leave the domain moves to its centroid.
    volumes : (N,) target volumes of the cells, as for :func:`fit_volumes`. Each step then fits the weights of a power
        diagram, from those of the step before. The cells have these volumes, and the energy is the transport cost. With a
        density on a grid they are masses. Not with a function.
    normalize : scale ``volumes`` to the volume of the domain, or to its mass.
    device, threads : as for :func:`tessellate`. Measures use double precision, which a named GPU must support.
    progress : as for :func:`tessellate`, as a fraction of all steps.

    Raises
    ------
    ValueError : bad input, a point outside of the domain, or a bad value of the density; the message names the first.
    MemoryError, VotessError : as for :func:`tessellate`.

    >>> relaxed = vt.lloyd(points, steps=5, box=box)
    >>> bool(relaxed.energies[-1] < relaxed.energies[0])
    True
    """
    array = as_points(points, planar=True).astype(np.float64)
    steps = as_count(steps, "steps", 32)
    moving = ~_as_mask(fixed, len(array))
    tolerance, over_relaxation = as_number(tolerance, "tolerance"), as_number(over_relaxation, "over_relaxation")
    normalize = as_flag(normalize, "normalize")
    if normalize and volumes is None:
        raise ValueError("normalize= goes with volumes= only: without it there is nothing to scale")
    if not 0 <= tolerance < np.inf:
        raise ValueError(f"tolerance is {tolerance}: it must be finite and not negative")
    if not 0 < over_relaxation < 2:
        raise ValueError(f"over_relaxation is {over_relaxation}: it must be more than 0 and less than 2")
    if density is not None and not callable(density):
        if not hasattr(density, "__len__") and not hasattr(density, "__dlpack__"):
            raise TypeError(f"density must be a function of points or an array, not {type(density).__name__}")
        density = as_density(density, array.shape[1])
    if callable(density) and volumes is not None:
        raise ValueError("volumes under a function are not supported: give the density as an array on a grid")
    where = as_domain(domain, keywords)
    if callable(density) and where.outside == "keep":
        raise ValueError("the function is read between seeds and faces, which outside='keep' puts outside: leave one out")
    if density is not None and not callable(density) and where.surface is not None:
        raise ValueError("a density on a grid is not supported in a mesh: give a function, or a box and a density of 0 outside")

    grid = None if callable(density) else density
    want = _WANT if where.surface is not None else "faces," + _WANT
    weights: Optional[Float64Array] = None
    constant: Optional[float] = None  # energy + _moment(), where that needs no polygons
    energies: List[float] = []
    moved: List[float] = []
    with Tessellator(device, threads, precision="double", follow=True) as kept, showing(progress) as show:
        for step in range(steps + 1):
            part = None if show is None else _share(show, step, steps + 1)
            is_last = step == steps or (bool(moved) and moved[-1] <= tolerance)
            by_moment = constant is not None and not is_last
            if volumes is None:
                t = kept.tessellate(array, where, want=_WANT if by_moment else want, progress=part)
            else:
                fit = fit_volumes(
                    array, volumes, where, weights=weights, normalize=normalize, density=grid, want=want, device=device,
                    threads=threads, precision="double", progress=part,
                )  # fmt: skip
                t, weights = fit.tessellation, fit.weights
            if step == 0 and where.vectors is None:
                where = where.replace(box=t.box.ravel(), walls=t.walls)
            extent = float(np.ptp(t.box, axis=0).max(initial=0.0))
            if extent < np.inf and not np.isfinite(float(t.volumes.sum()) * extent * extent):
                raise ValueError("the domain is too large for energies in float64: give lengths in another unit")
            places = t.wrapped_points
            if by_moment and constant is not None:
                way, energy = t.centroids - places, constant - _moment(t, places)
            else:
                way, energy = _measure(t, places, density, threads)
            energies.append(energy)
            if is_last:
                break
            if density is not None and t.volumes.any() and np.isnan(way).all():
                where_read = "at all places where it was read" if callable(density) else "in all cells"
                raise ValueError(f"the density is 0 {where_read}: give one that has mass there")
            if step == 0 and density is None and volumes is None and where.surface is None and not any(t.periodic):
                moment = t.volumes.sum() * float((np.ptp(t.box, axis=0) ** 2).sum())
                constant = energy + _moment(t, places) if moment < _MAX_RATIO * energy else None
            way[~moving | np.isnan(way[:, 0])] = 0
            far = over_relaxation * way
            way = far if over_relaxation <= 1 else np.where(_inside(t, places + far)[:, None], far, way)
            spacing = float(t.volumes.sum() / max(len(t), 1)) ** (1 / array.shape[1]) or 1.0  # nothing moves without cells
            moved.append(float(np.sqrt((way**2).sum(axis=1).max(initial=0)) / spacing))
            array = array + way
            del t  # the next result reuses its memory
    return Relaxation(array, np.array(energies), np.array(moved), t)
