"""Makes distances that torch differentiates by sphere centres."""

from functools import cache
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from torch import Tensor


def differentiable(
    p_WS: "Tensor", distance: "Tensor", direction_W: "Tensor"
) -> "Tensor":
    """Returns distances whose gradient with respect to centres torch computes.

    Args:
        p_WS: Centres, shape (c, n, 3) [m].
        distance: Distances, shape (c, n, k) [m].
        direction_W: Directions towards the scene, shape (c, n, k, 3). They are
            the negative gradient, and are zero for rows that do not exist.
    """
    return _distance().apply(p_WS, distance, direction_W)


@cache
def _distance():
    """Returns the torch function, for distances that are already computed."""
    import torch

    class Distance(torch.autograd.Function):
        @staticmethod
        def forward(ctx, p_WS, distance, direction_W):
            ctx.save_for_backward(direction_W)
            return distance.clone()

        @staticmethod
        def backward(ctx, grad):
            (direction_W,) = ctx.saved_tensors
            gone = direction_W.abs().sum(-1) == 0
            grad = grad.masked_fill(gone, 0.0)
            return -(grad[..., None] * direction_W).sum(-2), None, None

    return Distance
