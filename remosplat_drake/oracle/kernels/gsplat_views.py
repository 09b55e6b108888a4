"""Renders the six depth views of many spheres with gsplat on a GPU.

`footprint` bounds each disc in its image. gsplat's public functions then sort
the discs, assign them to tiles, and composite them. A colour channel contains
the *index* of the disc, so gsplat's "median" of this channel is the disc at the
median depth. `nearest_pixels` intersects this disc with the pixel's ray. The
projection of gsplat is not used, because it drops discs whose centre is behind
the camera, and computes wrong bounds for discs that extend beside the camera.

Tensors are float32 on one device. There are C images, one for each camera in
use, and P pairs of a disc and an image (`gsplat_pairs`). The frame V of a view
has OpenCV axes, in which rays are (x, y, 1).
"""

import math
from typing import TYPE_CHECKING, NamedTuple

from remosplat_drake.oracle.depth_sensor import FILTER_SCALE, DepthSensor
from remosplat_drake.oracle.kernels.gsplat_pairs import DiscTensors, Pairs

if TYPE_CHECKING:
    import torch
    from torch import Tensor

TILE = 8
"""Side length of the tiles that gsplat sorts and composites [px]."""

# Position that is so far outside the image that a footprint of the screen-space
# filter reaches no pixel [px].
_NOWHERE = 1e6


class Rays(NamedTuple):
    """Rays (x, y, 1) of pixels; each field has the shape (resolution^2,)."""

    x: "Tensor"
    y: "Tensor"
    length: "Tensor"


def make_rays(sensor: DepthSensor, device: "torch.device") -> Rays:
    """Makes the rays of the pixels of a sensor's view, row by row."""
    import torch

    axis = torch.tensor(
        sensor.pixel_centers(), dtype=torch.float32, device=device
    )
    x, y = axis.repeat(len(axis)), axis.repeat_interleave(len(axis))
    return Rays(x, y, (x * x + y * y + 1).sqrt())


class Footprint(NamedTuple):
    """Bounding boxes of P discs in their images.

    Attributes:
        center: Centre of the bounding box, shape (P, 2) [px].
        half: Half the sides of the bounding box, rounded up, shape (P, 2) [px];
            0 if the disc is not visible.
        depth: Sort key of the discs in an image, shape (P,) [m].
        plane: The plane of each disc as (n, n . p), shape (4, P). A ray meets
            the plane at the depth n . p / (n . ray).
        uncertainty: Uncertainty of the disc, shape (P,) [m].
    """

    center: "Tensor"
    half: "Tensor"
    depth: "Tensor"
    plane: "Tensor"
    uncertainty: "Tensor"


def footprint(
    frames_V: "Tensor",
    cut: "Tensor",
    uncertainty: "Tensor",
    sensor: DepthSensor,
) -> Footprint:
    """Computes the bounding boxes of discs in their images.

    The outline of a disc is the ellipse of the dual conic E - p p', where E =
    cut (a a' + b b'). Discs that extend behind the camera are clipped.

    Args:
        frames_V: Columns (a, b, p) of each disc in V, shape (P, 3, 3).
        cut: Squared Mahalanobis distance at which the visible part of each disc
            ends, shape (P,).
        uncertainty: Uncertainty of each disc, shape (P,) [m].
        sensor: The views.
    """
    rows = frames_V.flatten(1).T.contiguous().view(3, 3, -1)
    axes, p = rows[:, :2], rows[:, 2]
    low, high, near_end, far_end = _extent(axes, p, cut, sensor)
    middle = (low + high) / 2
    pixels = sensor.resolution / 2
    half = ((high - low) / 2 * pixels).ceil()
    half *= (far_end >= sensor.near) & (near_end <= sensor.far + uncertainty)
    plane = _plane(axes, p)
    # The sort key is the depth of the centre, unless the centre is outside the
    # image.
    depth = plane[3] / (plane[0] * middle[0] + plane[1] * middle[1] + plane[2])
    depth = depth.clamp(near_end, far_end).clamp(min=sensor.near)
    return Footprint(
        ((middle + 1) * pixels).T.contiguous(),
        half.int().T.contiguous(),
        depth - uncertainty,
        plane,
        uncertainty,
    )


def _extent(axes, p, cut, sensor: DepthSensor) -> tuple["Tensor", ...]:
    """Returns lower and upper bounds of x and y, (2, P), and of z, (P,)."""
    E_ii = cut * (axes * axes).sum(dim=1)
    E_iz = cut * (axes[:2] * axes[2]).sum(dim=1)
    z, reach = p[2], E_ii[2].sqrt()
    q_zz = E_ii[2] - z * z
    middle = (E_iz - p[:2] * z) / q_zz
    # Products of the components of p cancel and are omitted, so that the bounds
    # of small discs are precise.
    square = z * (E_ii[:2] * z - 2 * E_iz * p[:2]) + E_ii[2] * p[:2] ** 2
    square -= E_ii[:2] * E_ii[2] - E_iz * E_iz
    half = square.clamp(min=0).sqrt() / q_zz.abs()
    low, high = middle - half, middle + half
    # If a disc extends behind the camera, these are the bounds of the part in
    # front of the camera.
    is_before = z - reach > 1e-6
    size = E_ii[:2].sqrt()
    box_low, box_high = p[:2] - size, p[:2] + size
    far_end = z + reach
    box_low = box_low / far_end.where(box_low > 0, sensor.near)
    box_high = box_high / far_end.where(box_high < 0, sensor.near)
    low = low.where(is_before, box_low)
    high = high.where(is_before, box_high)
    if sensor.low_pass_filter:
        dot = 2 * (cut / FILTER_SCALE).sqrt() / sensor.resolution
        center = p[:2] / z
        has_dot = z > sensor.near
        low = low.minimum(center - dot).where(has_dot, low)
        high = high.maximum(center + dot).where(has_dot, high)
    return low.clamp(-1, 1), high.clamp(-1, 1), z - reach, far_end


def _plane(axes: "Tensor", p: "Tensor") -> "Tensor":
    normal = axes[:, 0].cross(axes[:, 1], dim=0)
    plane = normal.new_empty(4, normal.shape[1])
    plane[:3] = normal
    plane[3] = (normal * p).sum(dim=0)
    return plane


def render(
    pairs: Pairs,
    n_cameras: int,
    discs: DiscTensors,
    rays: Rays,
    sensor: DepthSensor,
) -> tuple["Tensor", "NearestPixels"]:
    """Renders the cameras that occur in at least one pair.

    Returns:
        The numbers of these cameras, shape (C,), and their nearest pixels.
    """
    used = pairs.camera.new_zeros(n_cameras)
    used[pairs.camera] = 1
    cameras = used.nonzero()[:, 0]
    bounds = footprint(
        pairs.frames_V,
        discs.cut[pairs.disc],
        discs.uncertainty[pairs.disc],
        sensor,
    )
    median, alpha = _composite(
        pairs.frames_V,
        discs.opacity[pairs.disc],
        (used.cumsum(0) - 1)[pairs.camera],
        len(cameras),
        bounds,
        sensor,
    )
    return cameras, nearest_pixels(
        pairs.frames_V, bounds, median, alpha, rays, sensor
    )


def _composite(
    frames_V: "Tensor",
    opacity: "Tensor",
    image: "Tensor",
    n_images: int,
    bounds: Footprint,
    sensor: DepthSensor,
) -> tuple["Tensor", "Tensor"]:
    """Renders, with gsplat, the pair that contains the median of each pixel.

    Returns:
        The pair and the accumulated alpha of each pixel, both of shape (C,
        resolution^2). The pair is undefined if alpha is 0.
    """
    import gsplat
    import torch

    r = sensor.resolution
    tiles = math.ceil(r / TILE)
    _, keys, order = gsplat.isect_tiles(
        bounds.center,
        bounds.half,
        bounds.depth,
        TILE,
        tiles,
        tiles,
        packed=True,
        n_images=n_images,
        image_ids=image,
        gaussian_ids=image,
    )
    offsets = gsplat.isect_offset_encode(keys, n_images, tiles, tiles)
    # These are the rows of K (a b p), up to scale, which map (u, v, 1) to
    # pixels.
    transforms = frames_V.clone()
    transforms[:, :2] += transforms[:, 2:]
    transforms[:, 2] /= r / 2
    index = torch.arange(len(image), dtype=torch.float32, device=image.device)
    _, alpha, _, _, median = gsplat.rasterize_to_pixels_2dgs(
        _filter_centers(frames_V, sensor),
        transforms,
        index[:, None],
        opacity,
        # gsplat's normals and gradients are not used, so their values do not
        # matter.
        frames_V.view(3, -1, 3)[0],
        frames_V.view(3, -1, 3)[0, :, :2],
        r,
        r,
        TILE,
        offsets,
        order,
        packed=True,
    )
    return median.flatten(1).long(), alpha.flatten(1)


def _filter_centers(frames_V: "Tensor", sensor: DepthSensor) -> "Tensor":
    """Returns the centres of the screen-space filter, shape (P, 2) [px]."""
    if not sensor.low_pass_filter:
        return frames_V.new_full((len(frames_V), 2), _NOWHERE)
    p = frames_V[:, :, 2]
    center = (p[:, :2] / p[:, 2:] + 1) * (sensor.resolution / 2)
    return center.masked_fill(p[:, 2:] <= sensor.near, _NOWHERE)


class NearestPixels(NamedTuple):
    """The nearest pixel of each of C images.

    Attributes:
        range: Range of the nearest pixel along its ray, shape (C,) [m]; inf if
            no pixel counts as a surface.
        pixel: Row-major index of the nearest pixel, shape (C,).
        open_range: Smallest range of all pixels that have a median, including
            those with too little alpha, shape (C,) [m]. If it is smaller than
            `range`, discs behind this pixel's median could give the pixel
            enough alpha.
    """

    range: "Tensor"
    pixel: "Tensor"
    open_range: "Tensor"


def nearest_pixels(
    frames_V: "Tensor",
    bounds: Footprint,
    median: "Tensor",
    alpha: "Tensor",
    rays: Rays,
    sensor: DepthSensor,
) -> NearestPixels:
    """Intersects the pixels' rays with their median discs.

    Args:
        frames_V: Columns (a, b, p) of the pairs' discs in V, shape (P, 3, 3).
        bounds: The `Footprint` with planes and uncertainties of the pairs'
            discs.
        median: Index of the pair that contains the median of each pixel, shape
            (C, resolution^2).
        alpha: Accumulated alpha of each pixel, shape (C, resolution^2).
        rays: Rays of the pixels.
        sensor: The views.
    """
    n_x, n_y, n_z, height = bounds.plane[:, median]
    z = height / (n_x * rays.x + n_y * rays.y + n_z)
    if sensor.low_pass_filter:
        z = _filtered_depth(frames_V[median], rays, z, sensor)
    # A median outside these bounds does not count as a surface.
    seen = z >= sensor.near
    z = z - bounds.uncertainty[median] / rays.length
    seen &= z <= sensor.far
    seen &= alpha >= 1 - sensor.transmittance
    ranges = (z * rays.length).masked_fill(~seen, math.inf)
    counted = ranges.masked_fill(alpha < sensor.alpha_cutoff, math.inf)
    nearest = counted.min(dim=1)
    return NearestPixels(nearest.values, nearest.indices, ranges.amin(dim=1))


def _filtered_depth(frames_V, rays: Rays, z, sensor: DepthSensor) -> "Tensor":
    """Returns z, or the centre's depth if the screen-space filter decides."""
    x, y, rows = rays.x, rays.y, frames_V.unbind(-2)
    h_u = x[:, None] * rows[2] - rows[0]
    h_v = y[:, None] * rows[2] - rows[1]
    u, v, w = h_u.cross(h_v, dim=-1).unbind(-1)
    weight = (u * u + v * v) / (w * w)
    p_x, p_y, p_z = frames_V[..., 2].unbind(-1)
    square = (x - p_x / p_z) ** 2 + (y - p_y / p_z) ** 2
    filtered = FILTER_SCALE * (sensor.resolution / 2) ** 2 * square
    return p_z.where((p_z > sensor.near) & ~(weight <= filtered), z)
