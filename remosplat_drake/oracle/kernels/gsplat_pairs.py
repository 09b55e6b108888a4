"""Finds the pairs of a disc and a view in which it may be visible (torch).

Tensors are float32 on one device. D is the frame of a sensor, and V is the
frame of one of its six views (OpenCV axes). A *camera* is the number 6 s + v,
where s is the index of the sphere, and v the index of the view in `VIEWS`.
"""

import math
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from remosplat_drake.oracle.depth_sensor import N_VIEWS, R_DV, DepthSensor
from remosplat_drake.splat.gaussian_splat import GaussianSplat

if TYPE_CHECKING:
    import torch
    from torch import Tensor

VIEWS = np.concatenate(
    [np.argmax(R_DV[:, :, 2], axis=0), np.argmin(R_DV[:, :, 2], axis=0)]
)
"""Indices in `R_DV` of the views along +x, +y, +z, -x, -y, -z of the sensor."""

# For each axis of each view in `VIEWS`: the parallel axis of the sensor, and
# the sign of the direction.
_AXES = np.abs(R_DV[VIEWS]).argmax(axis=1)
_SIGNS = R_DV[VIEWS].sum(axis=1)

# Bound of the rounding error of distances that a matrix product computes [m].
_SLACK = 2e-3


class DiscTensors(NamedTuple):
    """The N visible discs of a splat in W, as tensors on the GPU.

    Attributes:
        frames_W: Three columns (a, b, p) for each disc, shape (N, 3, 3): two
            axes with a length of one standard deviation, and the centre [m].
        opacity: Opacity at the centre of each disc, shape (N,).
        cut: Squared Mahalanobis distance at which the visible part of each disc
            ends, shape (N,).
        radius: Radius of the ball around the visible part of each disc, shape
            (N,) [m].
        uncertainty: Uncertainty of each disc, shape (N,) [m].
        axes: Axis of D that is parallel to each axis of each view, shape (6,
            3).
        signs: 1 if the axis of the view has the direction of this axis of D, -1
            if it has the opposite direction, shape (6, 3).
    """

    frames_W: "Tensor"
    opacity: "Tensor"
    cut: "Tensor"
    radius: "Tensor"
    uncertainty: "Tensor"
    axes: "Tensor"
    signs: "Tensor"


class Sensors(NamedTuple):
    """The depth sensors of n spheres, as tensors on the GPU.

    Attributes:
        p_WS: Positions, shape (n, 3) [m].
        R_DW: Inverse orientations, shape (n, 3, 3).
        ignore_below: Discs with lower centres are ignored, shape (n,) [m].
        reach: Discs beyond this range are omitted, shape (n,) [m].
        views: Whether each view is rendered, in the order of `VIEWS`, shape (n,
            6), bool.
    """

    p_WS: "Tensor"
    R_DW: "Tensor"
    ignore_below: "Tensor"
    reach: "Tensor"
    views: "Tensor"


class Pairs(NamedTuple):
    """P pairs of a disc and a view in which it may be visible.

    Attributes:
        camera: 6 times the sphere's index, plus the view's index in `VIEWS`,
            shape (P,).
        disc: Index of the disc, shape (P,).
        frames_V: Columns (a, b, p) of the disc in the view's frame, shape (P,
            3, 3).
    """

    camera: "Tensor"
    disc: "Tensor"
    frames_V: "Tensor"


def make_discs(
    splat_W: GaussianSplat, min_alpha: float, device: "torch.device"
) -> DiscTensors:
    """Copies the visible discs of a splat to the GPU."""
    import torch

    seen = np.flatnonzero(splat_W.opacities >= min_alpha)
    opacity = splat_W.opacities[seen].astype(float)
    scales = splat_W.scales[seen].astype(float)
    frames_W = splat_W.R_GK[seen]
    frames_W[:, :, :2] *= scales[:, None]
    frames_W[:, :, 2] = splat_W.p_GK[seen]
    cut = 2 * np.log(opacity / min_alpha)
    radius = np.sqrt(cut) * scales.max(axis=1, initial=0.0)
    uncertainty = np.zeros(len(seen))
    if splat_W.uncertainty is not None:
        uncertainty += splat_W.uncertainty[seen]
    arrays = (frames_W, opacity, cut, radius, uncertainty)
    return DiscTensors(
        *(torch.tensor(x, dtype=torch.float32, device=device) for x in arrays),
        axes=torch.tensor(_AXES, device=device),
        signs=torch.tensor(_SIGNS, dtype=torch.float32, device=device),
    )


def visible_pairs(
    discs: DiscTensors, sensors: Sensors, sensor: DepthSensor
) -> Pairs:
    """Finds the discs whose bounding balls may be visible in each view."""
    import torch

    p_WK = discs.frames_W[:, :, 2]
    seen = torch.cdist(sensors.p_WS, p_WK) <= (
        sensors.reach[:, None] + (discs.radius + discs.uncertainty + _SLACK)
    )
    seen &= p_WK[:, 2] >= sensors.ignore_below[:, None]
    sphere, disc = seen.nonzero().unbind(1)
    frames_W = discs.frames_W[disc]
    frames_W[:, :, 2] -= sensors.p_WS[sphere]
    # The products are written out, since batches of small matrices are slow.
    R_DW = sensors.R_DW[sphere]
    frames_D = (R_DW[:, :, :, None] * frames_W[:, None]).sum(dim=2)
    p_D, radius = frames_D[:, :, 2], discs.radius[disc, None]
    size = p_D.abs()
    aside = size.roll(1, 1).maximum(size.roll(2, 1)) - math.sqrt(2) * radius
    along = torch.cat([p_D, -p_D], dim=1)
    seen = along >= aside.maximum(sensor.near - radius).repeat(1, 2)
    seen &= along <= sensor.far + radius + discs.uncertainty[disc, None]
    seen &= sensors.views[sphere]
    pair, slot = seen.nonzero().unbind(1)
    row = 3 * pair[:, None] + discs.axes[slot]
    frames_V = frames_D.view(-1, 3)[row] * discs.signs[slot][:, :, None]
    return Pairs(sphere[pair] * N_VIEWS + slot, disc[pair], frames_V)
