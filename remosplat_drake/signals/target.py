"""`Target`: what the end effector shall reach, and how."""

import dataclasses as dc
from collections.abc import Callable
from functools import cached_property

import numpy as np
from pydrake.common.eigen_geometry import AngleAxis
from pydrake.math import RigidTransform

from remosplat_drake.robot.pose_error import PoseError
from remosplat_drake.robot.target_arrays import (
    TargetArrays,
    asked_error,
    place_on_line,
)

DIRECTIONS = ("rx", "ry", "rz", "x", "y", "z")
"""Names of the directions of a target T: turns about its axes, and ways along
them, in the order of `Target.weights`."""


@dc.dataclass(frozen=True, eq=False)
class Line:
    """The straight way to a target.

    Attributes:
        X_WA: Pose of the end effector at its start A, shape (4, 4). On the way
            the end effector turns evenly from there to the target.
        speed: Speed along it [m/s].
    """

    X_WA: np.ndarray
    speed: float


@dc.dataclass(frozen=True, eq=False)
class Target:
    """What the end effector shall reach; copying returns the object itself.

    A plain pose is a target of which every direction is asked for alike.

    Attributes:
        X_WT: Pose of the target T in the world W, shape (4, 4).
        weights: How much each direction of T matters, turns about its axes
            before ways along them, shape (6,): factors on the price of missing
            it. One of weight zero is free. Of the turns none, one or all may
            be free.
        line: The straight way on which it shall be reached; None leaves the
            way open.
        passed_within: Distance at which it counts as passed, without a stop
            [m]; None if it shall be reached and held.
        onward: How much way there is behind a target that is passed, for
            which the end effector keeps its speed [m].

    Raises:
        ValueError: The weights are unusable.

    Example:
        >>> import numpy as np
        >>> import remosplat_drake as rs
        >>> X_WT = np.eye(4)
        >>> screw = rs.Target(X_WT).without("rz")
        >>> X_WE = np.diag([-1.0, -1.0, 1.0, 1.0])  # Turned about z.
        >>> screw.error(X_WE).angle, rs.Target(X_WT).error(X_WE).angle > 3
        (0.0, True)
    """

    X_WT: np.ndarray
    weights: np.ndarray = dc.field(default_factory=lambda: np.ones(6))
    line: Line | None = None
    passed_within: float | None = None
    onward: float = 0.0

    def __post_init__(self):
        problem = weights_problem(self.weights)
        if problem:
            raise ValueError(problem)

    def __deepcopy__(self, memo) -> "Target":
        return self

    @staticmethod
    def of(wanted: "Target | RigidTransform | np.ndarray") -> "Target":
        """Returns a target, or makes one of a plain pose X_WT.

        Args:
            wanted: A target, or a pose: Drake's, or of shape (4, 4).
        """
        if isinstance(wanted, Target):
            return wanted
        if not isinstance(wanted, np.ndarray):
            wanted = wanted.GetAsMatrix4()
        return Target(np.array(wanted, float, order="C"))

    def without(self, *directions: str) -> "Target":
        """Returns the target with some directions free.

        Args:
            *directions: Names out of `DIRECTIONS`.

        Raises:
            ValueError: These cannot be free together.
        """
        free = [DIRECTIONS.index(name) for name in directions]
        weights = self.weights.copy()
        weights[free] = 0.0
        return dc.replace(self, weights=weights)

    def on_line(self, X_WA: np.ndarray, speed: float) -> "Target":
        """Returns the target, to be reached straight from a start A.

        Args:
            X_WA: Pose of the end effector at the start, shape (4, 4).
            speed: Speed along the line [m/s].
        """
        return dc.replace(self, line=Line(X_WA, speed))

    def passed(self, within: float) -> "Target":
        """Returns the target, to be passed without a stop.

        Args:
            within: Distance at which it counts as passed [m].
        """
        return dc.replace(self, passed_within=within)

    @cached_property
    def arrays(self) -> TargetArrays:
        """The target as kernels take it."""
        line = self.line or Line(self.X_WT, 0.0)
        # Copies, since numba compiles for arrays that may be written.
        return TargetArrays(
            np.array(self.X_WT, float, order="C"),
            np.array(self.weights, float),
            float(self.onward),
            np.array(line.X_WA, float, order="C"),
            float(line.speed),
        )

    @property
    def is_plain(self) -> bool:
        """Whether every direction is asked for alike, by whatever way."""
        return self.line is None and bool((self.weights == 1.0).all())

    @cached_property
    def is_known(self) -> bool:
        """Whether all that says where it is is finite."""
        start = 0.0 if self.line is None else self.line.X_WA.sum()
        return bool(np.isfinite(self.X_WT.sum() + start))

    @property
    def asks_to_turn(self) -> bool:
        """Whether any orientation is asked for."""
        return bool(self.weights[:3].any())

    @property
    def asks_for_place(self) -> bool:
        """Whether any position is asked for."""
        return bool(self.weights[3:].any())

    @property
    def free(self) -> tuple[str, ...]:
        """Names of the directions that are free, as in `DIRECTIONS`."""
        return tuple(
            name
            for name, weight in zip(DIRECTIONS, self.weights, strict=True)
            if weight == 0.0
        )

    def equals(self, other: "Target") -> bool:
        """Tells whether another target asks for the same.

        Args:
            other: The other target.
        """
        return self is other or (
            self.passed_within == other.passed_within
            and all(map(np.array_equal, self.arrays, other.arrays))
        )

    def error(self, X_WE: np.ndarray) -> PoseError:
        """Computes the error in what is asked for, and in nothing else.

        Args:
            X_WE: Pose of the end effector, shape (4, 4).
        """
        return PoseError(
            *asked_error(np.array(X_WE, float, order="C"), self.arrays)
        )

    def is_reached(
        self, error: PoseError, arrived: Callable[[PoseError], bool]
    ) -> bool:
        """Tells whether an error is small enough.

        Args:
            error: The target's error.
            arrived: Tells it of a target that shall be held.
        """
        if self.passed_within is None:
            return arrived(error)
        return error.distance < self.passed_within

    def nearest_pose(self, X_WE: np.ndarray) -> np.ndarray:
        """Returns the pose nearest to E that has all that is asked, (4, 4).

        Args:
            X_WE: Pose of the end effector, shape (4, 4).
        """
        error, X_WN = self.error(X_WE), np.array(X_WE, float)
        X_WN[:3, 3] += error.p_ET_W
        if error.angle > 0.0:
            axis = error.rotation_W / error.angle
            turn = AngleAxis(error.angle, axis).rotation()
            X_WN[:3, :3] = turn @ X_WN[:3, :3]
        return X_WN

    def line_deviation(self, X_WE: np.ndarray) -> float:
        """Returns how far E is beside the line [m]; NaN without a line.

        Args:
            X_WE: Pose of the end effector, shape (4, 4).
        """
        if self.line is None:
            return float("nan")
        place = place_on_line(np.array(X_WE, float, order="C"), self.arrays)
        return float(np.linalg.norm(place[2]))


def weights_problem(weights: np.ndarray) -> str:
    """Says what is wrong with the weights of a target; empty if nothing.

    Args:
        weights: The weights, shape (6,).
    """
    if np.shape(weights) != (6,):
        return f"expected 6 weights, got the shape {np.shape(weights)}"
    if not (np.isfinite(weights).all() and (np.array(weights) >= 0.0).all()):
        return "weights must be finite and not negative"
    if not np.any(weights):
        return "a target must ask for something: all six directions are free"
    if np.count_nonzero(weights[:3]) == 1:
        return "of the turns rx, ry and rz none, one or all may be free"
    return ""
