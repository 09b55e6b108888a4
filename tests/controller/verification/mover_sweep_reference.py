"""The decisions of `mover_sweep.py`, sphere by sphere and mover by mover.

Slow, and without any shortcut: what tests hold the kernel against.
"""

import numpy as np
from verified_commands import at, tube_of

from remosplat_drake.controller.verification.kernels.between_samples import (
    bend_of,
    longest_way,
)
from remosplat_drake.controller.verification.kernels.places import PathArrays
from remosplat_drake.robot.robot_model import RobotModel
from remosplat_drake.scene.kernels.mover_reach import is_retreat, reach
from remosplat_drake.scene.mover import Mover, Movers


def keeps_off_movers(
    robot: RobotModel,
    path: PathArrays,
    movers: Movers,
    time: float,
    separation: float,
    tolerance: float,
) -> bool:
    """Tells whether all spheres keep off all movers on a path.

    Args:
        robot: The robot.
        path: The path of a command and its braking ramp.
        movers: What moves.
        time: When the path starts [s].
        separation: The distance to keep [m].
        tolerance: How far below its level a distance may fall between two
            samples [m].
    """
    tube = tube_of(robot, path)
    samples = at(path, np.append(0.0, path.times))
    p_WS = np.array([robot.spheres_at(q).p_WS for q in samples])
    spans = np.diff(path.times, prepend=0.0)
    speed = np.abs(path.rates).max(axis=0)
    for i, radius in enumerate(robot.spheres.radius):
        bend = bend_of(robot.hessian_bound[i], speed)
        way = np.array(
            [
                longest_way(p_WS[k, i], p_WS[k + 1, i], bend, span)
                for k, span in enumerate(spans)
            ]
        )
        if not way.any():
            continue
        for j in range(len(movers)):
            seen = _Seen(movers, j, time, np.append(0.0, path.clock), radius)
            kept, least = separation + tube[i], tolerance + tube[i]
            bent = bend * spans**2
            if not seen.is_kept(p_WS[:, i], way, bent, kept, least, tolerance):
                return False
    return True


class _Seen:
    """A mover at the samples of a path, as a sphere sees it.

    Args:
        movers: What moves.
        j: Which of these it is.
        time: When the path starts [s].
        clock: When the path is looked at, from 0 on, shape (s,) [s].
        radius: The sphere's radius [m].
    """

    def __init__(
        self,
        movers: Movers,
        j: int,
        time: float,
        clock: np.ndarray,
        radius: float,
    ):
        arrays = movers.at(time)
        self._mover, self._clock = movers.movers[j], clock
        self._reach = np.array([reach(arrays, j, t) for t in clock])
        self._X_WM = [self._mover.after(arrays.age + t) for t in clock]
        self._touching = radius + self._mover.radius

    def is_kept(
        self,
        p_WS: np.ndarray,
        way: np.ndarray,
        bent: np.ndarray,
        kept: float,
        least: float,
        tolerance: float,
    ) -> bool:
        """Tells whether the sphere is clear or retreats, from sample to sample.

        Args:
            p_WS: Its centre at the samples, shape (s, 3) [m].
            way: Bounds on its ways between them, shape (s - 1,) [m].
            bent: Bounds on how its velocity changes between them, times the
                time between, shape (s - 1,) [m].
            kept: The distance to keep, or the present one if that is less [m].
            least: What even that must be [m].
            tolerance: How far below that it may fall between two samples [m].
        """
        distance = [self._distance(k, p)[0] for k, p in enumerate(p_WS)]
        margin = np.array(distance) - min(kept, max(distance[0], least))
        last = 0
        for k in range(1, len(p_WS)):
            if way[k - 1] == 0.0:
                continue
            passed = self._clock[k] - self._clock[last]
            used = way[k - 1] + self._mover.speed * passed
            used += self._reach[k] - self._reach[last]
            is_clear = margin[k] >= 0.0
            is_clear &= margin[k] + margin[last] - used >= -2.0 * tolerance
            if not is_clear and not (
                self._retreats(last, k, p_WS, bent)
                and self._retreats(k, k, p_WS, bent)
            ):
                return False
            last = k
        return True

    def _distance(self, k: int, p_WS: np.ndarray) -> tuple[float, np.ndarray]:
        """Distance from wherever it can be at sample k, and the way to it."""
        far, n_W = core_distance(self._mover, self._X_WM[k], p_WS)
        return far - self._reach[k] - self._touching, n_W

    def _retreats(
        self, then: int, k: int, p_WS: np.ndarray, bent: np.ndarray
    ) -> bool:
        moved = p_WS[k] - p_WS[k - 1]
        aside_chord, aside_mean = bent[k - 1] / 8, bent[k - 1] / 2
        depth, ahead, aside = np.inf, -np.inf, 0.0
        for p in p_WS[k - 1 : k + 1]:
            far, n_W = core_distance(self._mover, self._X_WM[then], p)
            depth = min(depth, far - self._reach[k] - aside_chord)
            ahead = max(ahead, n_W @ moved)
            aside = max(aside, np.linalg.norm(moved - (n_W @ moved) * n_W))
        if depth <= 0.0:
            return False
        turned = aside_chord / depth * (np.linalg.norm(moved) + aside_mean)
        slack = float(aside_mean + turned)
        return is_retreat(
            depth, self._touching, ahead + slack, float(aside) + slack
        )


def core_distance(mover: Mover, X_WM, p_WS) -> tuple[float, np.ndarray]:
    """Computes the signed distance of a point from a mover's core.

    Args:
        mover: The mover.
        X_WM: Where it is.
        p_WS: The point, shape (3,) [m].

    Returns:
        The distance [m], and the unit vector towards the core in W, (3,).
    """
    p_M = X_WM.inverse().multiply(np.array(p_WS, float))
    outside = np.abs(p_M) - mover.half_extents
    if (outside > 0.0).any():
        gap = np.sign(p_M) * np.maximum(outside, 0.0)
        far = float(np.linalg.norm(gap))
        n_M = -gap / far
    else:
        # Inside, out by the nearest face.
        far, n_M = float(outside.max()), np.zeros(3)
        face = outside.argmax()
        n_M[face] = -np.copysign(1.0, p_M[face])
    return far, X_WM.rotation().multiply(n_M)
