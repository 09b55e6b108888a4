"""`Target`: the goal of an end effector, and the way to reach it."""

import dataclasses as dc
from collections.abc import Callable
from functools import cached_property

import numpy as np
from pydrake.common.eigen_geometry import AngleAxis
from pydrake.math import RigidTransform

from remosplat_drake.robot.pose_error import PoseError
from remosplat_drake.robot.target_arrays import (
    TargetArrays,
    constrained_error,
    place_on_line,
)

DIRECTIONS = ("rx", "ry", "rz", "x", "y", "z")
"""Names of the directions of a target T: rotations about its axes, then
translations along them, in the order of `Target.weights`."""


@dc.dataclass(frozen=True, eq=False)
class Line:
    """A straight path of an end effector to its target.

    Attributes:
        X_WA: Pose A of the end effector at the start of the line, shape (4, 4).
            Along the line, the end effector rotates at a constant rate to the
            orientation of the target.
        speed: Speed along the line [m/s].
    """

    X_WA: np.ndarray
    speed: float


@dc.dataclass(frozen=True, eq=False)
class Target:
    """The goal of an end effector; copying returns the object itself.

    A target with equal weights in all directions is a plain pose.

    Attributes:
        X_WT: Pose of the target T in the world W, shape (4, 4).
        weights: Weights of the errors in the controller's cost, shape (6,):
            first for rotations about the axes of T, then for translations along
            them. A direction with weight zero is free. The number of free
            rotations must be zero, one or three.
        line: The straight path to the target; None if any path is valid.
        passed_within: Distance at which the target counts as passed, without a
            stop [m]; None for a target at which the end effector stops.
        onward: Length of the path after a target that is passed, along which
            the end effector keeps its speed [m].

    Raises:
        ValueError: The weights are invalid.

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
        """Makes a target from a pose X_WT; returns a target unchanged.

        Args:
            wanted: A target, or a pose: Drake's, or of shape (4, 4).
        """
        if isinstance(wanted, Target):
            return wanted
        if not isinstance(wanted, np.ndarray):
            wanted = wanted.GetAsMatrix4()
        return Target(np.array(wanted, float, order="C"))

    def at(self, X_WT: np.ndarray) -> "Target":
        """Returns this target at another pose, where the end effector stops.

        Args:
            X_WT: The pose, shape (4, 4).
        """
        return Target(X_WT, self.weights)

    def without(self, *directions: str) -> "Target":
        """Returns this target with some directions free.

        Args:
            *directions: Names from `DIRECTIONS`.

        Raises:
            ValueError: These directions cannot be free together.
        """
        free = [DIRECTIONS.index(name) for name in directions]
        weights = self.weights.copy()
        weights[free] = 0.0
        return dc.replace(self, weights=weights)

    def on_line(self, X_WA: np.ndarray, speed: float) -> "Target":
        """Returns this target with a straight line to it from a start pose A.

        Args:
            X_WA: Pose of the end effector at the start, shape (4, 4).
            speed: Speed along the line [m/s].
        """
        return dc.replace(self, line=Line(X_WA, speed))

    def passed(self, within: float) -> "Target":
        """Returns this target as one that is passed without a stop.

        Args:
            within: Distance at which the target counts as passed [m].
        """
        return dc.replace(self, passed_within=within)

    @cached_property
    def arrays(self) -> TargetArrays:
        """The target as arrays for kernels."""
        line = self.line or Line(self.X_WT, 0.0)
        # The arrays are copied, since kernels are compiled for writable arrays.
        return TargetArrays(
            np.array(self.X_WT, float, order="C"),
            np.array(self.weights, float),
            float(self.onward),
            np.array(line.X_WA, float, order="C"),
            float(line.speed),
        )

    @property
    def is_plain(self) -> bool:
        """Whether the target is a plain pose: equal weights and no line."""
        return self.line is None and bool((self.weights == 1.0).all())

    @cached_property
    def is_known(self) -> bool:
        """Whether all poses of the target are finite."""
        start = 0.0 if self.line is None else self.line.X_WA.sum()
        return bool(np.isfinite(self.X_WT.sum() + start))

    @property
    def constrains_rotation(self) -> bool:
        """Whether any rotation has a nonzero weight."""
        return bool(self.weights[:3].any())

    @property
    def constrains_full_position(self) -> bool:
        """Whether all translations have nonzero weights."""
        return not set(self.free) & {"x", "y", "z"}

    @property
    def constrains_position(self) -> bool:
        """Whether any translation has a nonzero weight."""
        return bool(self.weights[3:].any())

    @property
    def free(self) -> tuple[str, ...]:
        """The names of the free directions, in the order of `DIRECTIONS`."""
        return tuple(
            name
            for name, weight in zip(DIRECTIONS, self.weights, strict=True)
            if weight == 0.0
        )

    def equals(self, other: "Target") -> bool:
        """Returns whether another target is equal.

        Args:
            other: The other target.
        """
        return self is other or (
            self.passed_within == other.passed_within
            and all(map(np.array_equal, self.arrays, other.arrays))
        )

    def error(self, X_WE: np.ndarray) -> PoseError:
        """Computes the pose error in the directions that are not free.

        Args:
            X_WE: Pose of the end effector, shape (4, 4).
        """
        return PoseError(
            *constrained_error(np.array(X_WE, float, order="C"), self.arrays)
        )

    def is_reached(
        self, error: PoseError, arrived: Callable[[PoseError], bool]
    ) -> bool:
        """Returns whether the target counts as reached at a pose error.

        Args:
            error: The target's error.
            arrived: Function that returns whether a pose error counts as
                arrival. It is used for a target at which the end effector
                stops.
        """
        if self.passed_within is None:
            return arrived(error)
        return error.distance < self.passed_within

    def nearest_pose(self, X_WE: np.ndarray) -> np.ndarray:
        """Returns the zero-error pose that is nearest to X_WE, shape (4, 4).

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
        """Returns the distance of E from the line [m]; NaN without a line.

        Args:
            X_WE: Pose of the end effector, shape (4, 4).
        """
        if self.line is None:
            return float("nan")
        place = place_on_line(np.array(X_WE, float, order="C"), self.arrays)
        return float(np.linalg.norm(place[2]))


def weights_problem(weights: np.ndarray) -> str:
    """Returns the problem of a target's weights; empty if they are valid.

    Args:
        weights: The weights, shape (6,).
    """
    if np.shape(weights) != (6,):
        return f"expected 6 weights, got the shape {np.shape(weights)}"
    if not (np.isfinite(weights).all() and (np.array(weights) >= 0.0).all()):
        return "weights must be finite and not negative"
    if not np.any(weights):
        return "all six directions are free; give at least one a weight"
    if np.count_nonzero(weights[:3]) == 1:
        return "none, one or all of the rotations rx, ry and rz may be free"
    return ""
