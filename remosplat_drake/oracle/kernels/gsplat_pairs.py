"""Broad phase on the GPU: pairs of discs and views (torch).

Tensors are float32 on one device. D is a sensor's frame, V that of one of its
six views (OpenCV axes). A *camera* is the number 6 s + v, with the index s of
the sphere and the index v of the view in `VIEWS`.
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

# Axis of the sensor that each axis of such a view follows, and its sign.
_AXES = np.abs(R_DV[VIEWS]).argmax(axis=1)
_SIGNS = R_DV[VIEWS].sum(axis=1)

# Rounding of distances that come from a matrix product [m].
_SLACK = 2e-3


class DiscTensors(NamedTuple):
    """N discs of a splat in W, as tensors on the GPU.

    Attributes:
        frames_W: Columns (a, b, p) of each disc, shape (N, 3, 3): the two
            axes of one standard deviation and the centre [m].
        opacity: Peak opacities, shape (N,).
        cut: Squared Mahalanobis distance at which the visible part ends, (N,).
        radius: Radius of the ball around the visible part of each disc, (N,)
            [m].
        uncertainty: Uncertainty of each disc, shape (N,) [m].
        axes: Axis of D that each axis of a view is parallel to, (6, 3).
        signs: 1 if the axis of the view points along that axis of D, -1 if it
            points against it, (6, 3).
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
        ignore_below: Discs with lower centres are ignored, (n,) [m].
        reach: Discs beyond this range are omitted, shape (n,) [m].
        views: Which views to render, in the order of `VIEWS`, (n, 6) bool.
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
        frames_V: Columns (a, b, p) of the disc in the view, (P, 3, 3).
    """

    camera: "Tensor"
    disc: "Tensor"
    frames_V: "Tensor"


def make_discs(
    splat_W: GaussianSplat, min_alpha: float, device: "torch.device"
) -> DiscTensors:
    """Uploads the visible discs of a splat."""
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
    # Summed by hand: batches of small matrices are slow.
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
