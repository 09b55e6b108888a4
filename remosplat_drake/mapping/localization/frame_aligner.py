"""`FrameAligner`: localises the base at each frame, and keeps keyframes."""

import dataclasses as dc

import numpy as np

from remosplat_drake.capture.frames import Frame
from remosplat_drake.mapping.localization.frame_placement import (
    Placed,
    candidates,
    place,
)
from remosplat_drake.mapping.localization.keyframe_graph import (
    Keyframes,
    solve,
)
from remosplat_drake.mapping.mapping_config import MappingConfig
from remosplat_drake.reconstruction.alignment.plane_maps import plane_map
from remosplat_drake.reconstruction.alignment.view_stack import (
    empty_stack,
    put_view,
)
from remosplat_drake.robot.planar_pose import (
    composed,
    matrix,
    relative,
)
from remosplat_drake.robot.robot_model import RobotModel
from remosplat_drake.signals.base_correction import BaseCorrection
from remosplat_drake.signals.base_estimate import (
    BaseEstimate,
    Drift,
    predicted,
)

_SAMPLES = 300
"""This many points of a frame are compared with other frames."""

_MOST_DEVIATIONS = 4.0
"""Poses that differ from the prediction by more than this number of standard
deviations are rejected.
"""

_TRUSTED, _USEFUL = 0.004, 0.015
"""The base's position may have at most these standard deviations [m]. The first
applies to frames in a map, the second to frames to which other frames are
aligned.
"""

_LEAST_SIDES = 6.0
"""In the first frame, at least this many points on upright surfaces must
constrain each horizontal direction.
"""

_BARE = "shows too few upright surfaces to localise the base"

_LARGEST_MISFIT = 0.01
"""A frame fits if the median distance of its surfaces from those of other
frames is at most this [m]. Noise alone causes smaller distances.
"""

_LEAST_SHARED = 0.1
"""A frame can be aligned to other frames if they also show at least this
fraction of its points.
"""

_NEW = 0.7
"""A frame becomes a keyframe if keyframes show less than this fraction of its
points.
"""

_MOST_KEYFRAMES = 120
"""At most this many keyframes that are not part of a map are stored."""

Key = tuple[str, float]
"""Key of a frame: its name and its time, since names may be reused."""


@dc.dataclass(frozen=True, eq=False)
class Tracked:
    """The pose of the base at one frame.

    Attributes:
        estimate: The base's pose, with its uncertainty.
        residual: Median distance of the frame's surfaces from those of other
            frames [m]; NaN if it shares no surface with them.
        problem: Reason why the frame cannot be used in a map; empty if it can
            be used.
    """

    estimate: BaseEstimate
    residual: float = np.nan
    problem: str = ""


@dc.dataclass(frozen=True, eq=False)
class _Keyframe:
    """A frame to which others are aligned; without a key it is in no map."""

    key: Key | None
    tracked: BaseEstimate


@dc.dataclass(frozen=True, eq=False)
class Graph:
    """Poses of the keyframes in a map.

    Attributes:
        kept: The n keyframes.
        reference: Index of the newest keyframe whose pose is certain both
            before and after the alignment.
        before: The base's poses at the keyframes before the alignment, shape
            (n, 3) [m, rad].
        X_WB: The base's poses at the keyframes, in the map, shape (n, 3) [m,
            rad].
        covariance: Covariances of these poses, shape (n, 3, 3).
        X_WC: Poses of the cameras in the map (OpenCV axes), shape (n, 4, 4).
        residual: Median distance of each keyframe's surfaces from those of
            other keyframes, shape (n,) [m]; NaN for a keyframe that shares no
            surface.
    """

    kept: tuple[_Keyframe, ...]
    reference: int
    before: np.ndarray
    X_WB: np.ndarray
    covariance: np.ndarray
    X_WC: np.ndarray
    residual: np.ndarray

    def rows(self, keys: list[Key]) -> np.ndarray:
        """Returns the indices of the keyframes with the given keys, (m,)."""
        index = {kept.key: i for i, kept in enumerate(self.kept)}
        return np.array([index[key] for key in keys], int)


def make_aligner(
    config: MappingConfig, robot: RobotModel
) -> "FrameAligner | None":
    """Makes the aligner of a robot's frames.

    Args:
        config: Settings of the live map.
        robot: The robot that carries the camera.

    Returns:
        The aligner; None if the base is fixed, or if its odometry is assumed
        exact.
    """
    if not robot.n_base or not config.corrects_base:
        return None
    return FrameAligner(Drift(config.odometry_drift, config.odometry_turn))


def one_frame(image: Frame, X_OB: np.ndarray, time: float) -> Keyframes:
    """Prepares a frame for alignment.

    Args:
        image: The frame, posed by odometry.
        X_OB: The base's pose by odometry, shape (3,) [m, rad].
        time: Time at which the image was taken [s].
    """
    stack = empty_stack(1, image.depth.shape, _SAMPLES)
    planes = plane_map(image.K, image.depth)
    put_view(stack, 0, planes, np.random.default_rng(0))
    X_BC = np.linalg.inv(matrix(X_OB)) @ image.X_WC
    return Keyframes(
        stack, X_BC[None], np.array([X_OB], float), np.array([time])
    )


class FrameAligner:
    """Aligns frames to keyframes, within the uncertainty of odometry and drift.

    Args:
        drift: Drift model of the odometry.
    """

    def __init__(self, drift: Drift):
        self._drift = drift
        self._latest: BaseEstimate | None = None
        self._kept: list[_Keyframe] = []
        self._frames: Keyframes | None = None
        self._X_WB = np.zeros((0, 3))
        self._covariance = np.zeros((0, 3, 3))

    def track(self, frame: Keyframes, key: Key | None = None) -> Tracked:
        """Localises the base at a frame, from the previous frame's pose.

        Args:
            frame: The frame, as one keyframe.
            key: Name and time of the frame; None if it must not be part of a
                map.
        """
        X_OB, time = frame.X_OB[0], float(frame.time[0])
        if self._latest is None:
            expected = BaseEstimate.first(time, X_OB, self._drift)
        else:
            expected = predicted(self._latest, X_OB, time, self._drift)
        if self._frames is None or not self._kept:
            return self._anchored(frame, expected, key)
        others = candidates(self._frames, self._X_WB, frame, expected)
        placed = Placed(expected, np.nan, 0.0)
        if len(others):
            shown = Keyframes.joined([self._frames.select(others), frame])
            poses = np.vstack([self._X_WB[others], expected.X_WB])
            placed = place(shown, poses, self._covariance[others], expected)
        problem = misfit(placed, expected)
        self._latest = expected if problem else placed.estimate
        problem = problem or vagueness(self._latest.covariance, _USEFUL)
        tracked = Tracked(self._latest, placed.residual, problem)
        spare = sum(kept.key is None for kept in self._kept) < _MOST_KEYFRAMES
        if not problem and (key or (spare and placed.shared < _NEW)):
            self._keep(frame, key, self._latest)
        return tracked

    def _anchored(
        self, frame: Keyframes, expected: BaseEstimate, key: Key | None
    ) -> Tracked:
        """Defines W by a frame, if the frame constrains the base.

        A bare floor does not constrain the base, since all its parts look the
        same.
        """
        self._latest = expected
        if not holds(frame, expected.X_WB):
            return Tracked(expected, problem=_BARE)
        self._latest = expected.certain()
        self._keep(frame, key, self._latest)
        return Tracked(self._latest)

    @property
    def correction(self) -> BaseCorrection:
        """The correction of the base's odometry, from the newest frame."""
        return BaseCorrection(self._latest, self._drift)

    def knows(self, key: Key) -> bool:
        """Returns whether a frame is among the keyframes."""
        return key in [kept.key for kept in self._kept]

    def forget(self, names: set[str]) -> None:
        """Removes the keyframes of some frames, which must not be part of maps.

        Args:
            names: The frames' names.
        """
        rows = [
            i
            for i, kept in enumerate(self._kept)
            if kept.key is None or kept.key[0] not in names
        ]
        self._kept = [self._kept[i] for i in rows]
        self._X_WB = self._X_WB[rows]
        self._covariance = self._covariance[rows]
        if self._frames is not None:
            self._frames = self._frames.select(np.array(rows, int))

    def align(self) -> Graph:
        """Refines the poses of all keyframes before a map is built.

        This does not change the aligner; `adopt` does so when the map is built.
        Until then, tracking continues in the map in use.
        """
        assert self._frames is not None
        tracked = [kept.tracked for kept in self._kept]
        solution = solve(
            self._frames,
            self._X_WB,
            np.stack([estimate.X_WB for estimate in tracked]),
            np.stack([estimate.covariance[:3, :3] for estimate in tracked]),
        )
        doubt = np.maximum(self._covariance, solution.covariance)
        certain = [i for i, P in enumerate(doubt) if not vagueness(P)]
        return Graph(
            tuple(self._kept),
            certain[-1] if certain else 0,
            self._X_WB.copy(),
            solution.X_WB,
            solution.covariance,
            self._frames.camera_poses(solution.X_WB),
            solution.residual,
        )

    def adopt(self, graph: Graph) -> dict[str, np.ndarray]:
        """Moves all keyframes and the base to their poses in a new map.

        Args:
            graph: The result of `align`. Keyframes that were added since then
                move with the graph's reference keyframe.

        Returns:
            Poses of the base in the map at all frames with a name, keyed by
            this name, each of shape (3,) [m, rad].
        """
        assert self._latest is not None
        index = {id(kept): i for i, kept in enumerate(graph.kept)}
        old, new = graph.before[graph.reference], graph.X_WB[graph.reference]
        for i, kept in enumerate(self._kept):
            if id(kept) in index:
                row = index[id(kept)]
                self._X_WB[i] = graph.X_WB[row]
                self._covariance[i] = graph.covariance[row]
            else:
                self._X_WB[i] = composed(new, relative(old, self._X_WB[i]))
        X_WB = composed(new, relative(old, self._latest.X_WB))
        self._latest = dc.replace(self._latest, X_WB=X_WB)
        return {
            kept.key[0]: pose
            for kept, pose in zip(self._kept, self._X_WB, strict=True)
            if kept.key is not None
        }

    def resume(
        self, frame: Keyframes, key: Key, X_WB: np.ndarray | None
    ) -> None:
        """Adds a frame that an earlier process has aligned.

        Args:
            frame: The frame, as a single keyframe.
            key: Name and time of the frame.
            X_WB: Pose of the base in a map, shape (3,) [m, rad]; None if the
                frame is in no map.
        """
        if X_WB is None:
            self.track(frame, key)
            return
        first = BaseEstimate.first(
            float(frame.time[0]), frame.X_OB[0], self._drift
        )
        there = dc.replace(first, X_WB=X_WB)
        if self._latest is None or self._latest.time < there.time:
            self._latest = there
        self._keep(frame, key, there)

    def _keep(
        self, frame: Keyframes, key: Key | None, estimate: BaseEstimate
    ) -> None:
        parts = [] if self._frames is None else [self._frames]
        P = estimate.covariance[None, :3, :3]
        self._kept.append(_Keyframe(key, estimate))
        self._frames = Keyframes.joined([*parts, frame])
        self._X_WB = np.vstack([self._X_WB, estimate.X_WB])
        self._covariance = np.concatenate([self._covariance, P])


def misfit(placed: Placed, expected: BaseEstimate) -> str:
    """Returns the reason why a frame's pose is implausible, or "".

    Args:
        placed: The frame's pose from shared surfaces.
        expected: The frame's pose that odometry and its drift predict.
    """
    most = _MOST_DEVIATIONS * expected.deviations
    allowed = f"{1e3 * most[:2].max():.0f} mm and {np.rad2deg(most[2]):.1f} deg"
    if placed.shared < _LEAST_SHARED:
        return "shares no surface with the map: look back at mapped surfaces"
    if placed.residual > _LARGEST_MISFIT:
        return (
            f"does not fit: its surfaces lie {1e3 * placed.residual:.1f} mm"
            " from those of other frames, at every pose within"
            f" {allowed} of odometry"
        )
    off = np.abs(placed.estimate.X_WB - expected.X_WB)
    if (off > most).any():
        shift, turn = 1e3 * np.hypot(*off[:2]), np.rad2deg(off[2])
        return (
            f"does not fit: {shift:.0f} mm and {turn:.1f} deg from the pose by"
            f" odometry, whose error is at most {allowed}"
        )
    return ""


def vagueness(covariance: np.ndarray, most: float = _TRUSTED) -> str:
    """Returns the reason why a pose is too uncertain for a map, or "".

    Args:
        covariance: Covariance matrix of the base's pose, whose first rows are x
            and y [m].
        most: The base's position may have at most this standard deviation [m].
    """
    vague = float(np.sqrt(np.linalg.eigvalsh(covariance[:2, :2])[-1]))
    if vague <= most:
        return ""
    return f"{_BARE}, which may have drifted {1e3 * vague:.0f} mm"


def holds(frame: Keyframes, X_WB: np.ndarray) -> bool:
    """Returns whether upright surfaces of a frame constrain the base.

    Args:
        frame: The frame, as a single keyframe.
        X_WB: Approximate pose of the base, shape (3,) [m, rad].
    """
    R_WC = frame.camera_poses(X_WB[None])[0, :3, :3]
    side = (frame.stack.normal[0, : frame.stack.count[0]] @ R_WC.T)[:, :2]
    return bool(np.linalg.eigvalsh(side.T @ side)[0] > _LEAST_SIDES)
