"""Cells of JAX arrays, with derivatives by ``jax.grad``, ``jax.vjp`` and ``jax.jacrev``, also under ``jax.jit``."""

from __future__ import annotations

import functools
import pickle
from typing import Any, Dict, List, Optional, Tuple

import numpy as np

from ..export.optional import imported

imported("jax", "pyvotess.autodiff.jax")

import jax
import jax.numpy as jnp

from .._arguments import as_count, shown
from .._domain import DomainLike
from ..tessellation import Tessellation
from . import Measures, forward, vjp

__all__ = ["tessellate"]

_PADDING = np.iinfo(np.int32).min  # of adjacency
_KEPT = 8  # sets of options whose last cells are kept


class _Cells:
    """The cells with fixed options, as a function that JAX differentiates. JAX compiles it once for each shape."""

    def __init__(self, options: bytes, max_rows: Optional[int], columns: int) -> None:
        self.options = pickle.loads(options)
        # Checks the options: JAX would report an error of a callback as one of its own.
        self.none = forward(np.zeros((0, columns)), **self.options)
        self.max_rows = max_rows
        self.last: List[Any] = []  # points, weights and their cells: derivatives follow the cells
        self.call = jax.custom_vjp(self._call)
        self.call.defvjp(self._forward, self._backward)

    def _call(self, points: Any, weights: Any) -> Any:
        return jax.pure_callback(self._measure, self._shapes(points), points, weights, vmap_method="sequential")

    def _forward(self, points: Any, weights: Any) -> Any:
        vjp(self.none)  # refuses domains without an end
        if self.options.get("min_face") or self.options.get("min_area"):
            raise ValueError("derivatives need whole cells: leave out min_face and min_area")
        return self.call(points, weights), (points, weights)

    def _backward(self, inputs: Any, given: Measures) -> Any:
        like = tuple(None if array is None else jax.ShapeDtypeStruct(array.shape, array.dtype) for array in inputs)
        cotangents = given.volumes, given.centroids, given.areas
        return jax.pure_callback(self._differentiate, like, *inputs, *cotangents, vmap_method="sequential")

    def _shapes(self, points: Any) -> Measures:
        def real(*shape: int) -> Any:
            return jax.ShapeDtypeStruct(shape, points.dtype)

        def integer(length: int) -> Any:
            return jax.ShapeDtypeStruct((length,), np.int32)

        count, rows = len(points), self.max_rows
        each = Measures(real(count), real(*points.shape), integer(count), None, None, None)
        return each if rows is None else each._replace(areas=real(rows), adjacency=integer(rows), offsets=integer(count + 1))

    # On the host:

    def _cells(self, *inputs: Any) -> Tessellation:
        arrays: List[Any] = [None if array is None else np.array(array) for array in inputs]  # the memory is JAX's for the call
        last = self.last
        if not last or not all(np.array_equal(a, b) for a, b in zip(arrays, last[0])):
            self.last = last = [arrays, forward(arrays[0], weights=arrays[1], **self.options)]
        t: Tessellation = last[1]
        return t

    def _measure(self, points: Any, weights: Any) -> Measures:
        t, dtype, length = self._cells(points, weights), points.dtype, self.max_rows
        rows = t.rows()
        each = Measures(t.volumes.astype(dtype), t.centroids.astype(dtype), rows.status, None, None, None)
        if length is None:
            return each
        padding = length - len(t.areas)
        if padding < 0:
            raise ValueError(f"max_rows is {length}, but the rows have {len(t.areas)} entries: give a larger one")
        areas = np.pad(t.areas.astype(dtype), (0, padding))
        adjacency = np.pad(rows.adjacency, (0, padding), constant_values=_PADDING)
        return each._replace(areas=areas, adjacency=adjacency, offsets=rows.offsets)

    def _differentiate(self, points: Any, weights: Any, volumes: Any, centroids: Any, areas: Any) -> Tuple[Any, Any]:
        t = self._cells(points, weights)
        found = vjp(t, volumes, centroids, None if areas is None else np.asarray(areas)[: len(t.areas)])
        return found.points.astype(points.dtype), None if weights is None else found.weights.astype(weights.dtype)


_cells_of = functools.lru_cache(_KEPT)(_Cells)


def _constant(options: Dict[str, Any]) -> bytes:
    for name, value in options.items():
        try:
            pickle.dumps(value)
        except Exception as error:
            raise TypeError(f"{name} is {shown(value)}, which cannot be pickled: options are constants here") from error
    return pickle.dumps(options)


def _jax_array(values: Any, name: str) -> Any:
    try:
        return jnp.asarray(values)
    except (TypeError, ValueError, OverflowError) as error:
        raise TypeError(f"{name} is {shown(values)}: give an array of float64 or float32") from error


def tessellate(
    points: Any, domain: Optional[DomainLike] = None, *, weights: Any = None, max_rows: Optional[int] = None, **options: Any
) -> Measures:
    """Returns the measures of the cells as JAX arrays, of the type of ``points``.

    Parameters
    ----------
    points, weights : as for :func:`pyvotess.autodiff.forward`, arrays of float64 or float32.
    domain : as for :func:`pyvotess.autodiff.forward`, a constant.
    max_rows : the length of ``areas`` and ``adjacency``, at least the number of entries of all rows. Padding follows
        the entries: areas 0, and the smallest int32. Default: ``areas``, ``adjacency`` and ``offsets`` are None, because
        JAX needs their length before the run.
    options : as for :func:`pyvotess.autodiff.forward`. They are constants.

    ``jax.pure_callback`` makes the cells on the host, for ``jax.vmap`` one set after another. Wrong arguments raise
    ValueError or TypeError before. Errors that depend on numbers in arrays, such as a point outside of the box, are those
    of JAX with the message of votess. The last cells stay in memory. Wait for results before the program ends, as by
    ``block_until_ready()``: JAX may crash in a callback then.
    """
    points = _jax_array(points, "points")
    weights = None if weights is None else _jax_array(weights, "weights")
    for name, array in (("points", points), ("weights", weights)):
        if array is not None and array.dtype not in (np.float64, np.float32):
            raise ValueError(f"{name} has dtype {array.dtype}: give float64 or float32")
    if points.ndim != 2 or points.shape[1] not in (2, 3):
        raise ValueError(f"points has shape {points.shape}: it must be (N, 3) or (N, 2)")
    if weights is not None and weights.shape != points.shape[:1]:
        raise ValueError(f"weights has shape {weights.shape} for {len(points)} points: it must be ({len(points)},)")
    rows = None if max_rows is None else as_count(max_rows, "max_rows", 31)
    found: Measures = _cells_of(_constant({"domain": domain, **options}), rows, points.shape[1]).call(points, weights)
    return found
