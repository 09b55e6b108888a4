"""`Aim`: the targets of a robot's end effectors at one time."""

import dataclasses as dc
from collections.abc import Callable, Sequence
from functools import cached_property

import numpy as np
from pydrake.math import RigidTransform

from remosplat_drake.base.kernels.packed import Packed
from remosplat_drake.robot.pose_error import PoseError
from remosplat_drake.robot.target_arrays import AimArrays
from remosplat_drake.signals.target import Target


@dc.dataclass(frozen=True, eq=False)
class Aim:
    """The targets of all end effectors; copying returns the object itself.

    Attributes:
        targets: The target of each end effector, by the index of the end
            effector; None for an end effector without a target. At least one
            entry is a target.
        u: Reference velocity of base and joints, for control laws that track
            one, shape (n_u,) [m/s, rad/s]; None if only poses are given.
        q: Configuration that the robot must have at the targets, shape (n_q,)
            [rad, m]. Planned paths end in it, and reactive control ignores it.
            If it is None, any configuration that reaches the targets is valid.

    Raises:
        ValueError: No end effector has a target.
    """

    targets: tuple[Target | None, ...]
    u: np.ndarray | None = None
    q: np.ndarray | None = None

    def __post_init__(self):
        if not any(self.targets):
            raise ValueError("an aim needs a target")

    def __deepcopy__(self, memo) -> "Aim":
        return self

    @staticmethod
    def of(wanted: "Aim | Target | RigidTransform | np.ndarray") -> "Aim":
        """Makes an aim from a target of the first end effector.

        If the argument is an aim, it is returned unchanged.

        Args:
            wanted: An aim, a target, or the pose X_WT of a target without
                further properties.
        """
        return wanted if isinstance(wanted, Aim) else Aim((Target.of(wanted),))

    @cached_property
    def items(self) -> tuple[tuple[int, Target], ...]:
        """The targets, each with the index of its end effector."""
        return tuple((i, t) for i, t in enumerate(self.targets) if t)

    @property
    def first(self) -> Target:
        """The first target."""
        return self.items[0][1]

    @cached_property
    def arrays(self) -> Packed[AimArrays]:
        """The aim as arrays for kernels."""
        effectors = np.array([i for i, _ in self.items])
        parts = zip(*(target.arrays for _, target in self.items), strict=True)
        by_path = self.q is not None
        X_WT, weights, onward, X_WA, speed = map(np.array, parts)
        return Packed(
            AimArrays(effectors, X_WT, weights, onward, X_WA, speed, by_path)
        )

    @cached_property
    def is_known(self) -> bool:
        """Whether all poses of targets are finite."""
        return all(target.is_known for _, target in self.items)

    @cached_property
    def has_line(self) -> bool:
        """Whether any of the targets must be reached on a straight line."""
        return any(target.line is not None for _, target in self.items)

    def equals(self, other: "Aim") -> bool:
        """Returns whether another aim has the same targets.

        Args:
            other: The other aim.
        """
        if self is other:
            return True
        for mine, theirs in ((self.u, other.u), (self.q, other.q)):
            if not np.array_equal(_listed(mine), _listed(theirs)):
                return False
        same = [i for i, _ in self.items] == [i for i, _ in other.items]
        return same and all(
            mine.equals(theirs)
            for (_, mine), (_, theirs) in zip(
                self.items, other.items, strict=True
            )
        )

    def errors(self, X_WEs: np.ndarray) -> tuple[PoseError, ...]:
        """Computes the pose error of each target.

        Args:
            X_WEs: Poses of all end effectors, shape (e, 4, 4).
        """
        return tuple(target.error(X_WEs[i]) for i, target in self.items)

    def farthest(
        self, X_WEs: np.ndarray, arrived: Callable[[PoseError], bool]
    ) -> tuple[int, Target]:
        """Returns the target with the largest error, and its end effector.

        If some end effectors have not arrived, only these are considered.

        Args:
            X_WEs: Poses of all end effectors, shape (e, 4, 4).
            arrived: Function that returns whether a pose error counts as
                arrival. It is used for targets at which the end effector stops.
        """

        def left(item: tuple[int, Target]) -> tuple[bool, float]:
            error = item[1].error(X_WEs[item[0]])
            return not item[1].is_reached(error, arrived), error.distance

        return max(self.items, key=left)

    def is_reached(
        self, X_WEs: np.ndarray, arrived: Callable[[PoseError], bool]
    ) -> bool:
        """Returns whether every target is reached.

        Args:
            X_WEs: Poses of all end effectors, shape (e, 4, 4).
            arrived: Function that returns whether a pose error counts as
                arrival. It is used for targets at which the end effector stops.
        """
        return self.is_reached_by(self.errors(X_WEs), arrived)

    def is_reached_by(
        self,
        errors: Sequence[PoseError],
        arrived: Callable[[PoseError], bool],
    ) -> bool:
        """Returns whether every target is reached, given the targets' errors.

        Args:
            errors: The error of each target, which the method `errors` returns.
            arrived: Function that returns whether a pose error counts as
                arrival. It is used for targets at which the end effector stops.
        """
        return all(
            target.is_reached(error, arrived)
            for (_, target), error in zip(self.items, errors, strict=True)
        )

    def line_deviation(self, X_WEs: np.ndarray) -> float:
        """Returns the largest deviation of end effectors from their lines [m].

        Args:
            X_WEs: Poses of all end effectors, shape (e, 4, 4).

        Returns:
            The deviation; NaN if no target has a line.
        """
        beside = [
            target.line_deviation(X_WEs[i])
            for i, target in self.items
            if target.line is not None
        ]
        return max(beside, default=float("nan"))


def _listed(x: np.ndarray | None) -> np.ndarray:
    return np.zeros(0) if x is None else x
