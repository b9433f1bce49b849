"""Derivatives of volumes, centroids and areas by points and weights, on NumPy arrays.

``pyvotess.autodiff.jax`` and ``pyvotess.autodiff.torch`` wrap them for those packages.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, NamedTuple, Optional

import numpy as np

from .._arguments import shown
from .._domain import SHORT_FORMS, DomainLike, take_domain
from .._input import as_float64_or_float32
from .._motion import Motion, blocks, dot, motion_of, unscaled
from ..tessellation import Tessellation
from ..tessellator import tessellate

if TYPE_CHECKING:
    import numpy.typing as npt

    Float64Array = npt.NDArray[np.float64]

__all__ = ["Gradients", "Measures", "forward", "vjp"]

_WANT = "volumes,centroids,areas,faces"


class Gradients(NamedTuple):
    """The derivatives of a number by the points and weights."""

    points: Float64Array  #: (N, 3) float64, in the plane (N, 2)
    weights: Float64Array  #: (N,) float64; in a Voronoi diagram all weights are 0


class Measures(NamedTuple):
    """The cells as arrays of JAX or PyTorch. The last two are those of :class:`pyvotess.Rows`."""

    volumes: Any  #: (N,)
    centroids: Any  #: (N, 3), in the plane (N, 2); NaN for a seed without a cell
    status: Any  #: (N,) int32
    areas: Any  #: one for each entry of ``adjacency``
    adjacency: Any  #: (offsets[N],) int32
    offsets: Any  #: (N + 1,) int32


def forward(
    points: npt.ArrayLike, domain: Optional[DomainLike] = None, *, weights: Optional[npt.ArrayLike] = None, **options: Any
) -> Tessellation:
    """Returns the cells with the arrays that :func:`vjp` reads: volumes, centroids, areas and faces.

    ``domain``, or a short form in ``options``, is a box or cell of numbers: the default box and the hull move with the
    points. The other ``options`` are those of :func:`pyvotess.tessellate`. ``precision`` is "double" by default.

    >>> measures = vt.autodiff.forward(points, box=box)
    >>> round(float(measures.volumes.sum()), 6)
    1.0
    """
    where = take_domain({"domain": domain, **options})
    if where.vectors is None and where.limits is None:
        word = where._keywords().get("box")
        raise ValueError(f"box is {word!r}, which has no fixed ends: give a domain, box or cell of numbers")
    instead = {
        "radii": "give weights, the squares of the radii",
        "want": "give want to tessellate(), then call vjp()",
        "only": "the cells of some points do not form a diagram",
    }
    for name in instead.keys() & options.keys():
        raise ValueError(f"{name} is not an option of derivatives: {instead[name]}")
    options.setdefault("precision", "double")
    others = {name: value for name, value in options.items() if name not in SHORT_FORMS}
    return tessellate(points, where, weights=weights, want=_WANT, **others)


def _cotangent(values: Any, name: str, array: npt.NDArray[Any]) -> Float64Array:
    given = as_float64_or_float32(values, name)
    if given.shape != array.shape:
        raise ValueError(f"{name} has shape {given.shape}: it must be {array.shape}, that of the array of the result")
    return given.astype(np.float64, copy=False)


def _volumes(t: Tessellation, places: Float64Array, motion: Motion) -> Float64Array:
    """Returns the (N,) volumes in the unit of the motion. They come from the faces where float64 does not hold the result's."""
    unit, size = motion.unit, places.shape[1]
    if 2.0**-300 < unit < 2.0**300:
        volumes: Float64Array = t.volumes / unit**size
        return volumes
    height = np.zeros(len(motion.i))  # of the pyramid over a face, times the area
    for part, block in blocks(t, places, motion, np.arange(len(motion.i))):
        height[part] = block.size * dot(block.normal, block.position.take(block.indptr[:-1], axis=1))
    volumes = np.bincount(motion.i, height, len(t)) / size
    return volumes


def vjp(
    t: Tessellation,
    volumes: Optional[npt.ArrayLike] = None,
    centroids: Optional[npt.ArrayLike] = None,
    areas: Optional[npt.ArrayLike] = None,
) -> Gradients:
    """Returns the product of the derivatives of ``t`` with vectors, from the left.

    It is the gradient of ``(volumes * t.volumes).sum() + (centroids * t.centroids).sum() + (areas * t.areas).sum()``, with
    the arguments as constants.

    Parameters
    ----------
    t : from :func:`forward`, or any result with "faces" in want, and "volumes,centroids" for centroids.
    volumes : (N,) the derivatives of a number by ``t.volumes``. Default: 0.
    centroids : (N, 3) those by ``t.centroids``; ignored where a seed has no cell. In the plane (N, 2).
    areas : those by ``t.areas``, one for each entry of ``t.neighbors.indices``.

    The derivatives are in closed form. Walls and the vectors of a periodic domain are fixed. Where more cells meet than
    in general position, as in a lattice, areas have no derivative; those of the present polygons are returned.

    Raises
    ------
    ValueError : other shapes; results with ``only`` or ``min_face``, or with cells that reach infinity.
    AttributeError : ``t`` lacks an array, as in a mesh.

    >>> cells = vt.tessellate(points, box=box, want="faces,volumes")
    >>> gradients = vt.autodiff.vjp(cells, volumes=cells.volumes)
    >>> gradients.points.shape
    (100, 3)
    """
    if not isinstance(t, Tessellation):
        raise TypeError(f"t is {shown(t)}: give the result of forward() or tessellate()")
    t._check_whole()
    t._require_end("vjp()")
    t._require_whole_faces("vjp()")
    places = t.wrapped_points
    motion = motion_of(t, places)
    i, j = motion.i, motion.j
    unit, size = motion.unit, places.shape[1]  # the number is a function of lengths in this unit
    # The integral over each face of a function of the place, and of it times the place, give its product with the motion.
    field = np.zeros(len(i))
    moment = np.zeros_like(motion.vector)

    if volumes is not None or centroids is not None:
        # The sum changes by the integral of constant + slope.y times the motion of each face of a cell.
        constant, slope = np.zeros(len(t)), np.zeros_like(places.T)
        if volumes is not None:
            constant = unscaled(_cotangent(volumes, "volumes", t.volumes), unit, size - 1)
        if centroids is not None:
            volume = _volumes(t, places, motion)
            has_cell = volume > 0
            slope = _cotangent(centroids, "centroids", t.centroids).T / np.where(has_cell, volume, 1)
            constant = constant - dot(slope, np.where(has_cell, (t.centroids - places).T / unit, 0))
        # Two cells have the face, with opposite motions: their difference, once. A seed has its images from both sides.
        once = np.flatnonzero(j >= i)
        cell, neighbor = i[once], j[once]
        has_two = cell != neighbor
        slope_beyond = np.where(has_two, slope.take(neighbor, axis=1), 0)
        slopes = slope.take(cell, axis=1) - slope_beyond
        constants = constant[cell] - np.where(has_two, constant[neighbor], 0)
        constants += dot(slope_beyond, motion.vector.take(once, axis=1))
        for part, block in blocks(t, places, motion, once):
            of_simplices = slopes[:, part].take(block.face, axis=1), constants[part].take(block.face)
            values = [dot(of_simplices[0], corner) + of_simplices[1] for corner in block.corners]
            count, total = len(values), sum(values)
            field[once[part]] = block.sums(block.parts * total / count)
            product = sum((value + total) * corner for value, corner in zip(values, block.corners))
            moment[:, once[part]] = block.sums(block.parts / (count * (count + 1)) * product)

    if areas is not None:
        given = unscaled(_cotangent(areas, "areas", t.faces.indptr[:-1]), unit, size - 2)
        for part, block in blocks(t, places, motion, np.arange(len(i))):
            count = part.stop - part.start
            for row, face, at, much in block.rims():
                value = given[part].take(row) * much
                field[part] += np.bincount(face, value, count)
                for axis, place in enumerate(at):
                    moment[axis, part] += np.bincount(face, value * place, count)

    field *= motion.per_distance
    moment *= motion.per_distance
    is_seed = j >= 0

    def gathered(of_cell: Float64Array, of_neighbor: Float64Array) -> Any:
        """Returns (N,) sums over the faces of cells and of their neighbors."""
        return np.bincount(i, of_cell, len(t)) + np.bincount(j[is_seed], of_neighbor[is_seed], len(t))

    by_points = [gathered(*pushed) for pushed in zip(moment, field * motion.vector - moment)]
    return Gradients(np.stack(by_points, axis=1), gathered(0.5 * field, -0.5 * field) / unit)
