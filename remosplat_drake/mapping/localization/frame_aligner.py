"""`FrameAligner`: aligns a session's frames, and keeps what it has prepared."""

import dataclasses as dc

import numpy as np

from remosplat_drake.capture.capture import Capture
from remosplat_drake.mapping.localization.keyframe_graph import (
    LEVELS,
    REFINING,
    Drift,
    Keyframes,
    best_start,
    misfit,
    slides,
    solve,
)
from remosplat_drake.mapping.localization.planar_pose import (
    composed,
    matrix,
    odometry_frame,
    relative,
)
from remosplat_drake.mapping.mapping_config import MappingConfig
from remosplat_drake.reconstruction.alignment.plane_maps import (
    PlaneMap,
    plane_map,
)
from remosplat_drake.reconstruction.alignment.view_stack import (
    empty_stack,
    put_view,
)
from remosplat_drake.robot.robot_model import RobotModel
from remosplat_drake.signals.base_correction import BaseCorrection

_SAMPLES = 300
"""Points of a frame that are compared with others."""

_NEIGHBOURS = 8
"""Keyframes that a new one is compared with before it joins the graph."""

_MOST_DEVIATIONS = 4.0
"""Corrections beyond so many standard deviations of the odometry are none."""

_FARTHEST = 0.25
"""Greatest distance at which a frame is searched for [m]."""

_TRUSTED = 0.004
"""Standard deviation of a base's position that does no harm [m]."""

_LARGEST_MISFIT = 0.01
"""Median distance of a frame's surfaces from the others' that is no noise [m].
"""

_OTHER_RUN = 30.0
"""Time whose drift stands for what happened between two runs [s]."""

Key = tuple[str, float]
"""A frame's name and time: names are given again."""


@dc.dataclass(frozen=True, eq=False)
class Aligned:
    """Where a session's frames were taken.

    Attributes:
        X_WC: Poses of the cameras (OpenCV axes), shape (n, 4, 4).
        corrections: Where the odometry's frame was at each of them.
        residual: Median distance of each frame's surfaces from those of the
            others, shape (n,) [m]; NaN where it shares none.
        problems: What is wrong with frames that cannot be explained, for
            people, by their indices.
    """

    X_WC: np.ndarray
    corrections: list[BaseCorrection]
    residual: np.ndarray
    problems: dict[int, str]

    @staticmethod
    def as_measured(capture: Capture) -> "Aligned":
        """Takes the poses of a capture as they are."""
        n = len(capture)
        nothing = [BaseCorrection()] * n
        return Aligned(capture.X_WC, nothing, np.full(n, np.nan), {})


def make_aligner(
    config: MappingConfig, robot: RobotModel
) -> "FrameAligner | None":
    """Makes what aligns a robot's frames.

    Args:
        config: Settings of the live map.
        robot: The robot that carries the camera.

    Returns:
        None where the base is fixed or its odometry is trusted.
    """
    if not robot.n_base or not config.corrects_base:
        return None
    return FrameAligner(Drift(config.odometry_drift, config.odometry_turn))


class FrameAligner:
    """Aligns frames within the uncertainty of the odometry.

    Args:
        drift: How fast the odometry may go wrong.
    """

    def __init__(self, drift: Drift):
        self._drift = drift
        self._planes: dict[Key, PlaneMap] = {}
        self._known: dict[Key, np.ndarray] = {}

    def align(
        self,
        keys: list[Key],
        capture: Capture,
        X_OB: np.ndarray,
    ) -> Aligned:
        """Finds where frames were taken, the newest ones first by themselves.

        Args:
            keys: The frames' names and times, oldest first.
            capture: The frames, with their poses by odometry.
            X_OB: The base's poses by odometry, shape (n, 3) [m, rad].
        """
        keyframes = self._keyframes(keys, capture, X_OB)
        X_WB = np.array(X_OB, float)
        problems: dict[int, str] = {}
        good = np.ones(len(keys), bool)
        for i, key in enumerate(keys):
            if key in self._known:
                X_WB[i] = self._known[key]
            elif i:
                problem = self._place(keyframes, X_WB, i, good)
                if problem:
                    problems[i], good[i] = problem, False
        free = good.copy()
        free[0] = False  # It says where W is.
        kept = keyframes.select(np.flatnonzero(good))
        solution = solve(kept, X_WB[good], free[good], LEVELS)
        X_WB[good] = solution.X_WB
        self._known = {key: X_WB[i] for i, key in enumerate(keys) if good[i]}
        covariance = np.zeros((len(keys), 3, 3))
        covariance[good] = solution.covariance
        residual = np.full(len(keys), np.nan)
        residual[good] = solution.residual
        return Aligned(
            X_WC=keyframes.camera_poses(X_WB),
            corrections=[
                BaseCorrection(
                    odometry_frame(X_WB[i], X_OB[i]), covariance[i], key[1]
                )
                for i, key in enumerate(keys)
            ],
            residual=residual,
            problems=problems,
        )

    def _keyframes(
        self, keys: list[Key], capture: Capture, X_OB: np.ndarray
    ) -> Keyframes:
        self._planes = {
            key: self._planes.get(key)
            or plane_map(capture.K[i], capture.depth[i])
            for i, key in enumerate(keys)
        }
        stack = empty_stack(len(keys), capture.size, _SAMPLES)
        for i, key in enumerate(keys):
            put_view(stack, i, self._planes[key], np.random.default_rng(i))
        times = np.array([time for _, time in keys])
        waited = np.diff(times, prepend=times[0])
        waited[waited < 0] = _OTHER_RUN
        return Keyframes(
            stack,
            X_OB,
            np.linalg.inv(matrix(X_OB)) @ capture.X_WC,
            np.cumsum(waited),
            self._drift,
        )

    def _place(
        self, keyframes: Keyframes, X_WB: np.ndarray, i: int, good: np.ndarray
    ) -> str:
        """Finds where a new frame was taken, and what is wrong with it."""
        X_OB = keyframes.X_OB
        before = int(np.flatnonzero(good[:i])[-1])
        moved = relative(X_OB[before], X_OB[i])
        X_WB[i] = expected = composed(X_WB[before], moved)
        p_WC = keyframes.camera_poses(X_WB)[:, :3, 3]
        others = np.flatnonzero(good[:i])
        others = others[others != before]
        apart = np.linalg.norm(p_WC[others] - p_WC[i], axis=1)
        near = np.sort(others[np.argsort(apart, kind="stable")[:_NEIGHBOURS]])
        few = np.array([*near, before, i])
        shown = keyframes.select(few)
        waited = keyframes.age[i] - keyframes.age[before]
        most = _MOST_DEVIATIONS * self._drift.deviations(waited)
        start = X_WB[few]
        reach = min(1.5 * most[0], _FARTHEST)
        start[-1] = best_start(shown, start, reach)
        solution = solve(shown, start, few == i, REFINING)
        found = solution.X_WB
        off = np.abs(relative(expected, found[-1]))
        allowed = f"{1e3 * most[0]:.0f} mm and {np.rad2deg(most[2]):.1f} deg"
        apart = misfit(shown, found, len(few) - 1)
        if apart > _LARGEST_MISFIT:
            return (
                f"does not fit: its surfaces lie {1e3 * apart:.1f} mm from the"
                f" others', within {allowed} of where odometry has it"
            )
        drifted = most[0] / _MOST_DEVIATIONS
        vague = np.linalg.eigvalsh(solution.covariance[-1][:2, :2])[-1]
        if drifted > _TRUSTED and (
            vague > _TRUSTED**2 or slides(solution.information[-1])
        ):
            return (
                "shows too little that stands upright to tell where the base"
                f" was, which may have drifted {1e3 * drifted:.0f} mm"
            )
        if (off > most).any():
            shift, turn = 1e3 * np.hypot(*off[:2]), np.rad2deg(off[2])
            return (
                f"does not fit: {shift:.0f} mm and {turn:.1f} deg from where"
                f" odometry, good to {allowed}, has it"
            )
        X_WB[i] = found[-1]
        return ""
