"""The domains of pyvoro2: a box, an orthogonal cell that repeats along some axes, and a triclinic one along all."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Dict, Optional, Tuple, Union

import numpy as np

from .._input import as_points, as_vector

if TYPE_CHECKING:
    import numpy.typing as npt

    Float64Array = npt.NDArray[np.float64]
    Int64Array = npt.NDArray[np.int64]

Bounds = Tuple[Tuple[float, float], Tuple[float, float], Tuple[float, float]]
Vector = Tuple[float, float, float]


def _as_bounds(bounds: Any) -> Bounds:
    array = np.asarray(bounds, dtype=np.float64)
    if array.shape != (3, 2) or not np.isfinite(array).all() or not (array[:, 0] < array[:, 1]).all():
        raise ValueError(f"bounds are {bounds!r}: give three finite pairs (low, high) with low < high")
    (x0, x1), (y0, y1), (z0, z1) = array.tolist()
    return ((x0, x1), (y0, y1), (z0, z1))


def _wrap(
    points: Float64Array, edges: Float64Array, periodic: Tuple[bool, bool, bool], eps: Optional[float]
) -> Tuple[Float64Array, Int64Array]:
    """Moves points into 0 <= coordinate < edges[axis, axis]; and how many of each edge that took away.

    ``edges`` is lower triangular. A coordinate within ``eps`` of either side is moved to 0.
    """
    lengths = np.diag(edges)
    if eps is None:
        eps = 1e-12 * float(lengths[list(periodic)].max(initial=0))
    places, shifts = points.copy(), np.zeros(points.shape, dtype=np.int64)
    for _ in range(2):  # a point many cells away is off by a rounding after the first round
        for axis in (2, 1, 0):
            if not periodic[axis]:
                continue
            count = np.floor((places[:, axis] + eps) / lengths[axis])
            places -= count[:, None] * edges[axis]
            places[np.abs(places[:, axis]) < eps, axis] = 0.0
            shifts[:, axis] += count.astype(np.int64)
    return places, shifts


@dataclass(frozen=True)
class Box:
    """A box with walls. ``bounds`` are ((x0, x1), (y0, y1), (z0, z1))."""

    bounds: Bounds

    def __post_init__(self) -> None:
        object.__setattr__(self, "bounds", _as_bounds(self.bounds))

    @classmethod
    def from_points(cls, points: npt.ArrayLike, padding: float = 2.0) -> Box:
        """The bounds of the points, each side moved out by ``padding``."""
        array = as_points(points)
        if not len(array):
            raise ValueError("there are no points to put a box around")
        if not padding >= 0:
            raise ValueError(f"padding is {padding}: it must be at least 0")
        return cls(np.column_stack((array.min(axis=0) - padding, array.max(axis=0) + padding)).tolist())


@dataclass(frozen=True)
class OrthorhombicCell:
    """A box that repeats along the axes that ``periodic`` names by three flags, and has walls across the others."""

    bounds: Bounds
    periodic: Tuple[bool, bool, bool] = (True, True, True)

    def __post_init__(self) -> None:
        object.__setattr__(self, "bounds", _as_bounds(self.bounds))
        flags = tuple(bool(flag) for flag in self.periodic)
        if len(flags) != 3:
            raise ValueError(f"periodic is {self.periodic!r}: give three flags")
        object.__setattr__(self, "periodic", flags)

    @property
    def lattice_vectors(self) -> Tuple[Float64Array, Float64Array, Float64Array]:
        """The three edges."""
        a, b, c = np.diag([high - low for low, high in self.bounds])
        return a, b, c

    def remap_cart(self, points: npt.ArrayLike, *, return_shifts: bool = False, eps: Optional[float] = None) -> Any:
        """(N, 3) the points moved into the cell, low <= x < high; with (N, 3) int64, how many edges that took away."""
        low = np.array(self.bounds)[:, 0]
        places, shifts = _wrap(
            as_points(points).astype(np.float64) - low, np.array(self.lattice_vectors), self.periodic, eps
        )
        return (places + low, shifts) if return_shifts else places + low


@dataclass(frozen=True)
class PeriodicCell:
    """A triclinic cell that repeats along its three edges ``vectors``, of positive determinant, from ``origin``.

    Its internal axes are those in which a lies along x, and b in the plane of x and y. Points are moved to where their
    internal coordinates are in 0 <= x < ax, 0 <= y < by, 0 <= z < cz.
    """

    vectors: Tuple[Vector, Vector, Vector]
    origin: Vector = (0.0, 0.0, 0.0)

    def __post_init__(self) -> None:
        edges = np.asarray(self.vectors, dtype=np.float64)
        if edges.shape != (3, 3) or not np.isfinite(edges).all():
            raise ValueError("vectors must be three vectors of three finite numbers")
        size = float(np.prod(np.linalg.norm(edges, axis=1)))
        if not np.linalg.det(edges) > 1e-12 * size:
            raise ValueError("vectors must have a determinant above 0: they lie in a plane, or are left-handed")
        object.__setattr__(self, "vectors", tuple(map(tuple, edges.tolist())))
        object.__setattr__(self, "origin", tuple(as_vector(self.origin, "origin").tolist()))

    @classmethod
    def from_params(
        cls, bx: float, bxy: float, by: float, bxz: float, byz: float, bz: float, *, origin: Vector = (0.0, 0.0, 0.0)
    ) -> PeriodicCell:
        """The cell of edges (bx, 0, 0), (bxy, by, 0), (bxz, byz, bz)."""
        if not min(bx, by, bz) > 0:
            raise ValueError("bx, by and bz must be above 0")
        return cls(((bx, 0.0, 0.0), (bxy, by, 0.0), (bxz, byz, bz)), origin)

    def _axes(self) -> Float64Array:
        """The internal axes, a row each."""
        a, b, c = np.array(self.vectors)
        x = a / np.linalg.norm(a)
        y = b - (b @ x) * x
        y /= np.linalg.norm(y)
        return np.stack((x, y, np.cross(x, y)))

    def _internal_edges(self) -> Float64Array:
        edges: Float64Array = np.tril(np.array(self.vectors) @ self._axes().T)
        return edges

    def to_internal_params(self) -> Tuple[float, float, float, float, float, float]:
        """(bx, bxy, by, bxz, byz, bz) of the edges in internal axes."""
        (bx, _, _), (bxy, by, _), (bxz, byz, bz) = self._internal_edges().tolist()
        return bx, bxy, by, bxz, byz, bz

    def cart_to_internal(self, points: npt.ArrayLike) -> Float64Array:
        """(N, 3) in internal axes."""
        places: Float64Array = (as_points(points) - np.array(self.origin)) @ self._axes().T
        return places

    def internal_to_cart(self, points_internal: npt.ArrayLike) -> Float64Array:
        """(N, 3) from internal axes."""
        places: Float64Array = as_points(points_internal) @ self._axes() + np.array(self.origin)
        return places

    def remap_internal(
        self, points_internal: npt.ArrayLike, *, return_shifts: bool = False, eps: Optional[float] = None
    ) -> Any:
        """(N, 3) points in internal axes, moved into the cell; with (N, 3) int64, how many edges that took away."""
        points = as_points(points_internal).astype(np.float64)
        places, shifts = _wrap(points, self._internal_edges(), (True, True, True), eps)
        return (places, shifts) if return_shifts else places

    wrap_internal = remap_internal

    def remap_cart(self, points: npt.ArrayLike, *, return_shifts: bool = False, eps: Optional[float] = None) -> Any:
        """(N, 3) the points moved into the cell; with (N, 3) int64, how many edges that took away."""
        places, shifts = self.remap_internal(self.cart_to_internal(points), return_shifts=True, eps=eps)
        return (self.internal_to_cart(places), shifts) if return_shifts else self.internal_to_cart(places)


Domain = Union[Box, OrthorhombicCell, PeriodicCell]


def domain_options(domain: Any) -> Tuple[Dict[str, Any], Float64Array, Tuple[bool, bool, bool]]:
    """The domain as options of tessellate, its edges, a row each, and along which of them it repeats.

    ``domain`` may be one of pyvoro2 too.
    """
    if hasattr(domain, "vectors"):
        edges = np.array(domain.vectors)
        return {"cell": edges, "origin": domain.origin}, edges, (True, True, True)
    if not hasattr(domain, "bounds"):
        raise TypeError(f"domain is a {type(domain).__name__}: give a Box, an OrthorhombicCell or a PeriodicCell")
    bounds = np.array(domain.bounds)
    periodic = getattr(domain, "periodic", (False, False, False))
    return {"box": bounds.T, "periodic": periodic}, np.diag(bounds[:, 1] - bounds[:, 0]), periodic
