"""`Tracker`: the poses of a hand-held camera from a simulated tracker."""

from collections.abc import Callable

import numpy as np
from scipy.spatial.transform import Rotation

from apps.studies.map_bound.disturbance import TURN, SmoothCurve
from apps.studies.true_maps.disturbance import Disturbance
from apps.studies.true_maps.walk import Walk
from remosplat_drake.reconstruction.alignment.perturbation import difference

_CLOSED = 0.8
"""Fraction of the walk after which a late loop is closed."""

_STEP, _LONG_STEP = 1e-4, 1e-2
"""Time steps of the differences for velocities and for accelerations [s]."""


class Tracker:
    """Tracks a camera's walk, with the errors of a disturbance.

    Args:
        walk: The camera's path.
        time: Times of the images, shape (n,) [s]; poses jump between them.
        what: The errors of the tracker.
        seed: Seed of all random numbers.
    """

    def __init__(
        self, walk: Walk, time: np.ndarray, what: Disturbance, seed: int
    ):
        rng = np.random.default_rng([seed, 2])
        self._walk, self._time = walk, time
        drift = self._slip(what.drift, lambda part: part, rng)
        closed = self._between(_CLOSED)
        loop = self._slip(
            what.late_loop,
            lambda part: np.where(part < closed, part / closed, 0),
            rng,
        )
        jumped = self._between(rng.uniform(0.2, 0.8))
        jump = self._slip(
            what.jump, lambda part: np.where(part < jumped, 0, 1), rng
        )
        self._slips = drift, loop, jump
        hand, turn = rng.standard_normal((2, 3))
        turn *= what.hand_eye_turn / np.linalg.norm(turn)
        self._X_CD = np.eye(4)
        self._X_CD[:3, :3] = Rotation.from_rotvec(turn).as_matrix()
        self._X_CD[:3, 3] = what.hand_eye / np.linalg.norm(hand) * hand

    def X_WC(self, time: np.ndarray) -> np.ndarray:
        """Returns the tracked poses at times (n,) [s], (n, 4, 4)."""
        part = (time - self._time[0]) / (self._time[-1] - self._time[0])
        slips = [slip(part) for slip in self._slips]
        shift, turn = np.sum(slips, axis=0)
        X_WC = self._walk.X_WC(time)
        R = Rotation.from_rotvec(turn).as_matrix()
        X_WC[:, :3, :3] = R @ X_WC[:, :3, :3]
        X_WC[:, :3, 3] += shift
        return X_WC @ self._X_CD

    def _between(self, part: float) -> float:
        """Fraction of the walk half-way between two images around another."""
        steps = len(self._time) - 1
        return (np.floor(part * steps) + 0.5) / steps

    @staticmethod
    def _slip(
        length: float,
        progress: Callable[[np.ndarray], np.ndarray],
        rng: np.random.Generator,
    ) -> Callable[[np.ndarray], np.ndarray]:
        """Drift of positions and of rotations, by fraction of the walk.

        Args:
            length: Final length of the drift [m].
            progress: Share of the final drift, by fraction of the walk.
            rng: Source of randomness.
        """
        way, turn = SmoothCurve.drawn(rng), SmoothCurve.drawn(rng)

        def slip(part: np.ndarray) -> np.ndarray:
            done = progress(part)
            return length * np.stack([way(done), TURN * turn(done)])

        return slip


def velocity_W(
    X_WC: Callable[[np.ndarray], np.ndarray], time: np.ndarray
) -> np.ndarray:
    """Returns angular velocities [rad/s], then those of centres [m/s], in W.

    Args:
        X_WC: Poses at times (n,), shape (n, 4, 4).
        time: The times, shape (n,) [s].

    Returns:
        Shape (n, 6).
    """
    before, after = X_WC(time - _STEP), X_WC(time + _STEP)
    return difference(after, before) / (2 * _STEP)


def acceleration_W(
    X_WC: Callable[[np.ndarray], np.ndarray], time: np.ndarray
) -> np.ndarray:
    """Returns the derivatives of the velocities; see `velocity_W`."""
    before, after = (
        velocity_W(X_WC, time + step) for step in (-_LONG_STEP, _LONG_STEP)
    )
    return (after - before) / (2 * _LONG_STEP)
