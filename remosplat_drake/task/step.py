"""`Step`: one thing that a hand does, as data; `Block`: ways to do a job."""

import dataclasses as dc

import numpy as np

from remosplat_drake.oracle.contact_rules import ContactRule

AT, ON_OBJECT, OBJECT_TO = "at", "on object", "object to"
BY_WORLD, BY_HAND = "by world", "by hand"
BASE_TO = "base to"
"""How a `Goal` is meant."""

ATTACH, RELEASE = "attach", "release"
"""What a step may do to an object, besides motion."""

FORCE = 20.0
"""Force with which a hand closes that is told none [N]."""


@dc.dataclass(frozen=True, eq=False)
class Goal:
    """Where the end effector E of a step goes, or the base B.

    Attributes:
        kind: How `X` is meant: the pose X_WT itself (`AT`); the pose X_OT
            relative to an object, where that is when the step begins
            (`ON_OBJECT`); the pose X_WO to which the carried object is brought
            (`OBJECT_TO`); a motion from where E is then, to the left of its
            pose (`BY_WORLD`) or to the right (`BY_HAND`); or the pose X_WB of
            the base (`BASE_TO`), which carries the arm along.
        X: The transform, shape (4, 4).
        object: The object of `ON_OBJECT`.
    """

    kind: str
    X: np.ndarray
    object: str = ""


@dc.dataclass(frozen=True, eq=False)
class Step:
    """One step of a task.

    Attributes:
        text: What the robot does, such as "approaches the can".
        effector: Index of the end effector that does it.
        goal: Where that goes, or the base; None where the arm stands still.
        speed: Speed on the straight line that it follows [m/s]; None where the
            way is free.
        position: Distance at which it has arrived [m].
        angle: Angle at which it has arrived [rad].
        rules: What may come nearer than usual while the step lasts.
        width: Opening to which the hand goes [m]; None where it stays.
        force: Force with which it closes [N].
        action: `ATTACH` or `RELEASE`, at the start of the step; empty for
            neither.
        object: The object that is attached or released.
        grip: Opening of the hand around an object that is attached [m]; None
            where that is not looked at.
        patience: Time after which the step has failed [s].
        undo: What leads out again where the step has failed.
    """

    text: str
    effector: int = 0
    goal: Goal | None = None
    speed: float | None = None
    position: float = 0.005
    angle: float = 0.02
    rules: tuple[ContactRule, ...] = ()
    width: float | None = None
    force: float = FORCE
    action: str = ""
    object: str = ""
    grip: float | None = None
    patience: float = 20.0
    undo: tuple["Step", ...] = ()

    def __deepcopy__(self, memo) -> "Step":
        return self

    @property
    def drives(self) -> bool:
        """Whether the base goes somewhere, and not an end effector."""
        return self.goal is not None and self.goal.kind == BASE_TO


@dc.dataclass(frozen=True, eq=False)
class Block:
    """A job, and the ways in which it may be done.

    Attributes:
        text: What is done, such as "pick the can".
        ways: The ways in the order in which they are tried, each as its steps.
    """

    text: str
    ways: tuple[tuple[Step, ...], ...]
