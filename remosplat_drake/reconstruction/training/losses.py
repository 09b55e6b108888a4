"""Computes the losses that training minimises.

Colour images alone hardly determine depth. So two kinds of losses use the depth
images. The losses of discs (`disc_losses`) are small if each visible disc is on
the measured surface with the surface's normal, and if no disc is in free space.
The loss of pixels (`depth_loss`) is small if the disc at which a pixel's ray
ends contains the measured point.
"""

import torch
from pytorch_msssim import ssim
from torch import Tensor

from remosplat_drake.reconstruction.training.discs import Discs
from remosplat_drake.reconstruction.training.rasterization import (
    NO_DISC,
    Rendered,
)
from remosplat_drake.reconstruction.training.views import Views


def photometric_loss(rendered: Rendered, views: Views) -> Tensor:
    """Computes the loss 0.8 L1 + 0.2 (1 - SSIM) of images (3DGS paper, eq. 7).

    Pixels that do not show the scene are ignored.
    """
    image = rendered.image
    target = torch.where(views.shown[..., None], views.rgb, image.detach())
    l1 = (image - target).abs().mean()
    similarity = ssim(
        image.permute(0, 3, 1, 2), target.permute(0, 3, 1, 2), data_range=1.0
    )
    return 0.8 * l1 + 0.2 * (1 - similarity)


def ray_splat_depth(discs: Discs, views: Views, median: Tensor) -> Tensor:
    """Computes the depth z at which each pixel's ray meets its median disc.

    The result is differentiable in the discs' centres and orientations.

    Args:
        discs: The discs.
        views: The cameras.
        median: Index of each pixel's disc, see `Rendered`, (v, h, w).

    Returns:
        Shape (v, h, w) [m]; NaN where a ray ends at no disc, or is parallel to
        its disc.
    """
    p_CK, normal_C = _in_cameras(discs, views)
    view = torch.arange(len(views), device=median.device)[:, None, None]
    index = median.clamp(min=0)
    p, n = p_CK[view, index], normal_C[view, index]
    slope = (n * views.rays_C).sum(-1)
    meets = (median != NO_DISC) & (slope.abs() > 1e-6)
    z = (n * p).sum(-1) / torch.where(meets, slope, 1)
    return torch.where(meets, z, torch.nan)


def depth_loss(
    discs: Discs, views: Views, rendered: Rendered, margin: float
) -> Tensor:
    """Computes the mean distance [m] of measured points from rendered discs.

    It is the error of the ray-splat depth, projected onto the disc's normal,
    since a small tilt of a disc is a large error of depth at a grazing ray.
    Errors above the margin come from another surface, and are clipped to the
    margin.
    """
    p_CK, normal_C = _in_cameras(discs, views)
    known = (views.depth > 0) & (rendered.median != NO_DISC)
    view, row, column = known.nonzero(as_tuple=True)
    index = rendered.median[known]
    p_CS = views.depth[known][:, None] * views.rays_C[view, row, column]
    offset = (normal_C[view, index] * (p_CS - p_CK[view, index])).sum(-1)
    return offset.abs().clamp(max=margin).sum() / max(len(index), 1)


def disc_losses(
    discs: Discs, views: Views, margin: float
) -> tuple[Tensor, Tensor, Tensor]:
    """Computes three losses of discs that disagree with depth images.

    Args:
        discs: The n discs.
        views: The depth images.
        margin: A disc belongs to a surface if their depths differ by at most
            this [m]. A disc that is farther in front of the surface is in free
            space.

    Returns:
        Three losses, averaged over discs and views: distance to the surface's
        tangent plane [m]; 1 - |cos| of the angle to its normal; opacity in free
        space.
    """
    count = len(discs) * len(views)
    height, width = views.depth.shape[1:]
    p_CK, normal_C = _in_cameras(discs, views)
    z = p_CK[..., 2]
    pixel = torch.einsum("vij,vkj->vki", views.K[:, :2], p_CK.detach())
    pixel = (pixel / z.detach().clamp(min=1e-3)[..., None]).floor().long()
    column, row = pixel.unbind(-1)
    inside = (z > 0.05) & (column > 0) & (column < width - 1)
    inside &= (row > 0) & (row < height - 1)
    view, disc = inside.nonzero(as_tuple=True)
    place = (view, row[inside], column[inside])
    depth, surface_C = views.depth[place], views.normal_C[place]
    z = z[inside]

    seen = (depth > 0) & ((z.detach() - depth).abs() < margin)
    seen &= surface_C.abs().sum(-1) > 0
    p_CS = depth[:, None] * views.rays_C[place]
    height_over = ((p_CK[inside] - p_CS) * surface_C).sum(-1)
    cosine = (normal_C[inside] * surface_C).sum(-1)

    front = views.front[place]
    in_front = (z.detach() < front - margin) & front.isfinite()
    return (
        height_over[seen].abs().sum() / count,
        (1 - cosine[seen].abs()).sum() / count,
        discs.opacity[disc[in_front]].sum() / count,
    )


def coverage_loss(rendered: Rendered, views: Views) -> Tensor:
    """Computes the mean transmittance of pixels that show a surface.

    It is 0 if there is no such pixel.
    """
    known = views.depth > 0
    return (1 - rendered.alpha)[known].sum() / known.sum().clamp(min=1)


def haze_loss(discs: Discs) -> Tensor:
    """Computes the mean of o (1 - o), with the opacity o of each disc.

    This opacity regularisation is zero if every disc is opaque or invisible.
    """
    return (discs.opacity * (1 - discs.opacity)).mean()


def _in_cameras(discs: Discs, views: Views) -> tuple[Tensor, Tensor]:
    """Centres and normals of the discs in each C, (v, n, 3) both."""
    R_CW, p_CW = views.X_CW[:, :3, :3], views.X_CW[:, :3, 3]
    p_CK = torch.einsum("vij,kj->vki", R_CW, discs.p_WK) + p_CW[:, None]
    return p_CK, torch.einsum("vij,kj->vki", R_CW, discs.normal_W)
