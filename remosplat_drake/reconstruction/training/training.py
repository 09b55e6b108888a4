"""Trains a 2DGS splat on the images of an RGB-D capture.

No discs are added, since the initial discs already cover the surfaces in the
depth images. The opacity of discs that contradict images or depth decreases,
and nearly transparent discs are removed at the end.
"""

import dataclasses as dc
import hashlib
import io
import math
from collections.abc import Callable
from pathlib import Path

import numpy as np
import torch
from torch import Tensor

from remosplat_drake.base.atomic_file import atomic_write
from remosplat_drake.base.errors import FileError, RemoSplatError
from remosplat_drake.capture.capture import Capture
from remosplat_drake.reconstruction.alignment.camera_errors import COUNT
from remosplat_drake.reconstruction.surfels.seen_through import fill_holes
from remosplat_drake.reconstruction.training import losses
from remosplat_drake.reconstruction.training.cameras import (
    CameraDeviations,
    Cameras,
)
from remosplat_drake.reconstruction.training.discs import Discs
from remosplat_drake.reconstruction.training.rasterization import (
    Rasterizer,
    rasterize,
)
from remosplat_drake.reconstruction.training.views import Views
from remosplat_drake.splat.gaussian_splat import GaussianSplat


@dc.dataclass(frozen=True)
class TrainingConfig:
    """Steps, weights and limits of the optimisation by Adam."""

    # Largest number of optimisation steps.
    steps: int = 500
    # Number of images in each step.
    batch: int = 2
    # Seed of the order of the images.
    seed: int = 0
    # Least and largest ratio of a disc's standard deviations to the initial
    # ones. If discs at an edge shrink, the map contains no edge, and distances
    # become too large.
    scale_limits: tuple[float, float] = (0.85, 1.2)
    # Learning rate of the centres [m per step]. It is small, since the initial
    # discs are already fitted to all depth images.
    center_rate: float = 2e-5
    # Learning rate of the quaternions.
    rotation_rate: float = 1e-4
    # Learning rate of the logarithms of the scales.
    scale_rate: float = 5e-3
    # Learning rate of the logits of the opacities.
    opacity_rate: float = 3e-2
    # Learning rate of the colours.
    color_rate: float = 5e-3
    # Final learning rates of centres and cameras, as a fraction of the initial
    # ones.
    final_rate: float = 0.01
    # Whether poses, lens and depth curve of the cameras are also optimised.
    refine_cameras: bool = False
    # Cameras are optimised from this step on, because colours must converge
    # first.
    camera_start: int = 10
    # Learning rate of poses [standard deviations per step].
    pose_rate: float = 0.2
    # Learning rate of lens and depth curve [standard deviations per step].
    lens_rate: float = 0.1
    # Weight of `Cameras.prior`.
    prior_weight: float = 1e-4
    # Prior standard deviations of the cameras' errors.
    deviations: CameraDeviations = dc.field(default_factory=CameraDeviations)
    # Weight of `depth_loss`; `photometric_loss` has the weight 1.
    depth_weight: float = 10.0
    # Weight of the distance to the surface in `disc_losses`.
    surface_weight: float = 100.0
    # Weight of the angle to the normal in `disc_losses`.
    normal_weight: float = 1.0
    # Weight of the opacity in free space in `disc_losses`.
    free_space_weight: float = 10.0
    # Weight of `coverage_loss`.
    coverage_weight: float = 0.1
    # Weight of `haze_loss`.
    haze_weight: float = 0.1
    # A disc belongs to a surface if their depths differ by at most this [m].
    margin: float = 0.02
    # Opacity below which discs are removed at the end.
    min_opacity: float = 0.2
    # Number of steps between two evaluations of the held-out views.
    check_every: int = 100
    # Training stops after this many consecutive evaluations without progress.
    patience: int = 3
    # Least relative decrease of the held-out loss that counts as progress.
    least_gain: float = 0.01


CAMERA_TRAINING = TrainingConfig(refine_cameras=True, batch=8, center_rate=2e-4)
"""Settings for training that also optimises the cameras. Each step uses more
views, which determine the common lens better. Discs may move farther, since the
errors of the cameras affect the initial discs.
"""


@dc.dataclass(frozen=True)
class Progress:
    """Number of completed steps of training, and the latest losses.

    Attributes:
        step: Number of completed steps.
        steps: Largest number of steps.
        loss: Loss of the latest batch.
        held_out: Loss of the held-out views at their latest evaluation; NaN
            before the first evaluation, or if no views are held out.
    """

    step: int
    steps: int
    loss: float
    held_out: float


@dc.dataclass(frozen=True, eq=False)
class Trained:
    """A trained splat, and the progress and cameras at the end of training.

    Attributes:
        splat: The splat in the capture's world frame.
        progress: Progress at the end of training.
        capture: The capture, with refined cameras if these were optimised.
        undone: Camera errors that were corrected in the capture, see
            `camera_errors`, shape (`COUNT`,); 0 for errors that were not
            optimised.
    """

    splat: GaussianSplat
    progress: Progress
    capture: Capture
    undone: np.ndarray


def train(
    capture: Capture,
    start: GaussianSplat,
    config: TrainingConfig | None = None,
    *,
    held_out: np.ndarray | None = None,
    checkpoint: Path | None = None,
    report: Callable[[Progress], None] | None = None,
    device: str = "cuda",
    rasterizer: Rasterizer = rasterize,
) -> Trained:
    """Fits 2DGS discs to a capture by differentiable rendering.

    Args:
        capture: Posed RGB-D images.
        start: The splat in the capture's frame W that determines the initial
            discs.
        config: Settings; None: the defaults.
        held_out: Mask of views, shape (n,), bool, that are not used for
            training, and whose loss determines when training stops. None: all
            steps are made.
        checkpoint: File to which the state is saved at every evaluation of the
            held-out views. If the file exists, training continues from it.
        report: Called with the progress every ten steps.
        device: Name of the torch device; gsplat needs "cuda".
        rasterizer: Function that renders the discs.

    Raises:
        MissingExtraError: gsplat is not installed.
        RemoSplatError: There is no CUDA device.
        FileError: The checkpoint belongs to another capture or other settings,
            or is unreadable.
    """
    config = config or TrainingConfig()
    if device == "cuda" and not torch.cuda.is_available():
        raise RemoSplatError(
            "training a splat needs a CUDA device, and none was found"
        )
    training = _Training(capture, start, config, held_out, device, rasterizer)
    if checkpoint is not None and checkpoint.exists():
        training.load(checkpoint)
    while not training.is_finished:
        training.step()
        if training.progress.step % config.check_every == 0:
            training.look()
            if checkpoint is not None:
                training.save(checkpoint)
        if report is not None and training.progress.step % 10 == 0:
            report(training.progress)
    return training.result()


def train_without_holes(
    capture: Capture, start: GaussianSplat, *arguments, **options
) -> Trained:
    """Trains a splat, and restores discs on surfaces that training lost.

    Arguments are those of `train`; see `fill_holes`.
    """
    trained = train(capture, start, *arguments, **options)
    splat = fill_holes(trained.capture, trained.splat, start)
    return dc.replace(trained, splat=splat)


class _Training:
    """The state of the optimisation, which a checkpoint contains completely."""

    def __init__(
        self,
        capture: Capture,
        start: GaussianSplat,
        config: TrainingConfig,
        held_out: np.ndarray | None,
        device: str,
        rasterizer: Rasterizer,
    ):
        self._config, self._rasterizer = config, rasterizer
        self._capture = capture
        if held_out is None:
            held_out = np.zeros(len(capture), bool)
        self._views = Views.of_capture(capture, device)
        self._trained = np.flatnonzero(~held_out)
        self._held_out = np.flatnonzero(held_out)
        self._identity = _identity(capture, start, config, held_out)
        self._order = np.random.default_rng(config.seed)
        self.discs = Discs(start, config.scale_limits).to(device)
        self.cameras = Cameras(capture.X_WC, config.deviations, ~held_out)
        self.cameras.to(device)
        self._optimizer = torch.optim.Adam(
            _rates(self.discs, self.cameras, config), eps=1e-15
        )
        self.progress = Progress(0, config.steps, math.nan, math.nan)
        self._least, self._idle = math.inf, 0

    @property
    def is_finished(self) -> bool:
        """Whether all steps are done, or recent steps made no progress."""
        return (
            self.progress.step >= self._config.steps
            or self._idle >= self._config.patience
        )

    def step(self):
        """Runs one step of Adam on a few views."""
        config, step = self._config, self.progress.step
        self._set_rates(config.final_rate ** (step / config.steps))
        moving = config.refine_cameras and step >= config.camera_start
        self.cameras.requires_grad_(moving)
        loss = self._loss(self._choose(self._trained, config.batch))
        self._optimizer.zero_grad(set_to_none=True)
        loss.backward()
        if moving and len(self._held_out):
            self._follow()
        self._optimizer.step()
        self.discs.clamp()
        if moving:
            self.cameras.hold_frame()
        # Reading the loss waits for the device, so it is read only when it is
        # shown.
        shown = loss.item() if (step + 1) % 10 == 0 else self.progress.loss
        self.progress = dc.replace(self.progress, step=step + 1, loss=shown)

    def _follow(self):
        """Optimises the pose of a held-out view for the present discs.

        The discs and the lens do not change, since they must not depend on the
        image of a held-out view.
        """
        poses = self.cameras.poses
        loss = self._loss(self._choose(self._held_out, 1))
        assert poses.grad is not None
        poses.grad += torch.autograd.grad(loss, poses)[0]

    def _choose(self, views: np.ndarray, count: int) -> Tensor:
        return torch.as_tensor(
            self._order.choice(views, min(count, len(views)), False)
        )

    def _set_rates(self, decay: float):
        for group in self._optimizer.param_groups:
            if "first_lr" in group:
                group["lr"] = group["first_lr"] * decay

    @torch.no_grad()
    def look(self):
        """Evaluates held-out views; records whether their loss decreases."""
        if not len(self._held_out):
            return
        each = [self._loss(torch.tensor([i])).item() for i in self._held_out]
        loss = float(np.mean(each))
        self.progress = dc.replace(self.progress, held_out=loss)
        gained = loss < self._least * (1 - self._config.least_gain)
        self._least = min(loss, self._least)
        self._idle = 0 if gained else self._idle + 1

    def result(self) -> Trained:
        """The present splat, and the cameras to which it is fitted."""
        splat = self.discs.splat(self._config.min_opacity)
        if not self._config.refine_cameras:
            return Trained(splat, self.progress, self._capture, np.zeros(COUNT))
        capture = self.cameras.capture(self._capture)
        return Trained(splat, self.progress, capture, self.cameras.errors)

    def _loss(self, index: Tensor) -> Tensor:
        config, discs, views = self._config, self.discs, self._views[index]
        if config.refine_cameras:
            views = self.cameras.corrected(views, index)
        rendered = self._rasterizer(discs, views)
        surface, normal, free_space = losses.disc_losses(
            discs, views, config.margin
        )
        depth = losses.depth_loss(discs, views, rendered, config.margin)
        return (
            losses.photometric_loss(rendered, views)
            + config.depth_weight * depth
            + config.surface_weight * surface
            + config.normal_weight * normal
            + config.free_space_weight * free_space
            + config.coverage_weight * losses.coverage_loss(rendered, views)
            + config.haze_weight * losses.haze_loss(discs)
            + config.prior_weight * self.cameras.prior(index)
        )

    def save(self, path: Path):
        """Writes the complete state for `load`, atomically."""
        buffer = io.BytesIO()
        torch.save(
            {
                "identity": self._identity,
                "discs": self.discs.state_dict(),
                "cameras": self.cameras.state_dict(),
                "optimizer": self._optimizer.state_dict(),
                "order": self._order.bit_generator.state,
                "progress": dc.asdict(self.progress),
                "least": self._least,
                "idle": self._idle,
            },
            buffer,
        )
        with atomic_write(path, "wb") as file:
            file.write(buffer.getvalue())

    def load(self, path: Path):
        """Restores the state that `save` has written."""
        try:
            state = torch.load(path, map_location="cpu", weights_only=True)
            identity = state["identity"]
        except Exception as error:  # torch raises many kinds.
            raise FileError(path, "is not a training checkpoint") from error
        if identity != self._identity:
            raise FileError(
                path,
                "belongs to another capture or other settings; remove the "
                "file to start again",
            )
        self.discs.load_state_dict(state["discs"])
        self.cameras.load_state_dict(state["cameras"])
        self._optimizer.load_state_dict(state["optimizer"])
        self._order.bit_generator.state = state["order"]
        self.progress = Progress(**state["progress"])
        self._least, self._idle = state["least"], state["idle"]


def _rates(
    discs: Discs, cameras: Cameras, config: TrainingConfig
) -> list[dict]:
    """Adam's parameter groups; the rates of centres and cameras decrease."""
    steady = (
        (discs.quaternions, config.rotation_rate),
        (discs.log_scales, config.scale_rate),
        (discs.logits, config.opacity_rate),
        (discs.colors, config.color_rate),
    )
    slowing = (
        (discs.p_WK, config.center_rate),
        (cameras.poses, config.pose_rate),
        (cameras.lens, config.lens_rate),
        (cameras.depth, config.lens_rate),
    )
    return [
        *({"params": [x], "lr": rate} for x, rate in steady),
        *({"params": [x], "lr": rate, "first_lr": rate} for x, rate in slowing),
    ]


def _identity(
    capture: Capture,
    start: GaussianSplat,
    config: TrainingConfig,
    held_out: np.ndarray,
) -> str:
    """A digest of all inputs that determine the result of a training."""
    digest = hashlib.sha256(repr(config).encode())
    arrays = [capture.X_WC, capture.K, capture.rgb, capture.depth]
    if capture.hidden is not None:
        arrays.append(capture.hidden)
    for array in arrays:
        digest.update(np.ascontiguousarray(array).tobytes())
    digest.update(start.content_hash.encode() + held_out.tobytes())
    return digest.hexdigest()
