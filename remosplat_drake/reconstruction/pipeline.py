"""`reconstruct`: from a capture to a splat with error bounds.

Surfels are placed on the measured surfaces and refined against all depth images
on the CPU. If there is a CUDA device, they are trained on colours and depth,
optionally with the cameras as unknowns. Then discs are added on surfaces that
no disc covers, and each disc gets an error bound.
"""

import dataclasses as dc
import time
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from remosplat_drake.base.errors import FieldError
from remosplat_drake.capture.capture import (
    MIN_VIEWS,
    Capture,
    check_reconstructible,
)
from remosplat_drake.reconstruction.alignment.camera_errors import COUNT
from remosplat_drake.reconstruction.alignment.pose_errors import PoseErrors
from remosplat_drake.reconstruction.devices import (
    AUTO,
    CUDA,
    NONE,
    choose_device,
)
from remosplat_drake.reconstruction.measured_space import (
    measured_points,
    scatter,
)
from remosplat_drake.reconstruction.surfels.point_cloud import (
    InitialisationConfig,
    initialise,
)
from remosplat_drake.reconstruction.surfels.refinement import (
    RefinementConfig,
    refine,
)
from remosplat_drake.reconstruction.surfels.seen_through import drop_floaters
from remosplat_drake.reconstruction.surfels.surfels import (
    Surfels,
    splat_of_surfels,
)
from remosplat_drake.reconstruction.uncertainty.bound import bound_splat
from remosplat_drake.splat.gaussian_splat import GaussianSplat

if TYPE_CHECKING:
    from remosplat_drake.reconstruction.training.training import Trained

_MARGIN_PER_SCATTER = 4.0
"""Margin between free space and surfaces, as a multiple of the measured points'
scatter around the surfaces.
"""

Report = Callable[[str, int, int], None]
"""Type of a callback for progress: it receives the name of the stage, the
number of completed steps, and the total number of steps."""


@dc.dataclass(frozen=True, eq=False)
class Reconstruction:
    """A reconstructed splat and how it was made.

    Attributes:
        splat: The splat in the capture's world frame, with the uncertainty of
            its discs if requested.
        method: Description of how the splat was made.
        seconds: Wall-clock time of the reconstruction [s].
        capture: The capture to which the splat was fitted: the given one, or
            the one with refined cameras.
        undone: Camera errors that training corrected, see `camera_errors`,
            shape (`COUNT`,).
    """

    splat: GaussianSplat
    method: str
    seconds: float
    capture: Capture
    undone: np.ndarray


def reconstruct(
    capture: Capture,
    device: str = AUTO,
    *,
    initialisation: InitialisationConfig | None = None,
    surfels: Surfels | None = None,
    refinement: RefinementConfig | None = None,
    looks: Capture | None = None,
    bounded: bool = False,
    errors: PoseErrors | None = None,
    steps: int = 500,
    seed: int = 0,
    refine_cameras: bool = False,
    held_out: np.ndarray | None = None,
    checkpoint: Path | None = None,
    report: Report = lambda stage, done, total: None,
) -> Reconstruction:
    """Reconstructs a Gaussian splat of 2DGS discs from a capture.

    Args:
        capture: Posed RGB-D images.
        device: One of `DEVICES`.
        initialisation: Settings of the initial surfels; None: the defaults.
        surfels: Surfels to start from, instead of an initialisation; with them,
            a single view suffices.
        refinement: Settings of the refinement; None: the defaults.
        looks: Views that may remove discs: a disc is removed if these views
            measure surfaces behind it, even if it comes from `surfels`. None
            removes no discs.
        bounded: Whether gaps between discs are closed and discs get an
            uncertainty.
        errors: Samples of the errors of the cameras, for the uncertainty; None
            assumes exact poses and depths.
        steps: Largest number of training steps.
        seed: Seed of the order of the images in training.
        refine_cameras: Whether training also optimises the cameras' poses, lens
            and depth curve. This needs a CUDA device.
        held_out: Mask of the views that are not used for training, and whose
            loss determines when training stops, shape (n,), bool.
        checkpoint: File to which training saves its state, so that it can
            continue after an interruption. It is removed at the end.
        report: Called with the progress, see `Report`.

    Raises:
        RemoSplatError: The capture or a setting is invalid.
    """
    device = choose_device(device)
    check_refinable(device, refine_cameras)
    check_reconstructible(capture, MIN_VIEWS if surfels is None else 1)
    start = time.perf_counter()
    if held_out is None:
        held_out = np.zeros(len(capture), bool)
    seen = capture.select(~held_out)
    report("surfels", 0, 1)
    if surfels is None:
        surfels = initialise(seen, initialisation)
    report("surfels", 1, 1)
    method = f"{len(surfels)} surfels from {len(seen)} views"
    undone = np.zeros(COUNT)
    if device == NONE:
        splat = splat_of_surfels(surfels)
    else:
        splat = refine(
            seen,
            surfels,
            refinement,
            lambda done, total: report("refining", done, total),
        )
        method += ", refined on the CPU"
    if device == CUDA:
        trained = _train(
            capture, splat, steps, seed, refine_cameras, held_out, checkpoint,
            report,
        )  # fmt: skip
        splat, capture, undone = trained.splat, trained.capture, trained.undone
        seen = capture.select(~held_out)
        steps = trained.progress.step
        method += f", trained by gsplat 2DGS on CUDA for {steps} steps"
        if refine_cameras:
            method += " with its cameras as unknowns"
    if looks is not None:
        splat = drop_floaters(looks, splat)
    if bounded:
        report("bounding", 0, 1)
        errors = None if errors is None else errors.of_views(~held_out)
        splat = bound_splat(seen, splat, errors).bounded_W
        report("bounding", 1, 1)
    seconds = time.perf_counter() - start
    return Reconstruction(splat, method, seconds, capture, undone)


def check_refinable(device: str, refine_cameras: bool):
    """Checks that the device can refine cameras, if this is requested.

    Args:
        device: The result of `choose_device`.
        refine_cameras: Whether the user requested it.

    Raises:
        FieldError: Refinement of cameras was requested, and training is not
            possible on this device.
    """
    if refine_cameras and device != CUDA:
        problem = (
            f"needs training on a CUDA device; the device is {device}: leave"
            " --refine-cameras out, or use a CUDA device"
        )
        raise FieldError("reconstruct", "--refine-cameras", problem)


def _train(
    capture: Capture,
    start: GaussianSplat,
    steps: int,
    seed: int,
    refine_cameras: bool,
    held_out: np.ndarray,
    checkpoint: Path | None,
    report: Report,
) -> "Trained":
    """Trains the splat; returns it and its cameras."""
    # Imported here because torch takes seconds, and may be missing.
    from remosplat_drake.reconstruction.training.training import (
        CAMERA_TRAINING,
        TrainingConfig,
        train_without_holes,
    )

    config = CAMERA_TRAINING if refine_cameras else TrainingConfig()
    # If views disagree, a surface must not become free space.
    few = capture.select(np.arange(0, len(capture), -(-len(capture) // 16)))
    surface_W = measured_points(few, *np.array([[-np.inf], [np.inf]]))
    margin = config.margin + _MARGIN_PER_SCATTER * scatter(surface_W)
    trained = train_without_holes(
        capture,
        start,
        dc.replace(config, steps=steps, seed=seed, margin=margin),
        held_out=held_out,
        checkpoint=checkpoint,
        report=lambda p: report("training", p.step, p.steps),
    )
    if checkpoint is not None:
        checkpoint.unlink(missing_ok=True)
    return trained
