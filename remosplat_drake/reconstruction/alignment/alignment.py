"""`align`: poses, depth scale and offset, refined from the depth images.

Views that share surfaces, near and far from each other, must have them in one
place. All poses, one scale and one offset of the depth are refined together by
Gauss-Newton, point to plane, from coarse to fine, and held by what the given
poses are: an odometry whose noise and drift the data themselves tell.
"""

import dataclasses as dc
from collections.abc import Callable

import numpy as np
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from remosplat_drake.capture.capture import Capture
from remosplat_drake.reconstruction.alignment.measured_length import (
    Length,
    add_length,
)
from remosplat_drake.reconstruction.alignment.odometry_prior import (
    OdometryNoise,
    estimate_noise,
    plausible_noise,
)
from remosplat_drake.reconstruction.alignment.pair_selection import choose_pairs
from remosplat_drake.reconstruction.alignment.perturbation import perturbed
from remosplat_drake.reconstruction.alignment.residual_table import (
    ResidualRow,
    distances_of_pairs,
    is_better,
    residual_rows,
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
    ViewStack,
    stack_views,
)

COARSE = (
    Level(0.15, 0.05, 0.7, 3),
    Level(0.10, 0.02, 0.75, 3),
    Level(0.05, 0.008, 0.8, 3),
)
FINE = (Level(0.03, 0.003, 0.85, 4), Level(0.03, 0.0, 0.85, 5))
"""From coarse to fine; the fine levels estimate what noise the poses have."""

_CORRELATION = 10.0
"""Residuals that say as much as one, until the data tell better."""

_HELD_OUT = 7
"""Every so many pairs, in order of their distance, only judge."""

_UNTOLD = np.array([0.003, 0.003])
"""Scale and offset [m] that are not told from none: noise hides that surfaces
are curved, and the planes in their place lie too deep."""

_CONVERGED = 2e-6
"""Steps below end a level [rad, m]."""


@dc.dataclass(frozen=True)
class AlignmentConfig:
    """What is known before, and how much is compared.

    Attributes:
        depth_scale_std: Standard deviation of the sensor's scale, as its
            specification has it.
        depth_offset_std: Standard deviation of the sensor's offset [m].
        odometry: Noise of the given poses; None: estimated.
        lengths: Measured lengths.
        partners: Views that each view is compared with, about.
        samples: Points of each view that are compared.
        seed: Seed of the choice of points.
    """

    depth_scale_std: float = 0.02
    depth_offset_std: float = 0.003
    odometry: OdometryNoise | None = None
    lengths: tuple[Length, ...] = ()
    partners: int = 16
    samples: int = SAMPLES
    seed: int = 0


@dc.dataclass(frozen=True, eq=False)
class Alignment:
    """A capture whose views agree, and how well its cameras are known.

    The unknowns are theta_W [rad] and t_W [m] of each view, one after the
    other, then scale and offset [m]: the true pose is exp(theta_W) R_WC,
    p_WC + t_W, the true depth (1 + ds) z + do of the returned capture's z (to
    first order).

    Attributes:
        capture: The refined capture, or the given one if it was not accepted.
        scale: Factor by which measured depths were multiplied.
        offset: What was added to them then [m].
        error: Expected value of the unknowns: 0 if accepted, else the
            refinement that was not made, shape (6n + 2,).
        covariance: Their covariance, shape (6n + 2, 6n + 2).
        noise: Noise of the given poses.
        shared: How many residuals said as much as an independent one.
        rows: Residuals before and after by distance of the views; the same
            twice if the refinement was not accepted.
        groups: Number of groups of views that share no surface.
        accepted: Whether pairs of views that were not used agree better.
    """

    capture: Capture
    scale: float
    offset: float
    error: np.ndarray
    covariance: np.ndarray
    noise: OdometryNoise
    shared: float
    rows: list[ResidualRow]
    groups: int
    accepted: bool

    @property
    def scale_std(self) -> float:
        """Standard deviation of the scale."""
        return float(np.sqrt(self.covariance[-2, -2]))

    @property
    def offset_std(self) -> float:
        """Standard deviation of the offset [m]."""
        return float(np.sqrt(self.covariance[-1, -1]))

    def draws(self, count: int = 64, seed: int = 0) -> np.ndarray:
        """Draws errors of all unknowns from what is known of them.

        Returns:
            Shape (count, 6n + 2).
        """
        values, vectors = np.linalg.eigh(self.covariance)
        root = vectors * np.sqrt(np.maximum(values, 0))
        normal = np.random.default_rng(seed).standard_normal((count, len(root)))
        return self.error + normal @ root.T


def align(
    capture: Capture,
    config: AlignmentConfig | None = None,
    report: Callable[[int, int], None] = lambda done, total: None,
) -> Alignment:
    """Refines poses, one depth scale and one depth offset of a capture.

    Args:
        capture: Posed RGB-D images; the order is that in which they were taken.
        config: Settings; None takes the defaults.
        report: Called with the steps done and the steps in all.

    Raises:
        FieldError: A measured length names no pixel with a depth.
    """
    config = config or AlignmentConfig()
    stack = stack_views(capture, config.samples, config.seed)
    start = State(capture.X_WC)
    refinement = _Refinement(capture, stack, config)
    result, state = refinement.run(report)
    pairs = refinement.pairs
    held_out = _held_out(state, pairs)
    if not held_out.any():
        held_out[:] = True
    before = distances_of_pairs(stack, start, pairs)
    after = distances_of_pairs(stack, state, pairs)
    accepted = bool(config.lengths) or is_better(
        before[held_out], after[held_out]
    )
    rest = result.mean - state.unknowns(capture.X_WC)
    if accepted:
        moved = dc.replace(capture, X_WC=state.X_WC)
        capture = moved.with_depth(state.scale, state.offset)
        error = rest
    else:
        error, after = result.mean, before
    return Alignment(
        capture=capture,
        scale=state.scale if accepted else 1.0,
        offset=state.offset if accepted else 0.0,
        error=error,
        covariance=result.covariance,
        noise=result.noise,
        shared=refinement.shared,
        rows=residual_rows(state.X_WC, pairs, before, after),
        groups=_groups(len(capture), pairs),
        accepted=accepted,
    )


class _Refinement:
    """The levels from coarse to fine, and what they carry along."""

    def __init__(
        self, capture: Capture, stack: ViewStack, config: AlignmentConfig
    ):
        self.given = capture.X_WC
        self.stack, self.config = stack, config
        self.pairs = np.zeros((0, 2), np.int64)
        self.shared = 1.0
        self._points_C = [length.points_C(capture) for length in config.lengths]
        self._noise = config.odometry or OdometryNoise()
        self._correlation = _CORRELATION

    def run(
        self, report: Callable[[int, int], None]
    ) -> tuple[Posterior, State]:
        """Returns the solution and the state that it was linearised at."""
        state, result = State(self.given), None
        levels = (*COARSE, *FINE)
        for number, level in enumerate(levels):
            report(number, len(levels))
            self._choose(state, level)
            used = self.pairs[~_held_out(state, self.pairs)]
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
                if np.abs(step[:-2]).max(initial=0.0) < _CONVERGED:
                    break
        assert result is not None
        state = self._simplest(result, state)
        return self._doubted(result, state, levels[-1]), state

    def _simplest(self, result: Posterior, state: State) -> State:
        """The state, without a scale and offset that are next to none.

        The poses are then those that go with the depth as it was measured, by
        the joint normal distribution of all unknowns.
        """
        found, C = result.mean[-2:], result.covariance
        if self.config.lengths or np.linalg.norm(found / _UNTOLD) > 1:
            return state
        gain = np.linalg.solve(C[-2:, -2:], C[-2:]).T
        held = (result.mean - gain @ found)[:-2]
        return State(perturbed(self.given, held.reshape(-1, 6)))

    def _doubted(
        self, result: Posterior, state: State, level: Level
    ) -> Posterior:
        """The solution, with the covariance of the largest likely noise."""
        if self.config.odometry is not None:
            return result
        used = self.pairs[~_held_out(state, self.pairs)]
        data, x = self._data(state, used, level), state.unknowns(self.given)
        known = self._known(x, state)
        H, g = data.H + known[0], data.g + known[1]
        noise = plausible_noise(H, H @ x - g, result.noise)
        doubt = posterior(data, x, noise, known).covariance
        return dc.replace(result, covariance=doubt)

    def _choose(self, state: State, level: Level):
        self.pairs = choose_pairs(
            self.stack, state.X_WC, state.scale, state.offset, level.gate,
            level.least_cosine, self.config.partners,
        )  # fmt: skip

    def _data(self, state: State, pairs: np.ndarray, level: Level) -> Equations:
        spread = residual_spread(self.stack, state, pairs, level)
        return equations(
            self.stack, state, pairs, level, spread, self._correlation
        )

    def _known(self, x: np.ndarray, state: State) -> tuple:
        """Matrix and gradient of the sensor's specification and lengths."""
        H, g = np.zeros((len(x), len(x))), np.zeros(len(x))
        deviations = self.config.depth_scale_std, self.config.depth_offset_std
        for index, deviation in zip((-2, -1), deviations, strict=True):
            H[index, index] = deviation**-2
            g[index] = H[index, index] * x[index]
        for length, p_C in zip(
            self.config.lengths, self._points_C, strict=True
        ):
            add_length(length, p_C, state, H, g)
        return H, g

    def _solve(self, data: Equations, x: np.ndarray, state: State) -> Posterior:
        known = self._known(x, state)
        return posterior(data, x, self._noise, known)

    def _learn(
        self, data: Equations, x: np.ndarray, state: State, noise_too: bool
    ):
        """Estimates the data's redundancy and the noise of given poses."""
        result = self._solve(data, x, state)
        self._correlation = estimate_correlation(
            data, result, default=_CORRELATION
        )
        if not noise_too or self.config.odometry is not None:
            return
        H, g = self._known(x, state)
        H, g = H + data.H, g + data.g
        self._noise = estimate_noise(H, H @ x - g, self._noise)


def _held_out(state: State, pairs: np.ndarray) -> np.ndarray:
    """Which pairs only judge: some of all distances, if there are enough."""
    held_out = np.zeros(len(pairs), bool)
    if len(pairs) >= 3 * _HELD_OUT:
        p_WC = state.X_WC[:, :3, 3]
        apart = np.linalg.norm(p_WC[pairs[:, 0]] - p_WC[pairs[:, 1]], axis=1)
        held_out[
            np.argsort(apart, kind="stable")[_HELD_OUT - 2 :: _HELD_OUT]
        ] = True
    return held_out


def _groups(n: int, pairs: np.ndarray) -> int:
    """Number of groups of views that no pair joins."""
    ones = np.ones(len(pairs))
    graph = coo_array((ones, (pairs[:, 0], pairs[:, 1])), shape=(n, n))
    return int(connected_components(graph, directed=False)[0])
