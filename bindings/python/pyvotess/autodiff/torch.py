"""Cells of PyTorch tensors on the CPU, with derivatives by ``backward()`` and ``torch.autograd``."""

from __future__ import annotations

from typing import Any, Optional

import numpy as np

from ..export.optional import imported

imported("torch", "pyvotess.autodiff.torch")

import torch
from torch.autograd.function import once_differentiable

from .._domain import Domain
from . import Measures, forward, vjp

__all__ = ["tessellate"]


def _tensor(array: Any, like: Any = None) -> Any:
    """Returns a copy: autograd may write to it."""
    return torch.from_numpy(np.array(array)).to(None if like is None else like.dtype)


class _Cells(torch.autograd.Function):
    @staticmethod
    def forward(ctx: Any, points: Any, weights: Any, options: Any) -> Any:
        ctx.save_for_backward(points, weights)  # then autograd refuses points that change before backward()
        ctx.t = t = forward(points.detach(), weights=None if weights is None else weights.detach(), **options)
        rows = t.rows()
        of_rows = tuple(_tensor(array) for array in (rows.status, rows.adjacency, rows.offsets))
        ctx.mark_non_differentiable(*of_rows)
        return (*(_tensor(array, points) for array in (t.volumes, t.centroids, t.areas)), *of_rows)

    @staticmethod
    @once_differentiable
    def backward(ctx: Any, volumes: Any, centroids: Any, areas: Any, *of_rows: Any) -> Any:
        found = vjp(ctx.t, volumes, centroids, areas)
        points, weights = ctx.saved_tensors
        return _tensor(found.points, points), None if weights is None else _tensor(found.weights, weights), None


def tessellate(points: Any, domain: Optional[Domain] = None, *, weights: Any = None, **options: Any) -> Measures:
    """Returns the measures of the cells as tensors, of the type of ``points``.

    Parameters
    ----------
    points, weights : as for :func:`pyvotess.autodiff.forward`, tensors on the CPU.
    domain, options : as for :func:`pyvotess.autodiff.forward`.

    There are no second derivatives.
    """
    for name, tensor in (("points", points), ("weights", weights)):
        if tensor is not None and not (torch.is_tensor(tensor) and tensor.dtype in (torch.float64, torch.float32)):
            kind = tensor.dtype if torch.is_tensor(tensor) else type(tensor).__name__
            raise ValueError(f"{name} is {kind}: give a tensor of float64 or float32")
        if tensor is not None and tensor.device.type != "cpu":
            raise ValueError(f"{name} is on {tensor.device}: give {name}.cpu()")
    volumes, centroids, areas, status, adjacency, offsets = _Cells.apply(points, weights, {"domain": domain, **options})
    return Measures(volumes, centroids, status, areas, adjacency, offsets)
