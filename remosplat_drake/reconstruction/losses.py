"""What a splat is trained to: images, surfaces, free space, opaque discs.

Images alone leave depth vague, and gsplat's rendered depth is that of the
splats' centres, not of the discs (gsplat issue 477). So geometry is tied to
the depth images directly: each disc that a view can see must lie on the
measured surface and face along its normal, and no disc may stand in space
that the view looked through.
"""

import dataclasses as dc

import torch
import torch.nn.functional as F
from torch import Tensor


@dc.dataclass(frozen=True)
class View:
    """One image of a capture, on the training device.

    Attributes:
        X_CW: World to camera (OpenCV), (4, 4).
        K: Intrinsics, (3, 3) [pixels].
        rgb: Colours in [0, 1], (h, w, 3).
        depth: z in C, (h, w) [m]; 0 where unknown.
        normal_W: Surface normals, (h, w, 3); 0 where unknown.
    """

    X_CW: Tensor
    K: Tensor
    rgb: Tensor
    depth: Tensor
    normal_W: Tensor


def photometric_loss(image: Tensor, target: Tensor) -> Tensor:
    """0.8 L1 + 0.2 (1 - SSIM) of two (h, w, 3) images (3DGS paper, eq. 7)."""
    l1 = (image - target).abs().mean()
    return 0.8 * l1 + 0.2 * (1 - structural_similarity(image, target))


def structural_similarity(a: Tensor, b: Tensor) -> Tensor:
    """Mean SSIM of two (h, w, 3) images in [0, 1] (Wang et al. 2004)."""
    offset = torch.arange(11, device=a.device, dtype=a.dtype) - 5
    window = torch.exp(-(offset**2) / (2 * 1.5**2))
    window = (window / window.sum()).repeat(3, 1)

    def blur(x: Tensor) -> Tensor:
        x = F.conv2d(x, window[:, None, None, :], padding=(0, 5), groups=3)
        return F.conv2d(x, window[:, None, :, None], padding=(5, 0), groups=3)

    a, b = a.permute(2, 0, 1)[None], b.permute(2, 0, 1)[None]
    mean_a, mean_b = blur(a), blur(b)
    var_a = blur(a * a) - mean_a**2
    var_b = blur(b * b) - mean_b**2
    covariance = blur(a * b) - mean_a * mean_b
    c1, c2 = 0.01**2, 0.03**2
    ssim = ((2 * mean_a * mean_b + c1) * (2 * covariance + c2)) / (
        (mean_a**2 + mean_b**2 + c1) * (var_a + var_b + c2)
    )
    return ssim.mean()


def geometric_losses(
    p_WK: Tensor,
    normal_W: Tensor,
    opacity: Tensor,
    view: View,
    margin: float,
) -> tuple[Tensor, Tensor, Tensor]:
    """How the discs disagree with one depth image.

    Args:
        p_WK: Centres, (n, 3) [m].
        normal_W: Disc normals of either sign, (n, 3).
        opacity: (n,).
        view: The depth image.
        margin: A disc within this depth of the surface belongs to it; one
            nearer to the camera hangs in free space [m].

    Returns:
        Sums over the discs divided by n: distance to the surface's tangent
        plane [m]; 1 - |cos| of the angle to its normal; opacity in free space.
    """
    n = len(p_WK)
    height, width = view.depth.shape
    p_CK = p_WK @ view.X_CW[:3, :3].T + view.X_CW[:3, 3]
    z = p_CK[:, 2]
    pixel = (p_CK @ view.K.T)[:, :2] / z.clamp(min=1e-3)[:, None]
    column, row = pixel.detach().floor().long().unbind(-1)
    inside = (z > 0.05) & (column > 0) & (column < width - 1)
    inside &= (row > 0) & (row < height - 1)
    column, row = column[inside], row[inside]
    p_CK, z = p_CK[inside], z[inside]
    depth = view.depth[row, column]
    seen = (depth > 0) & ((z - depth).abs() < margin)

    surface_normal_W = view.normal_W[row, column]
    seen &= surface_normal_W.abs().sum(-1) > 0
    uv1 = torch.stack([column + 0.5, row + 0.5, torch.ones_like(depth)], dim=-1)
    p_CS = depth[:, None] * (uv1 @ torch.linalg.inv(view.K).T)
    surface_normal_C = surface_normal_W @ view.X_CW[:3, :3].T
    height_over = ((p_CK - p_CS) * surface_normal_C).sum(-1)
    cosine = (normal_W[inside] * surface_normal_W).sum(-1)

    # At a silhouette the disc may belong to any of the pixels around it.
    far = torch.where(view.depth > 0, view.depth, torch.inf)
    nearest = -F.max_pool2d(-far[None], 3, stride=1, padding=1)[0]
    in_front = z.detach() < nearest[row, column] - margin
    in_front &= nearest[row, column].isfinite()
    return (
        height_over[seen].abs().sum() / n,
        (1 - cosine[seen].abs()).sum() / n,
        opacity[inside][in_front].sum() / n,
    )


def coverage_loss(alpha: Tensor, depth: Tensor) -> Tensor:
    """Mean transmittance of the pixels that show a surface; alpha (h, w)."""
    return (1 - alpha)[depth > 0].mean()


def haze_loss(opacity: Tensor) -> Tensor:
    """Zero when every disc is either opaque or gone."""
    return (opacity * (1 - opacity)).mean()
