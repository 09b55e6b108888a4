"""Settings of the steps of a task, in a scenario's section `tasks`."""

import dataclasses as dc
import math
from collections.abc import Iterator
from typing import Annotated

from annotated_types import Interval, Len

from remosplat_drake.base.pose_config import PoseConfig
from remosplat_drake.base.ranges import Config, Position, Unbounded

Length = Annotated[float, Interval(gt=0, le=5)]
"""A distance along a straight line [m]."""

Speed = Annotated[float, Interval(gt=0, le=2)]
"""A speed along a straight line [m/s]."""

Shift = Annotated[list[Annotated[float, Interval(ge=-5, le=5)]], Len(3, 3)]
"""A motion along the axes of W [m]."""

Width = Annotated[float, Interval(ge=0, le=1)]
"""The opening of a hand [m]."""

Force = Annotated[float, Interval(gt=0, le=1000)]
"""The force with which a hand closes [N]."""


@dc.dataclass
class Touch(Config):
    """Distance that some links keep from an object during a step."""

    # Name of the object.
    object: str = ""
    # Names of the links; empty: the links of the hand (fingers and palm).
    links: Annotated[list[str], Len(0, 100)] = dc.field(default_factory=list)
    # Distance that the links keep from the object [m]; absent: they may touch
    # it.
    stopping: Annotated[float, Interval(ge=0, le=1)] | None = None


@dc.dataclass
class StepConfig(Config):
    """Settings of every step."""

    # Name of the end effector; empty for the first end effector.
    effector: str = ""
    # Links that may come nearer to an object than the stopping distance during
    # the step.
    touch: Annotated[list[Touch], Len(0, 100)] = dc.field(default_factory=list)
    # Longest duration of the step, after which it has failed [s].
    patience: Annotated[float, Interval(gt=0, le=1e5)] = 20.0
    # Distance to the goal that counts as arrival of the end effector [m].
    position: Annotated[float, Interval(gt=0, le=0.1)] = 0.005
    # Angle to the goal that counts as arrival [deg].
    angle: Annotated[float, Interval(gt=0, le=45)] = 1.0


@dc.dataclass
class ReachTo(StepConfig, PoseConfig):
    """Moves the end effector to a pose, on any path."""

    # Object in whose frame the pose is given; empty: the frame is W.
    object: str = ""


@dc.dataclass
class Approach(StepConfig):
    """Moves the end effector straight along a direction in its own frame."""

    # The direction in the end effector's frame; its length is ignored.
    along: Annotated[
        list[Annotated[float, Unbounded("a direction")]], Len(3, 3)
    ] = dc.field(default_factory=lambda: [0.0, 0.0, 1.0])
    # Distance of the motion [m].
    distance: Length = 0.1
    # Its speed [m/s].
    speed: Speed = 0.1

    def check(self) -> Iterator[tuple[str, str]]:
        """Checks that the direction is not zero.

        Yields:
            The name of a field and its problem.
        """
        yield from super().check()
        if not any(self.along):
            yield "along", "expected a direction, got three zeros"


@dc.dataclass
class Retreat(Approach):
    """Moves the end effector straight back, against its z axis by default."""

    # The direction in the end effector's frame; its length is ignored.
    along: Annotated[
        list[Annotated[float, Unbounded("a direction")]], Len(3, 3)
    ] = dc.field(default_factory=lambda: [0.0, 0.0, -1.0])


@dc.dataclass
class Lift(StepConfig):
    """Moves the end effector straight along a direction in W, up by default."""

    # The motion, along the axes of W [m].
    by: Shift = dc.field(default_factory=lambda: [0.0, 0.0, 0.1])
    # Its speed [m/s].
    speed: Speed = 0.1


@dc.dataclass
class DriveTo(StepConfig):
    """Moves the base to a pose, on any path.

    The arm may move during the drive. At the end, it has the same joint
    positions as at the start.
    """

    # Pose x, y, yaw of the base in W [m, m, rad].
    base_pose: Position = dc.field(default_factory=lambda: [0.0] * 3)
    # Distance to the goal that counts as arrival of the base [m].
    position: Annotated[float, Interval(gt=0, le=0.5)] = 0.02

    def check(self) -> Iterator[tuple[str, str]]:
        """Checks that the yaw is not in degrees.

        Yields:
            The name of a field and its problem.
        """
        yield from super().check()
        for yaw in self.base_pose[2:]:
            if abs(yaw) > math.tau:
                yield "base_pose", f"the yaw is in radians, got {yaw:g}"


@dc.dataclass
class Open(StepConfig):
    """Opens the hand."""

    # Opening of the hand; absent: the greatest [m].
    width: Width | None = None


@dc.dataclass
class Close(StepConfig):
    """Closes the hand to a width, or until an object stops its fingers."""

    # Its opening [m].
    width: Width = 0.0
    # Force with which the hand closes [N].
    force: Force = 20.0


@dc.dataclass
class Attach(StepConfig):
    """Treats the object in the hand as carried from now on."""

    # Name of the object.
    object: str = ""
    # Object on which the attached object stands, and which it may touch until
    # it is lifted.
    support: str = ""


@dc.dataclass
class MoveTo(StepConfig, PoseConfig):
    """Moves the carried object to a pose X_WO, on any path."""


@dc.dataclass
class Release(StepConfig):
    """Leaves the carried object where it is, and opens the hand."""

    # Opening of the hand; absent: the greatest [m].
    width: Width | None = None


@dc.dataclass
class GraspConfig(PoseConfig):
    """A grasp: the pose X_OE of the end effector in the object's frame.

    The end effector's z axis points to the object, and the fingers close along
    y.
    """

    # Opening of the hand around the object [m].
    width: Width = 0.04
    # Force with which the hand holds the object; absent: the `force` of the
    # step [N].
    force: Force | None = None


@dc.dataclass
class Grasping(StepConfig):
    """Settings common to the steps that grasp an object."""

    # Name of the object.
    object: str = ""
    # The grasps, in the order in which they are tried.
    grasps: Annotated[list[GraspConfig], Len(0, 1000)] = dc.field(
        default_factory=list
    )
    # Amount by which the hand's commanded width is less than the grasp's width,
    # so that the hand presses on the object [m]. It has no effect on a
    # kinematic station, where the object does not stop the fingers.
    squeeze: Width = 0.01
    # Force with which the hand holds the object [N].
    force: Force = 20.0
    # Length of the straight approach along the hand's z axis [m].
    approach: Length = 0.1
    # Speed on straight lines [m/s].
    speed: Speed = 0.1


@dc.dataclass
class Pick(Grasping):
    """Picks an object: opens the hand, reaches, closes it, lifts the object."""

    # Object on which the picked object stands; empty if it stands on none of
    # the task's objects.
    support: str = ""
    # Motion by which the object is lifted, along the axes of W [m].
    lift: Shift = dc.field(default_factory=lambda: [0.0, 0.0, 0.1])


@dc.dataclass
class TakeOver(Grasping):
    """Takes an object from another hand, which then opens and retreats."""

    # Distance by which the other hand retreats straight [m].
    retreat: Length = 0.1


@dc.dataclass
class Place(StepConfig):
    """Puts the carried object down: lowers and releases it, then retreats."""

    # Object on which the carried object is put; empty if it is put on none of
    # the task's objects.
    support: str = ""
    # The poses X_WO, in the order in which they are tried; empty: free places
    # on top of the support.
    places: Annotated[list[PoseConfig], Len(0, 1000)] = dc.field(
        default_factory=list
    )
    # Point x, y, z in W near which a free place is searched [m]; absent: the
    # middle of the support.
    near: Position | None = None
    # Length of the straight motion by which the object is lowered [m].
    lower: Length = 0.1
    # Distance by which the hand retreats straight [m].
    retreat: Length = 0.1
    # Speed on straight lines [m/s].
    speed: Speed = 0.1


AnyStep = (
    ReachTo
    | Approach
    | Retreat
    | Lift
    | DriveTo
    | Open
    | Close
    | Attach
    | MoveTo
    | Release
    | Pick
    | TakeOver
    | Place
)
"""Any step of a task."""
