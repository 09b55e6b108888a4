"""Training a 2DGS splat from an RGB-D capture, on a CUDA device.

The number of discs is fixed: depth already says where the surfaces are, so
nothing has to be grown, and what the images or the depth contradict fades
and is dropped at the end.
"""

import dataclasses as dc
import math
from collections.abc import Callable

import numpy as np
import torch
import torch.nn.functional as F
from torch import Tensor

from remosplat_drake.capture.capture import Capture
from remosplat_drake.errors import MissingExtraError, RemoSplatError
from remosplat_drake.reconstruction.losses import (
    View,
    coverage_loss,
    geometric_losses,
    haze_loss,
    photometric_loss,
)
from remosplat_drake.reconstruction.surfels import (
    Surfels,
    normals_from_points,
    quaternions_onto,
)
from remosplat_drake.splat.gaussian_splat import GaussianSplat


@dc.dataclass
class TrainingConfig:
    """Steps, weights and limits of the optimisation."""

    # Optimisation steps, one image each.
    steps: int = 2000
    # Seed of the order of the images.
    seed: int = 0
    # Initial standard deviation of a disc over the spacing of the surfels.
    initial_scale: float = 0.6
    # A disc's standard deviations stay within these factors of the spacing.
    scale_limits: tuple[float, float] = (0.1, 1.0)
    # Initial opacity: surfels come from measured surfaces.
    initial_opacity: float = 0.7
    # Learning rates; that of the centres is in metres a step.
    center_rate: float = 2e-4
    rotation_rate: float = 1e-3
    scale_rate: float = 5e-3
    opacity_rate: float = 3e-2
    color_rate: float = 5e-3
    # Loss weights, beside 1 for the photometric loss.
    surface_weight: float = 100.0
    normal_weight: float = 1.0
    free_space_weight: float = 10.0
    coverage_weight: float = 0.1
    haze_weight: float = 0.1
    # Depth within which a disc belongs to a measured surface [m].
    margin: float = 0.02
    # Discs below this opacity are dropped at the end.
    min_opacity: float = 0.2


def train(
    capture: Capture,
    surfels: Surfels,
    config: TrainingConfig | None = None,
    report: Callable[[int, float], None] | None = None,
) -> GaussianSplat:
    """Fits one disc a surfel to a capture.

    Args:
        capture: Posed RGB-D images.
        surfels: Where the discs start.
        config: See `TrainingConfig`.
        report: Called every 100 steps with the step and the loss.

    Returns:
        The splat, in the capture's world frame.

    Raises:
        MissingExtraError: gsplat is not installed.
        RemoSplatError: There is no CUDA device.
    """
    config = config or TrainingConfig()
    if not torch.cuda.is_available():
        raise RemoSplatError("training a splat needs a CUDA device")
    torch.manual_seed(config.seed)
    views = [_make_view(capture, i, "cuda") for i in range(len(capture))]
    discs = _Discs(surfels, config)
    order = np.random.default_rng(config.seed)
    for step in range(config.steps):
        view = views[order.integers(len(views))]
        loss = _loss(discs, view, config)
        discs.step(loss, 0.01 ** (step / config.steps))
        if report is not None and step % 100 == 0:
            report(step, loss.item())
    return discs.splat(config.min_opacity)


def _loss(discs: "_Discs", view: View, config: TrainingConfig) -> Tensor:
    image, alpha = discs.render(view)
    opacity = discs.opacity
    surface, normal, free_space = geometric_losses(
        discs.p_WK, discs.normal_W, opacity, view, config.margin
    )
    return (
        photometric_loss(image, view.rgb)
        + config.surface_weight * surface
        + config.normal_weight * normal
        + config.free_space_weight * free_space
        + config.coverage_weight * coverage_loss(alpha, view.depth)
        + config.haze_weight * haze_loss(opacity)
    )


class _Discs:
    """The trained parameters and their activations."""

    def __init__(self, surfels: Surfels, config: TrainingConfig):
        def parameter(array: np.ndarray) -> Tensor:
            tensor = torch.tensor(array, dtype=torch.float32, device="cuda")
            return tensor.requires_grad_()

        n = len(surfels)
        spacing = np.repeat(surfels.spacing[:, None], 2, axis=1)
        lower, upper = config.scale_limits
        self._log_limits = tuple(
            torch.tensor(np.log(f * spacing), device="cuda").float()
            for f in (lower, upper)
        )
        logit = math.log(config.initial_opacity / (1 - config.initial_opacity))
        self.p_WK = parameter(surfels.p_WK)
        self._quaternions = parameter(quaternions_onto(surfels.normal_W))
        self._log_scales = parameter(np.log(config.initial_scale * spacing))
        self._logits = parameter(np.full(n, logit))
        self._colors = parameter(surfels.colors)
        rates = (
            (self.p_WK, config.center_rate),
            (self._quaternions, config.rotation_rate),
            (self._log_scales, config.scale_rate),
            (self._logits, config.opacity_rate),
            (self._colors, config.color_rate),
        )
        self._rates = [rate for _, rate in rates]
        self._optimizer = torch.optim.Adam(
            [{"params": [p], "lr": rate} for p, rate in rates], eps=1e-15
        )

    @property
    def opacity(self) -> Tensor:
        """Shape (n,), in (0, 1)."""
        return torch.sigmoid(self._logits)

    @property
    def normal_W(self) -> Tensor:
        """Third columns of the discs' rotations, (n, 3)."""
        w, x, y, z = F.normalize(self._quaternions, dim=-1).unbind(-1)
        return torch.stack(
            [
                2 * (x * z + w * y),
                2 * (y * z - w * x),
                1 - 2 * (x * x + y * y),
            ],
            dim=-1,
        )

    def render(self, view: View) -> tuple[Tensor, Tensor]:
        """Colours (h, w, 3) over black, and accumulated opacity (h, w)."""
        height, width = view.depth.shape
        scales = torch.exp(self._log_scales)
        image, alpha, *_ = _rasterizer()(
            means=self.p_WK,
            quats=self._quaternions,
            scales=F.pad(scales, (0, 1), value=1.0),
            opacities=self.opacity,
            colors=self._colors[None],
            viewmats=view.X_CW[None],
            Ks=view.K[None],
            width=width,
            height=height,
            near_plane=0.01,
        )
        return image[0], alpha[0, ..., 0]

    def step(self, loss: Tensor, decay: float):
        """One Adam step; the centres' rate decays to hold what is found."""
        self._optimizer.zero_grad(set_to_none=True)
        loss.backward()
        self._optimizer.param_groups[0]["lr"] = self._rates[0] * decay
        self._optimizer.step()
        with torch.no_grad():
            self._log_scales.clamp_(*self._log_limits)
            self._colors.clamp_(0, 1)

    def splat(self, min_opacity: float) -> GaussianSplat:
        """The discs of at least that opacity, off the device."""

        def array(tensor: Tensor) -> np.ndarray:
            return tensor.detach().cpu().numpy()

        splat = GaussianSplat(
            p_GK=array(self.p_WK),
            quaternions=array(self._quaternions),
            scales=array(torch.exp(self._log_scales)),
            opacities=array(self.opacity),
            colors=array(self._colors),
        )
        return splat.select(splat.opacities >= min_opacity)


def _make_view(capture: Capture, i: int, device: str) -> View:
    def tensor(array: np.ndarray) -> Tensor:
        return torch.tensor(array, dtype=torch.float32, device=device)

    X_WC = capture.X_WC[i]
    normal_W = normals_from_points(capture.points_W(i), X_WC[:3, 3])
    return View(
        X_CW=tensor(np.linalg.inv(X_WC)),
        K=tensor(capture.K[i]),
        rgb=tensor(capture.rgb[i] / 255.0),
        depth=tensor(capture.depth[i]),
        normal_W=tensor(np.nan_to_num(normal_W)),
    )


def _rasterizer() -> Callable:
    try:
        from gsplat import rasterization_2dgs
    except ImportError as error:
        raise MissingExtraError("training a splat", "gpu") from error
    return rasterization_2dgs
