"""`Step`: one action of a robot in a task; `Block`: alternatives for a job."""

import dataclasses as dc

import numpy as np

from remosplat_drake.oracle.contact_rules import ContactRule

AT, ON_OBJECT, OBJECT_TO = "at", "on object", "object to"
BY_WORLD, BY_HAND = "by world", "by hand"
BASE_TO = "base to"
"""Kinds of a `Goal`; see `Goal.kind`."""

ATTACH, RELEASE = "attach", "release"
"""Changes of an object's state at the start of a step."""

FORCE = 20.0
"""Force with which a hand closes if a step states no force [N]."""


@dc.dataclass(frozen=True, eq=False)
class Goal:
    """The goal of the end effector E or the base B in a step.

    Attributes:
        kind: Meaning of `X`. `AT`: X is X_WT. `ON_OBJECT`: X is X_OT, relative
            to the object's pose at the start of the step. `OBJECT_TO`: X is
            X_WO, the goal of the carried object. `BY_WORLD`: X is a motion in
            W, so X_WT = X X_WE with the pose of E at the start of the step.
            `BY_HAND`: X is a motion in E, so X_WT = X_WE X. `BASE_TO`: X is
            X_WB; the arm moves with the base.
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
        text: Description of the robot's action, such as "approaches the can".
        effector: Index of the end effector that moves.
        goal: The goal of the end effector or the base; None if both stand
            still.
        speed: Speed along a straight line to the goal [m/s]; None if any path
            is permitted.
        position: Distance to the goal that counts as arrival [m].
        angle: Angle to the goal that counts as arrival [rad].
        rules: Pairs of links and objects that may come nearer than usual during
            the step.
        width: Commanded opening of the hand [m]; None leaves it unchanged.
        force: Force with which the hand closes [N].
        action: `ATTACH` or `RELEASE`, at the start of the step; empty for
            neither.
        object: The object that is attached or released.
        grip: Opening of the hand around an object that is attached [m]; None if
            it is not checked.
        patience: The step has failed if it takes longer than this [s].
        undo: Steps that move the robot back after this step has failed.
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
        """Whether the goal is for the base, and not for an end effector."""
        return self.goal is not None and self.goal.kind == BASE_TO


@dc.dataclass(frozen=True, eq=False)
class Block:
    """A job of a task, with alternative sequences of steps.

    Attributes:
        text: Description of the job, such as "pick the can".
        ways: The alternative sequences of steps. If one fails, the robot tries
            the next.
    """

    text: str
    ways: tuple[tuple[Step, ...], ...]
