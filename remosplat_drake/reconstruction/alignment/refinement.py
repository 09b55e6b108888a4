"""`Refinement`: runs the rounds of an alignment, each from coarse to fine.

After each round, images are corrected by the camera errors that have been
estimated so far.
"""

import dataclasses as dc
from collections.abc import Callable

import numpy as np

from remosplat_drake.capture.capture import Capture
from remosplat_drake.reconstruction.alignment.camera_correction import (
    corrected,
    delay_of_motion,
)
from remosplat_drake.reconstruction.alignment.camera_errors import (
    COUNT,
    DELAY,
    CameraPrior,
)
from remosplat_drake.reconstruction.alignment.measured_length import (
    Length,
    add_length,
)
from remosplat_drake.reconstruction.alignment.odometry_prior import (
    OdometryNoise,
    estimate_noise,
    plausible_noise,
)
from remosplat_drake.reconstruction.alignment.pair_kernel import POSE
from remosplat_drake.reconstruction.alignment.pair_selection import choose_pairs
from remosplat_drake.reconstruction.alignment.perturbation import (
    difference,
    perturbed,
)
from remosplat_drake.reconstruction.alignment.solver import (
    Equations,
    Level,
    Posterior,
    State,
    equations,
    estimate_correlation,
    posterior,
    residual_spread,
)
from remosplat_drake.reconstruction.alignment.view_stack import (
    SAMPLES,
    stack_views,
)

COARSE = (
    Level(0.15, 0.05, 0.7, 3),
    Level(0.10, 0.02, 0.75, 3),
    Level(0.05, 0.008, 0.8, 3),
)
FINE = (Level(0.03, 0.003, 0.85, 4), Level(0.03, 0.0, 0.85, 5))
"""Coarse stages and fine stages of the refinement. The fine ones also estimate
the noise of the poses.
"""

_CORRELATION = 10.0
"""Initial estimate of the number of correlated residuals that have as much
information as one independent residual.
"""

_HELD_OUT = 7
"""Step between held-out pairs of views, when pairs are sorted by distance."""

_ROUNDS = 3
"""At most this many rounds of correction and refinement are made."""

_UNDETECTABLE = np.array(
    [0.003, 0.003, 0.002, 0.002, 0.002, 0.003, 0.003, 0.01, 0.03]
    + [0.005, 0.004]
    + 3 * [np.deg2rad(0.1)]
    + 3 * [0.002]
)
"""Camera errors below these sizes cannot be distinguished from zero. The order
is that of `camera_errors`. Noise can cause estimates of these sizes, because it
hides the curvature of surfaces, and the fitted planes are then too deep.
"""

_UNEXPLAINED = 0.2
"""A delay is accepted if, after its correction, less than this fraction of the
sum of squared pose errors remains.
"""

_SIGNIFICANT = 3.0
"""An error is significant if it exceeds this number of standard deviations."""

_CONVERGED = 2e-6
"""A stage of the refinement ends when its steps are below this [rad, m]."""

_EXACT = 1e-7
"""The equations use this standard deviation for a number that is exact."""


@dc.dataclass(frozen=True)
class AlignmentConfig:
    """Settings of `align`: prior knowledge, and numbers of points and views.

    Attributes:
        camera: Prior of the camera's errors.
        odometry: Noise of the given poses; None: it is estimated.
        lengths: Manually measured lengths, which determine the scale.
        partners: Approximate number of views with which each view is compared.
        samples: Number of points of each view that are compared.
        seed: Seed of the random choice of points.
    """

    camera: CameraPrior = dc.field(default_factory=CameraPrior)
    odometry: OdometryNoise | None = None
    lengths: tuple[Length, ...] = ()
    partners: int = 16
    samples: int = SAMPLES
    seed: int = 0


class Refinement:
    """Runs the rounds of an alignment, and holds their state.

    Attributes:
        capture: The given capture.
        config: Prior knowledge, and the number of comparisons.
        image: The capture, corrected for the camera errors that were estimated
            so far.
        stack: The views of `image`, as arrays.
        pairs: Pairs of views that are compared, shape (p, 2).
        shared: Number of residuals that have as much information as one
            independent residual.
    """

    def __init__(self, capture: Capture, config: AlignmentConfig):
        self.capture, self.config = capture, config
        self.image = capture
        self.stack = stack_views(capture, config.samples, config.seed)
        self.pairs = np.zeros((0, 2), np.int64)
        self.shared = 1.0
        self._prior = config.camera.deviations()
        self._expected = np.zeros(COUNT)
        self._noise = config.odometry or OdometryNoise()
        self._correlation = _CORRELATION

    @property
    def given(self) -> np.ndarray:
        """Given poses, corrected for the estimated camera errors, (n, 4, 4)."""
        return self.image.X_WC

    def run(
        self, report: Callable[[int, int], None]
    ) -> tuple[Posterior, State]:
        """Returns the solution, and the state at which it was linearised."""
        state = State(self.given, np.zeros(COUNT), np.zeros(COUNT))
        levels, steps = (*COARSE, *FINE), len(COARSE) + _ROUNDS * len(FINE)
        done = 0
        for _ in range(_ROUNDS):
            result, state = self._refined(state, levels, done, steps, report)
            state, done = self._simplest(result, state), done + len(levels)
            delay = self._taken_delay(state)
            if not delay and (np.abs(state.left) <= 0.5 * _UNDETECTABLE).all():
                break
            state, levels = self.freed(state, delay), FINE
        return self._doubted(result, state, FINE[-1]), state

    def _taken_delay(self, state: State) -> float:
        """Returns the images' delay that appears as motion of the poses [s].

        If the camera moves smoothly, the effect of a delay resembles a smooth
        drift, which the prior hardly penalises. But unlike a drift, the effect
        is proportional to the camera's velocity.
        """
        if not self._prior[DELAY]:
            return 0.0
        motion = difference(state.X_WC, self.given)
        delay, left = delay_of_motion(self.capture, motion)
        if abs(delay) < _UNDETECTABLE[DELAY] or left > _UNEXPLAINED:
            return 0.0
        self._expected[DELAY] = state.errors[DELAY] + delay
        self._prior[DELAY] = _UNDETECTABLE[DELAY]
        return delay

    def _refined(
        self,
        state: State,
        levels: tuple[Level, ...],
        done: int,
        steps: int,
        report: Callable[[int, int], None],
    ) -> tuple[Posterior, State]:
        """Solves for all unknowns with the images as corrected so far."""
        result = None
        for number, level in enumerate(levels):
            report(done + number, steps)
            self._choose(state, level)
            used = self.pairs[~held_out(state, self.pairs)]
            for iteration in range(level.steps):
                data = self._data(state, used, level)
                self.shared = (
                    float(np.median(data.shared)) if len(used) else 1.0
                )
                x = state.unknowns(self.given)
                if level in FINE and iteration > 0:
                    self._learn(data, x, state, iteration == 2)
                result = self._solve(data, x, state)
                step = result.mean - x
                state = state.moved(step)
                if np.abs(step).max(initial=0.0) < _CONVERGED:
                    break
        assert result is not None
        return result, state

    def freed(self, state: State, delay: float = 0.0) -> State:
        """Corrects the images for the estimated errors of the camera.

        Returns the new state.

        Args:
            state: The state before this correction.
            delay: The part of the images' delay that appears as errors of the
                state's poses [s].
        """
        errors = state.errors.copy()
        errors[DELAY] += delay
        if np.array_equal(errors, state.undone):
            return state
        motion = difference(state.X_WC, self.given)
        if self.capture.velocity_W is not None:
            motion -= delay * self.capture.velocity_W
        self.image = corrected(self.capture, errors)
        self.stack = stack_views(
            self.image, self.config.samples, self.config.seed
        )
        return State(perturbed(self.given, motion), errors, errors.copy())

    def _simplest(self, result: Posterior, state: State) -> State:
        """Returns the state with insignificant camera errors set to zero.

        The other unknowns are conditioned on these being zero, by the joint
        normal distribution; see `Posterior.camera_without`.
        """
        if self.config.lengths:
            return state
        none, bias = np.zeros(COUNT, bool), np.zeros(COUNT)
        while True:
            errors, deviation = result.camera_without(none, bias)
            noise = _SIGNIFICANT * deviation
            limit = np.maximum(_UNDETECTABLE, noise)
            ratio = np.where(none, np.inf, np.abs(errors) / limit)
            least = int(ratio.argmin())
            if ratio[least] >= 1:
                break
            none[least] = True
            # Only the part of the estimate that noise cannot explain counts.
            square = errors[least] ** 2 - noise[least] ** 2
            bias[least] = np.sqrt(max(square, 0.0))
        poses = result.poses_with(errors)
        return State(perturbed(self.given, poses), errors, state.undone)

    def _doubted(
        self, result: Posterior, state: State, level: Level
    ) -> Posterior:
        """The solution, with the covariance of the largest plausible noise."""
        if self.config.odometry is not None:
            return result
        used = self.pairs[~held_out(state, self.pairs)]
        data, x = self._data(state, used, level), state.unknowns(self.given)
        known = self._known(x, state)
        H, g = data.H + known[0], data.g + known[1]
        views = len(self.given)
        noise = plausible_noise(H, H @ x - g, views, result.noise)
        doubt = posterior(data, x, views, noise, known).covariance
        return dc.replace(result, covariance=doubt)

    def _choose(self, state: State, level: Level):
        self.pairs = choose_pairs(
            self.stack, state.X_WC, state.left, level.gate,
            level.least_cosine, self.config.partners,
        )  # fmt: skip

    def _data(self, state: State, pairs: np.ndarray, level: Level) -> Equations:
        spread = residual_spread(self.stack, state, pairs, level)
        return equations(
            self.stack, state, pairs, level, spread, self._correlation
        )

    def _known(self, x: np.ndarray, state: State) -> tuple:
        """Returns matrix and gradient of the camera's prior and of lengths."""
        H, g = np.zeros((len(x), len(x))), np.zeros(len(x))
        own = np.arange(len(x) - COUNT, len(x))
        H[own, own] = np.maximum(self._prior, _EXACT) ** -2
        g[own] = H[own, own] * (x[own] - self._expected)
        for length in self.config.lengths:
            add_length(length, self.capture, state, H, g)
        return H, g

    def _solve(self, data: Equations, x: np.ndarray, state: State) -> Posterior:
        known = self._known(x, state)
        return posterior(data, x, len(self.given), self._noise, known)

    def _learn(
        self, data: Equations, x: np.ndarray, state: State, noise_too: bool
    ):
        """Estimates the residuals' correlation and the noise of poses."""
        result = self._solve(data, x, state)
        self._correlation = estimate_correlation(
            data, result, default=_CORRELATION
        )
        if not noise_too or self.config.odometry is not None:
            return
        H, g = self._known(x, state)
        H, g = H + data.H, g + data.g
        views = len(self.given)
        motion = result.mean[: POSE * views].reshape(views, POSE)
        starts = self._noise, OdometryNoise.of_motions(motion)
        self._noise = estimate_noise(H, H @ x - g, views, starts)


def held_out(state: State, pairs: np.ndarray) -> np.ndarray:
    """Selects held-out pairs, evenly spread over all distances.

    No pair is held out if there are too few pairs.
    """
    held_out = np.zeros(len(pairs), bool)
    if len(pairs) >= 3 * _HELD_OUT:
        p_WC = state.X_WC[:, :3, 3]
        apart = np.linalg.norm(p_WC[pairs[:, 0]] - p_WC[pairs[:, 1]], axis=1)
        held_out[
            np.argsort(apart, kind="stable")[_HELD_OUT - 2 :: _HELD_OUT]
        ] = True
    return held_out
