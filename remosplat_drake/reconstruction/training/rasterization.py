"""Renders discs differentiably, with gsplat on a CUDA device."""

from collections.abc import Callable
from typing import NamedTuple

import torch
import torch.nn.functional as F
from torch import Tensor

from remosplat_drake.base.errors import MissingExtraError
from remosplat_drake.reconstruction.training.discs import Discs
from remosplat_drake.reconstruction.training.views import Views

NEAR = 0.01
"""A disc is drawn only if the depth of its centre is at least this [m]."""

NO_DISC = -1
"""Value of `Rendered.median` at pixels without a median disc."""


class Rendered(NamedTuple):
    """Rendered images of v views over a black background.

    Attributes:
        image: Colours, (v, h, w, 3).
        alpha: Accumulated opacity, (v, h, w).
        median: Index of the disc at which the absorbed part of the light first
            exceeds one half, (v, h, w); `NO_DISC` if there is no such disc.
    """

    image: Tensor
    alpha: Tensor
    median: Tensor


Rasterizer = Callable[[Discs, Views], Rendered]
"""Type of functions that render discs from the cameras of views, such as
`rasterize`.
"""


def rasterize(discs: Discs, views: Views) -> Rendered:
    """Renders all discs from the cameras of all views.

    gsplat's own median depth is that of the disc's centre (gsplat issue 477).
    So each disc has its index as a fourth colour, and gsplat returns the index
    of the median disc. `ray_splat_depth` then intersects this disc with the
    pixel's ray.

    Raises:
        MissingExtraError: gsplat is not installed.
    """
    try:
        from gsplat import rasterization_2dgs
    except ImportError as error:
        raise MissingExtraError("training a splat", "gpu") from error
    n, v = len(discs), len(views)
    index = torch.arange(1, n + 1, device=discs.colors.device)
    colors = torch.cat([discs.colors, index[:, None].float()], dim=1)
    height, width = views.depth.shape[1:]
    image, alpha, _, _, _, median, _ = rasterization_2dgs(
        means=discs.p_WK,
        quats=discs.quaternions,
        scales=F.pad(discs.scales, (0, 1), value=1.0),
        opacities=discs.opacity,
        colors=colors.expand(v, n, 4).contiguous(),
        viewmats=_viewmats(views),
        Ks=views.K.detach(),
        width=width,
        height=height,
        near_plane=NEAR,
    )
    # gsplat returns zero where nothing was drawn, so indices start at 1.
    median = median[..., 0].detach().round().long() - 1
    has_median = (alpha[..., 0].detach() > 0.5) & (median < n)
    return Rendered(
        image[..., :3],
        alpha[..., 0],
        torch.where(has_median, median, NO_DISC),
    )


def _viewmats(views: Views) -> Tensor:
    """The poses X_CW, through which gradients by K are also computed.

    gsplat computes gradients with respect to `viewmats`, but not to `Ks`. It
    uses both only as the product K X_CW = K_0 (K_0⁻¹ K) X_CW. K_0 is a constant
    with the value of K. So the bracket is the identity, but has a gradient.
    """
    K = views.K
    one = torch.linalg.solve_triangular(K.detach(), K, upper=True)
    return torch.cat([one @ views.X_CW[:, :3], views.X_CW[:, 3:]], dim=1)
