"""Converts results of CUDA kernels to the array type of the query."""

from typing import TYPE_CHECKING

import numpy as np

from remosplat_drake.oracle.cuda.device import like
from remosplat_drake.robot.sphere_batch import SphereBatch
from remosplat_drake.signals.clearance_batch import ClearanceBatch

if TYPE_CHECKING:
    from torch import Tensor

NOTHING = 1e30
"""A distance at or above this value means that there is no surface [m]."""


def batch_answer(
    batch: SphereBatch, reach: "Tensor", direction_W: "Tensor"
) -> ClearanceBatch:
    """Returns the result of a batch query, in the array type of its centres.

    Args:
        batch: The query.
        reach: Distances from the sphere centres to the scene, shape (c, n, k)
            [m]; at least `NOTHING` if there is no surface.
        direction_W: Directions from the centres to the scene, shape (c, n, k,
            3).
    """
    import torch

    radius = torch.as_tensor(batch.radius).to(reach.device, reach.dtype)
    distance = reach - radius[:, None]
    distance = distance.masked_fill(reach >= NOTHING, torch.inf)
    distance = like(distance, batch.p_WS)
    direction_W = like(direction_W, batch.p_WS)
    if not isinstance(batch.p_WS, np.ndarray) and batch.p_WS.requires_grad:
        from remosplat_drake.oracle.cuda.differentiable import differentiable

        distance = differentiable(batch.p_WS, distance, direction_W)
    return ClearanceBatch(distance, direction_W)
