"""Cells of PyTorch tensors, with derivatives by ``backward()`` and ``torch.autograd``: on the CPU, or by frames on a GPU."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Optional

import numpy as np

from ..export.optional import imported

imported("torch", "pyvotess.autodiff.torch")

import torch
from torch.autograd.function import once_differentiable

from .._domain import DomainLike
from . import Measures, forward, vjp

if TYPE_CHECKING:
    from ..gpu import Frames

__all__ = ["measure", "tessellate"]


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


class _FrameCells(torch.autograd.Function):
    """Cells of frames. Their arrays may lie in memory of the frames, so tensors are copies."""

    @staticmethod
    def forward(ctx: Any, points: Any, weights: Any, frames: Any) -> Any:
        ctx.save_for_backward(points, weights)
        ctx.on_cuda = points.is_cuda
        stream = {"stream": torch.cuda.current_stream(points.device)} if points.is_cuda else {}
        inputs = [None if tensor is None else tensor.detach().contiguous() for tensor in (points, weights)]
        ctx.cells = cells = frames(*inputs, **stream).resolve()

        def copy(name: str) -> Any:
            array = cells.__dict__.get(name)
            return None if array is None else torch.as_tensor(array, device=points.device).clone()

        volumes, centroids, areas, status, adjacency, offsets = map(
            copy, ("volumes", "centroids", "face_areas", "status", "indices", "indptr")
        )
        if points.is_cuda:  # arrays are longer than the rows
            end = int(offsets[-1])
            areas, adjacency = (None if array is None else array[:end].clone() for array in (areas, adjacency))
        ctx.mark_non_differentiable(status, adjacency, offsets)
        return volumes, centroids, areas, status, adjacency, offsets

    @staticmethod
    @once_differentiable
    def backward(ctx: Any, volumes: Any, centroids: Any, areas: Any, *of_rows: Any) -> Any:
        points, weights = ctx.saved_tensors
        given = [None if tensor is None else tensor.contiguous() for tensor in (volumes, centroids, areas)]
        if ctx.on_cuda:
            found = ctx.cells.vjp(*given, stream=torch.cuda.current_stream(points.device))
        else:
            found = ctx.cells.vjp(*(None if tensor is None else tensor.numpy() for tensor in given))
        by_points, by_weights = (torch.as_tensor(array, device=points.device).clone() for array in found)
        return by_points.to(points.dtype), None if weights is None else by_weights.to(weights.dtype), None


def measure(frames: Frames, points: Any, weights: Any = None) -> Measures:
    """Returns the measures of the cells that ``frames`` makes, as tensors beside ``points``, with derivatives on its device.

    Parameters
    ----------
    frames : with ``gradients=True``. Measures that are not in its ``want`` are None. Centroids need volumes too.
    points, weights : as for a call of ``frames``: tensors on its GPU where its device is "cuda", else on the CPU.

    Volumes and areas are float32, centroids of the type of the points. All cells are resolved, for which the host waits.
    Call ``backward()`` before the next call of ``frames``: ValueError otherwise. There are no second derivatives.
    """
    return Measures(*_order(*_FrameCells.apply(points, weights, frames)))


def _order(volumes: Any, centroids: Any, areas: Any, status: Any, adjacency: Any, offsets: Any) -> Any:
    return volumes, centroids, status, areas, adjacency, offsets


def tessellate(points: Any, domain: Optional[DomainLike] = None, *, weights: Any = None, **options: Any) -> Measures:
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
            raise ValueError(f"{name} is on {tensor.device}: give {name}.cpu(), or use measure() with frames on that device")
    return Measures(*_order(*_Cells.apply(points, weights, {"domain": domain, **options})))
