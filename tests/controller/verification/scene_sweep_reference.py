"""The decisions of `map_sweep.py`, round by round in NumPy, of any map."""

import dataclasses as dc

import numpy as np
from verified_commands import at, spans

from remosplat_drake.controller.verification.kernels.between_samples import (
    longest_ways,
    margin_bounds,
)
from remosplat_drake.controller.verification.kernels.map_sweep import (
    PIECES,
    ROUNDS,
)
from remosplat_drake.controller.verification.kernels.path_samples import (
    sample_path,
)
from remosplat_drake.controller.verification.kernels.places import PathArrays
from remosplat_drake.robot.robot_model import RobotModel
from remosplat_drake.robot.sphere_model import Spheres
from remosplat_drake.signals.distance_field import DistanceField

Samples = tuple[np.ndarray, ...]
"""The arrays that `sample_path` returns."""


def sweeps_clear(
    robot: RobotModel,
    path: PathArrays,
    field: DistanceField,
    p_WS: np.ndarray,
    clearance: np.ndarray,
    level: np.ndarray,
    tolerance: np.ndarray,
) -> bool:
    """Tells whether all spheres keep their distance from a map on a path.

    Arguments are those of the kernel, with the map as a `DistanceField`.
    """
    margin = clearance - level
    near = np.arange(len(margin))
    if field.is_lipschitz:
        near = np.flatnonzero(~(sphere_travel(robot, path) < margin))
    if not len(near):
        return True
    start, margin = p_WS[near], margin[near]
    tolerance = tolerance[near]
    samples = sample_path(robot.arrays, path, near, start, margin, tolerance)
    sweep = _Sweep(
        robot,
        path,
        field,
        near,
        level[near],
        start,
        margin,
        samples[2],
        tolerance,
    )
    if not field.is_lipschitz:
        return sweep.is_clear_at_ends(samples)
    return sweep.is_clear(samples)


def sphere_travel(robot: RobotModel, path: PathArrays) -> np.ndarray:
    """Bounds the lengths of the spheres' ways on a path, (n,) [m]."""
    return (robot.jacobian_bound @ np.abs(path.rates).T) @ spans(path)


@dc.dataclass(frozen=True, eq=False)
class _Sweep:
    """The motion of n spheres along a path.

    Attributes:
        robot: The robot.
        path: The path of a command and its braking ramp.
        field: The map.
        sphere: Indices of the spheres, shape (n,).
        level: Clearance that each sphere must keep, shape (n,) [m].
        start: Centres of the spheres at the start, shape (n, 3) [m].
        margin: What the clearances have above their levels at the start, shape
            (n,) [m].
        bend: Bounds on how fast the spheres' velocities change, shape (n,)
            [m/s^2].
        tolerance: How far below zero each margin may fall between the path's
            times, shape (n,) [m].
    """

    robot: RobotModel
    path: PathArrays
    field: DistanceField
    sphere: np.ndarray
    level: np.ndarray
    start: np.ndarray
    margin: np.ndarray
    bend: np.ndarray
    tolerance: np.ndarray

    def is_clear_at_ends(self, samples: Samples) -> bool:
        """Tells whether clearances keep their levels at the path's times.

        Args:
            samples: The spheres along the path, as `sample_path` returns them.
        """
        point, R_WL = samples[:2]
        k, n = R_WL.shape[:2]
        gap = np.tile(np.arange(n), k)
        spheres = self._spheres(
            gap, point[1:].reshape(-1, 3), R_WL.reshape(-1, 3, 3)
        )
        margin = self._margin(spheres, self.level[gap], np.zeros(1))
        return bool((margin >= 0.0).all())

    def is_clear(self, samples: Samples) -> bool:
        """Tells whether they do on the whole path, less the tolerance.

        Args:
            samples: The spheres along the path, as `sample_path` returns them.
        """
        point, R_WL, _, way, margin, wanted = samples
        self._query(
            np.arange(len(self.margin)), point[1:], R_WL, margin, wanted
        )
        if not (margin >= 0.0).all():
            return False
        margin = np.concatenate([self.margin[None], margin])
        is_open = self._is_open(np.arange(len(self.start)), margin, way)
        if not is_open.any():
            return True
        place, gap = np.nonzero(is_open)
        ends = np.stack([place, place + 1])
        times = np.concatenate([[0.0], self.path.times])
        return self._is_clear_between(
            gap, times[ends], margin[ends, gap], point[ends, gap]
        )

    def _is_clear_between(
        self,
        gap: np.ndarray,
        time: np.ndarray,
        margin: np.ndarray,
        point: np.ndarray,
    ) -> bool:
        """Samples between two times, again and again, at e spheres.

        Args:
            gap: Which of the n spheres are looked at, shape (e,).
            time: Times before and after, shape (2, e) [s].
            margin: Margins at these times, shape (2, e) [m].
            point: Centres at these times, shape (2, e, 3) [m].
        """
        shares = np.linspace(0.0, 1.0, PIECES + 1)[1:-1, None]
        for _ in range(ROUNDS):
            span = (time[1] - time[0]) / PIECES
            between = time[0] + PIECES * shares * span
            gaps = np.tile(gap, len(shares))
            states, state = np.unique(between, return_inverse=True)
            spheres = self._place(states, state.ravel(), gaps)
            p_WS = spheres.p_WS.reshape(*between.shape, 3)
            point = np.concatenate([point[:1], p_WS, point[1:]])
            spans = np.tile(span, (PIECES, 1))
            way = longest_ways(point, spans, self.bend[gap])
            found, wanted = margin_bounds(
                p_WS,
                self.start[gap],
                self.margin[gap],
                way,
                self.tolerance[gap],
            )
            R_WL = spheres.R_WL.reshape(*between.shape, 3, 3)
            self._query(gap, p_WS, R_WL, found, wanted)
            if not (found >= -self.tolerance[gap]).all():
                return False
            time = np.concatenate([time[:1], between, time[1:]])
            margin = np.concatenate([margin[:1], found, margin[1:]])
            place, i = np.nonzero(self._is_open(gap, margin, way))
            if not len(place):
                return True
            ends = np.stack([place, place + 1])
            gap, time = gap[i], time[ends, i]
            margin, point = margin[ends, i], point[ends, i]
        return False

    def _is_open(
        self, gap: np.ndarray, margin: np.ndarray, way: np.ndarray
    ) -> np.ndarray:
        """Whether a margin may fall too low between samples, shape (k, n)."""
        return ~(margin[:-1] + margin[1:] - way >= -2.0 * self.tolerance[gap])

    def _spheres(
        self, gap: np.ndarray, p_WS: np.ndarray, R_WL: np.ndarray
    ) -> Spheres:
        """Makes `Spheres` of some of the n whose placement is known."""
        return self.robot.placed(self.sphere[gap], p_WS, R_WL)

    def _place(
        self, times: np.ndarray, state: np.ndarray, gap: np.ndarray
    ) -> Spheres:
        return self.robot.place_spheres(
            at(self.path, times), state, self.sphere[gap]
        )

    def _query(
        self,
        gap: np.ndarray,
        point: np.ndarray,
        R_WL: np.ndarray,
        margin: np.ndarray,
        wanted: np.ndarray,
    ) -> None:
        """Queries the map where the bound of a margin does not suffice.

        Args:
            gap: Which of the n spheres are looked at, shape (e,).
            point: Centres at each sample, shape (k, e, 3) [m].
            R_WL: Orientations of the spheres' links at each sample, shape
                (k, e, 3, 3).
            margin: Lower bounds of the margins, as `margin_bounds` has them,
                shape (k, e) [m]; the map's answers replace some of them.
            wanted: What a margin should exceed, as `margin_bounds` has it,
                shape (k, e) [m].
        """
        place, i = np.nonzero(~(margin > wanted))
        if len(place):
            spheres = self._spheres(gap[i], point[place, i], R_WL[place, i])
            margin[place, i] = self._margin(
                spheres, self.level[gap[i]], wanted[place, i]
            )

    def _margin(
        self, spheres: Spheres, level: np.ndarray, wanted: np.ndarray
    ) -> np.ndarray:
        """Queries margins, exact below `wanted`, at least it above."""
        reach = level.max() + wanted.max()
        # Not at the distance itself: rows there are left out.
        found = self.field.clearances(spheres, np.nextafter(reach, np.inf))
        return np.minimum(found.per_sphere(len(spheres)), reach) - level
