"""`Task`: jobs with objects; `TaskState`: its progress; `Work`: both."""

import dataclasses as dc
from collections.abc import Callable, Mapping

import numpy as np
from pydrake.math import RigidTransform

from remosplat_drake.oracle.contact_rules import ContactRule
from remosplat_drake.robot.fitting.link_spheres import LinkSpheres
from remosplat_drake.robot.payload import Payload
from remosplat_drake.robot.robot_model import RobotModel
from remosplat_drake.scene.objects.scene_object import (
    SceneObject,
    find_object,
)
from remosplat_drake.task.step import Block, Step

RUNNING, DONE, FAILED = "running", "done", "failed"
"""Outcomes of a task."""

Permission = Callable[["TaskState", "TaskState", np.ndarray], str]
"""Function that checks a transition from one state of a task to another state
at the configuration q. It returns the reason why the transition is not allowed,
or "" if it is allowed."""


@dc.dataclass(frozen=True, eq=False)
class Task:
    """A task of a robot: jobs with objects.

    Attributes:
        robot: The robot, without a payload.
        blocks: The jobs, in their order.
        objects: The objects, at their initial poses.
        spheres: Spheres around the objects that the robot carries, keyed by the
            objects' names.
        permission: Check before the payload or the contact rules change.
    """

    robot: RobotModel
    blocks: tuple[Block, ...]
    objects: tuple[SceneObject, ...]
    spheres: Mapping[str, LinkSpheres]
    permission: Permission = lambda before, after, q: ""


@dc.dataclass(frozen=True, eq=False)
class TaskState:
    """Progress of a robot in a task; a deep copy is the object itself.

    Attributes:
        objects: All objects. The pose of a carried object is that at which it
            was taken.
        block: Index of the present block.
        way: Index of the block's alternative that the robot tries.
        step: Index of the present step of that alternative.
        undoing: The remaining steps that undo a failed step; empty without a
            failed step.
        begun: Whether the present step has begun; if not, the arm first comes
            to a standstill.
        since: Time at which `begun` last changed [s].
        X_WT: Goal of the end effector, or of the base if the base drives, shape
            (4, 4); None before the first step.
        q_A: The configuration when the step began, shape (n_q,) [rad, m]; None
            before the first step.
        rules: The contact rules of the step that began last.
        payload: The carried object; None if the robot carries no object.
        holder: Index of the end effector that carries the payload.
        giver: Index of the end effector that has handed the payload over, until
            it has moved away; None otherwise.
        grip: Opening of the hand around the payload [m]; None if it is not
            checked.
        X_OE: Pose of the end effector `holder` in the payload's frame O, shape
            (4, 4); None without a payload.
        told: Commanded opening and force of each hand, keyed by end effector
            [m, N].
        carried: The value of `load` when the block began.
        failures: Reasons why steps have failed.
        lost: Names of the objects that have slipped out of a hand. Their places
            are unknown; see `lost_load`.
        outcome: `RUNNING`, `DONE` or `FAILED`.
    """

    objects: tuple[SceneObject, ...]
    block: int = 0
    way: int = 0
    step: int = 0
    undoing: tuple[Step, ...] = ()
    begun: bool = False
    since: float = 0.0
    X_WT: np.ndarray | None = None
    q_A: np.ndarray | None = None
    rules: tuple[ContactRule, ...] = ()
    payload: Payload | None = None
    holder: int = 0
    giver: int | None = None
    grip: float | None = None
    X_OE: np.ndarray | None = None
    told: Mapping[int, tuple[float, float]] = dc.field(default_factory=dict)
    carried: tuple[str, int] = ("", 0)
    failures: tuple[str, ...] = ()
    lost: frozenset[str] = frozenset()
    outcome: str = RUNNING

    def __deepcopy__(self, memo) -> "TaskState":
        return self

    def present(self, task: Task) -> Step:
        """Returns the present step; after the end of the task, the last step.

        Args:
            task: The task.
        """
        if self.undoing:
            return self.undoing[0]
        block = task.blocks[min(self.block, len(task.blocks) - 1)]
        steps = block.ways[min(self.way, len(block.ways) - 1)]
        return steps[min(self.step, len(steps) - 1)]

    @property
    def held(self) -> str:
        """Name of the carried object; empty if there is none."""
        return "" if self.payload is None else self.payload.name

    @property
    def emptied(self) -> "TaskState":
        """The state after the carried object was released.

        The object keeps its latest pose.
        """
        return dc.replace(self, payload=None, giver=None, grip=None, X_OE=None)

    @property
    def load(self) -> tuple[str, int]:
        """Name of the carried object ("" if none), and its end effector."""
        return (self.held, self.holder) if self.held else ("", 0)

    @property
    def in_map(self) -> tuple[SceneObject, ...]:
        """The objects that are not carried."""
        return tuple(each for each in self.objects if each.name != self.held)

    def named(self, name: str) -> SceneObject:
        """Returns an object, with its latest known pose.

        Args:
            name: Name of the object.
        """
        return find_object(self.objects, name)

    def moved(self, name: str, X_WO: np.ndarray) -> tuple[SceneObject, ...]:
        """Returns all objects, one of them with another pose.

        Args:
            name: Name of the object.
            X_WO: New pose of the object, shape (4, 4).
        """
        pose = RigidTransform(X_WO)
        return tuple(
            each.at(pose) if each.name == name else each
            for each in self.objects
        )


@dc.dataclass(frozen=True, eq=False)
class Work:
    """A task and its progress; a deep copy is the object itself.

    Attributes:
        task: The task.
        state: Progress of the task.
    """

    task: Task
    state: TaskState

    def __deepcopy__(self, memo):
        return self
