"""Cells of JAX arrays, with derivatives by ``jax.grad``, ``jax.vjp`` and ``jax.jacrev``, also under ``jax.jit``."""

from __future__ import annotations

from typing import Any, List, Optional, Tuple

import jax
import jax.numpy as jnp
import numpy as np

from ..tessellation import Tessellation
from . import Measures, forward, vjp

__all__ = ["tessellate"]

_PADDING = np.iinfo(np.int32).min


def tessellate(points: Any, weights: Any = None, *, max_rows: Optional[int] = None, **options: Any) -> Measures:
    """Returns the measures of the cells as JAX arrays, of the type of ``points``.

    points, weights : as for :func:`pyvotess.autodiff.forward`. Integers are not differentiable and refused.
    max_rows : the length of ``areas`` and ``adjacency``, at least the number of entries of all rows. What follows the
        entries is padding: areas 0 and the smallest int32. Default: both, and ``offsets``, are None, because JAX needs
        their length before it runs.
    options : as for :func:`pyvotess.autodiff.forward`.

    The cells are made on the host by ``jax.pure_callback``. ``jax.vmap`` makes them one after another.
    """
    points = jnp.asarray(points)
    weights = None if weights is None else jnp.asarray(weights)
    for name, array in (("points", points), ("weights", weights)):
        if array is not None and not jnp.issubdtype(array.dtype, jnp.floating):
            raise ValueError(f"{name} has dtype {array.dtype}: give float64 or float32")
    kept: List[Any] = []  # the inputs and cells of the last call: derivatives follow it

    def cells(*inputs: Any) -> Tessellation:
        arrays = [None if array is None else np.array(array) for array in inputs]
        if not kept or not all(np.array_equal(a, b) for a, b in zip(arrays, kept[0])):
            kept[:] = arrays, forward(*arrays, **options)
        found: Tessellation = kept[1]
        return found

    def padded(values: Any, padding: Any) -> Any:
        if max_rows is None:
            return None
        if len(values) > max_rows:
            raise ValueError(f"max_rows is {max_rows}, but the rows have {len(values)} entries: give a larger one")
        return np.concatenate((values, np.full(max_rows - len(values), padding, values.dtype)))

    def measure(points: Any, weights: Any) -> Measures:
        t, dtype = cells(points, weights), points.dtype
        rows = t.rows()
        return Measures(
            volumes=t.volumes.astype(dtype),
            centroids=t.centroids.astype(dtype),
            status=rows.status,
            areas=padded(t.areas.astype(dtype), 0) if max_rows is not None else None,
            adjacency=padded(rows.adjacency, _PADDING),
            offsets=None if max_rows is None else rows.offsets,
        )

    def differentiate(points: Any, weights: Any, volumes: Any, centroids: Any, areas: Any) -> Tuple[Any, Any]:
        t = cells(points, weights)
        found = vjp(t, volumes, centroids, None if areas is None else np.asarray(areas)[: len(t.areas)])
        return found.points.astype(points.dtype), None if weights is None else found.weights.astype(weights.dtype)

    def shapes(points: Any) -> Measures:
        count = len(points)

        def real(*shape: int) -> Any:
            return jax.ShapeDtypeStruct(shape, points.dtype)

        def integer(length: int) -> Any:
            return jax.ShapeDtypeStruct((length,), np.int32)

        each = Measures(real(count), real(*points.shape), integer(count), None, None, None)
        if max_rows is None:
            return each
        return each._replace(areas=real(max_rows), adjacency=integer(max_rows), offsets=integer(count + 1))

    @jax.custom_vjp
    def call(points: Any, weights: Any) -> Any:
        return jax.pure_callback(measure, shapes(points), points, weights, vmap_method="sequential")

    def call_forward(points: Any, weights: Any) -> Any:
        return call(points, weights), (points, weights)

    def call_backward(inputs: Any, given: Measures) -> Any:
        like = tuple(None if array is None else jax.ShapeDtypeStruct(array.shape, array.dtype) for array in inputs)
        cotangents = given.volumes, given.centroids, given.areas
        return jax.pure_callback(differentiate, like, *inputs, *cotangents, vmap_method="sequential")

    call.defvjp(call_forward, call_backward)
    found: Measures = call(points, weights)
    return found
