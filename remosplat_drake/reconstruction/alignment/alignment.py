"""`align`: poses, depth scale and offset, refined from the depth images."""

import dataclasses as dc
from collections.abc import Callable

import numpy as np

from remosplat_drake.capture.capture import Capture
from remosplat_drake.reconstruction.alignment.odometry_prior import (
    OdometryNoise,
    estimate_noise,
)
from remosplat_drake.reconstruction.alignment.pair_selection import choose_pairs
from remosplat_drake.reconstruction.alignment.solver import (
    Level,
    Posterior,
    State,
    equations,
    estimate_redundancy,
    posterior,
    residual_spread,
)
from remosplat_drake.reconstruction.alignment.view_stack import (
    SAMPLES,
    stack_views,
)

LEVELS = (
    Level(0.15, 0.05, 0.7, 4),
    Level(0.10, 0.02, 0.75, 4),
    Level(0.05, 0.008, 0.8, 4),
    Level(0.03, 0.003, 0.85, 5),
    Level(0.03, 0.0, 0.85, 8),
)
"""From coarse to fine."""


@dc.dataclass(frozen=True)
class AlignmentConfig:
    """What is known before, and how much is compared."""

    depth_scale_std: float = 0.02
    depth_offset_std: float = 0.003
    partners: int = 16
    samples: int = SAMPLES
    seed: int = 0


@dc.dataclass(frozen=True, eq=False)
class Alignment:
    capture: Capture
    scale: float
    offset: float
    covariance: np.ndarray
    noise: OdometryNoise
    redundancy: float


def align(
    capture: Capture,
    config: AlignmentConfig | None = None,
    report: Callable[[int, int], None] = lambda done, total: None,
    log=None,
) -> Alignment:
    """Refines poses, one depth scale and one offset."""
    config = config or AlignmentConfig()
    stack = stack_views(capture, config.samples, config.seed)
    given = capture.X_WC
    state = State(given)
    camera_precision = np.diag(
        [config.depth_scale_std**-2, config.depth_offset_std**-2]
    )
    noise = OdometryNoise()
    redundancy = 10.0
    result = None
    for number, level in enumerate(LEVELS):
        report(number, len(LEVELS))
        pairs = choose_pairs(
            stack, state.X_WC, state.scale, state.offset, level.gate,
            level.least_cosine, config.partners,
        )  # fmt: skip
        for iteration in range(level.steps):
            spread = residual_spread(stack, state, pairs, level)
            data = equations(stack, state, pairs, level, spread)
            x = state.unknowns(given)
            if iteration and number >= 3:
                result = posterior(data, x, noise, camera_precision, redundancy)
                redundancy = estimate_redundancy(data, result, default=10.0)
            H = data.H / redundancy
            h = H @ x - data.g / redundancy
            if iteration == 2 and number >= 3:
                noise = estimate_noise(H, h, camera_precision, noise)
            result = posterior(data, x, noise, camera_precision, redundancy)
            step = result.mean - x
            state = state.moved(step)
            size = np.abs(step[:-2].reshape(-1, 2, 3)).max(axis=(0, 2))
            if log:
                log(number, iteration, len(pairs), data.count.sum(), spread, redundancy, size, state, noise)
            if iteration > 1 and size.max() < 1e-6:
                break
    z = capture.depth
    depth = np.where(z > 0, state.scale * z + state.offset, 0)
    refined = dc.replace(
        capture, X_WC=state.X_WC, depth=np.maximum(depth, 0).astype(np.float32)
    )
    return Alignment(
        refined, state.scale, state.offset, result.covariance, noise, redundancy
    )
