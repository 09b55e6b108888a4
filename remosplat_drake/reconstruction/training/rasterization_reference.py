"""Reference of `rasterization.rasterize`: slow and readable, in torch.

It evaluates every disc at every pixel, so it is suitable only for small scenes.
"""

import torch
from torch import Tensor

from remosplat_drake.reconstruction.training.discs import Discs
from remosplat_drake.reconstruction.training.rasterization import (
    NEAR,
    NO_DISC,
    Rendered,
)
from remosplat_drake.reconstruction.training.views import Views

_LEAST_ALPHA, _MOST_ALPHA = 1 / 255, 0.99
_LEAST_TRANSMITTANCE = 1e-4
_LEAST_SLOPE = 1e-6
_FILTER = 2.0
"""Inverse variance of the screen-space filter (2DGS paper) [1/pixel²]."""


def rasterize_reference(discs: Discs, views: Views) -> Rendered:
    """Renders all discs from the cameras of all views, as `rasterize` does."""
    parts = [_draw(discs, views[i : i + 1]) for i in range(len(views))]
    return Rendered(
        *(torch.cat(tensors) for tensors in zip(*parts, strict=True))
    )


def _draw(discs: Discs, view: Views) -> Rendered:
    """One view: rows are pixels, columns discs from front to back."""
    height, width = view.depth.shape[1:]
    R_CW, p_CW = view.X_CW[0, :3, :3], view.X_CW[0, :3, 3]
    p_CK = discs.p_WK @ R_CW.T + p_CW
    order = torch.argsort(p_CK[:, 2].detach())
    order = order[p_CK[order, 2] > NEAR]
    p_CK, R_CK = p_CK[order], R_CW @ discs.R_WK[order]
    rays = view.rays_C[0].reshape(-1, 3)
    alpha = discs.opacity[order] * torch.exp(
        -0.5
        * torch.minimum(
            _squared_radius(p_CK, R_CK, discs.scales[order], rays),
            _FILTER * _squared_pixels(p_CK, view.K[0], rays),
        )
    )
    alpha = alpha.clamp(max=_MOST_ALPHA)
    alpha = torch.where(alpha < _LEAST_ALPHA, 0, alpha)
    clear = torch.cumprod(1 - alpha, dim=1)
    # gsplat stops before the disc behind which almost no light would remain.
    alpha = torch.where(clear <= _LEAST_TRANSMITTANCE, 0, alpha)
    clear = torch.cumprod(1 - alpha, dim=1)
    before = torch.cat([torch.ones_like(clear[:, :1]), clear[:, :-1]], dim=1)
    image = (before * alpha) @ discs.colors[order]
    total = 1 - clear[:, -1]
    last = ((before > 0.5) & (alpha > 0)).long()
    last = last * torch.arange(len(order), device=last.device)
    median = torch.where(total > 0.5, order[last.argmax(dim=1)], NO_DISC)
    return Rendered(
        image.reshape(1, height, width, 3),
        total.reshape(1, height, width),
        median.reshape(1, height, width),
    )


def _squared_radius(
    p_CK: Tensor, R_CK: Tensor, scales: Tensor, rays: Tensor
) -> Tensor:
    """u² + v² where the rays meet the discs' planes, (pixels, discs)."""
    normal = R_CK[..., 2]
    slope = rays @ normal.T
    # If a ray is parallel to a disc, the gradient must be finite, too.
    meets = slope.abs() > _LEAST_SLOPE
    z = (p_CK * normal).sum(-1) / torch.where(meets, slope, 1)
    offset = z[..., None] * rays[:, None] - p_CK
    uv = torch.einsum("pki,kij->pkj", offset, R_CK[..., :2]) / scales
    return torch.where(meets & (z > 0), (uv**2).sum(-1), 1e9)


def _squared_pixels(p_CK: Tensor, K: Tensor, rays: Tensor) -> Tensor:
    """Squared pixel distances of the discs' centres, (pixels, discs)."""
    focal = torch.stack([K[0, 0], K[1, 1]])
    center = p_CK[:, :2] / p_CK[:, 2:]
    return (((rays[:, None, :2] - center) * focal) ** 2).sum(-1)
