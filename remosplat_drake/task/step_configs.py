"""The steps of a task, as a scenario has them."""

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
    """How near some links may come to an object while a step lasts."""

    # Name of the object.
    object: str = ""
    # Names of the links; empty: the hand's, its fingers and its palm.
    links: Annotated[list[str], Len(0, 100)] = dc.field(default_factory=list)
    # Distance that they keep from it; absent: they may touch it [m].
    stopping: Annotated[float, Interval(ge=0, le=1)] | None = None


@dc.dataclass
class StepConfig(Config):
    """What all steps have."""

    # Name of the end effector; empty for the first or only one.
    effector: str = ""
    # What may come nearer than the stopping distance while the step lasts.
    touch: Annotated[list[Touch], Len(0, 100)] = dc.field(default_factory=list)
    # Time after which the step has failed [s].
    patience: Annotated[float, Interval(gt=0, le=1e5)] = 20.0
    # Distance at which the end effector has arrived [m].
    position: Annotated[float, Interval(gt=0, le=0.1)] = 0.005
    # Angle at which it has arrived [deg].
    angle: Annotated[float, Interval(gt=0, le=45)] = 1.0


@dc.dataclass
class ReachTo(StepConfig, PoseConfig):
    """Brings the end effector to a pose, on a free way."""

    # Object relative to which the pose is meant; empty: it is in W.
    object: str = ""


@dc.dataclass
class Approach(StepConfig):
    """Moves the end effector straight along a direction of its own."""

    # The direction in the end effector's frame; its length does not count.
    along: Annotated[
        list[Annotated[float, Unbounded("a direction")]], Len(3, 3)
    ] = dc.field(default_factory=lambda: [0.0, 0.0, 1.0])
    # How far it moves [m].
    distance: Length = 0.1
    # Its speed [m/s].
    speed: Speed = 0.1

    def check(self) -> Iterator[tuple[str, str]]:
        """Checks that the direction is one.

        Yields:
            The name of a field and what is wrong with it.
        """
        yield from super().check()
        if not any(self.along):
            yield "along", "is no direction: all three numbers are zero"


@dc.dataclass
class Retreat(Approach):
    """Moves the end effector straight back, against its z axis by default."""

    # The direction in the end effector's frame; its length does not count.
    along: Annotated[
        list[Annotated[float, Unbounded("a direction")]], Len(3, 3)
    ] = dc.field(default_factory=lambda: [0.0, 0.0, -1.0])


@dc.dataclass
class Lift(StepConfig):
    """Moves the end effector straight, up by default."""

    # How far it moves along the axes of W [m].
    by: Shift = dc.field(default_factory=lambda: [0.0, 0.0, 0.1])
    # Its speed [m/s].
    speed: Speed = 0.1


@dc.dataclass
class DriveTo(StepConfig):
    """Brings the base to a pose, on a free way.

    The arm may move on the way, and ends as it was.
    """

    # Pose x, y, yaw of the base in W [m, m, rad].
    base_pose: Position = dc.field(default_factory=lambda: [0.0] * 3)
    # Distance at which the base has arrived [m].
    position: Annotated[float, Interval(gt=0, le=0.5)] = 0.02

    def check(self) -> Iterator[tuple[str, str]]:
        """Checks that the yaw is not in degrees.

        Yields:
            The name of a field and what is wrong with it.
        """
        yield from super().check()
        for yaw in self.base_pose[2:]:
            if abs(yaw) > math.tau:
                yield "base_pose", f"the yaw is in radians, got {yaw:g}"


@dc.dataclass
class Open(StepConfig):
    """Opens the hand."""

    # Its opening; absent: as wide as it goes [m].
    width: Width | None = None


@dc.dataclass
class Close(StepConfig):
    """Closes the hand, to a width or until something is in the way."""

    # Its opening [m].
    width: Width = 0.0
    # The force with which it closes [N].
    force: Force = 20.0


@dc.dataclass
class Attach(StepConfig):
    """Takes an object that is in the hand to be carried from now on."""

    # Name of the object.
    object: str = ""
    # Object that it stands on, which it may touch until it is lifted.
    support: str = ""


@dc.dataclass
class MoveTo(StepConfig, PoseConfig):
    """Brings the carried object to a pose X_WO, on a free way."""


@dc.dataclass
class Release(StepConfig):
    """Leaves the carried object where it is, and opens the hand."""

    # Opening of the hand; absent: as wide as it goes [m].
    width: Width | None = None


@dc.dataclass
class GraspConfig(PoseConfig):
    """Where the end effector takes an object: its pose in the object's frame.

    Its z axis points to the object, and its fingers close along y.
    """

    # Opening of the hand around the object [m].
    width: Width = 0.04
    # Force with which the hand holds it; absent: that of the step [N].
    force: Force | None = None


@dc.dataclass
class Grasping(StepConfig):
    """What taking an object has, wherever it is."""

    # Name of the object.
    object: str = ""
    # The grasps that are tried, one after the other.
    grasps: Annotated[list[GraspConfig], Len(0, 1000)] = dc.field(
        default_factory=list
    )
    # How much narrower than the grasp the hand is commanded to be, so that it
    # presses on what it holds. It does not count on a kinematic station, where
    # nothing stops the fingers [m].
    squeeze: Width = 0.01
    # Force with which the hand holds it [N].
    force: Force = 20.0
    # Length of the straight approach along the hand's z axis [m].
    approach: Length = 0.1
    # Speed on straight lines [m/s].
    speed: Speed = 0.1


@dc.dataclass
class Pick(Grasping):
    """Takes an object: opens, reaches, approaches, closes, attaches, lifts."""

    # Object that it stands on; empty for none that is known.
    support: str = ""
    # How far it is lifted, along the axes of W [m].
    lift: Shift = dc.field(default_factory=lambda: [0.0, 0.0, 0.1])


@dc.dataclass
class TakeOver(Grasping):
    """Takes an object out of another hand, which then opens and retreats."""

    # How far the other hand retreats straight [m].
    retreat: Length = 0.1


@dc.dataclass
class Place(StepConfig):
    """Puts the carried object down: moves over, lowers, releases, retreats."""

    # Object that it is put on; empty for none that is known.
    support: str = ""
    # The poses X_WO that are tried, one after the other.
    places: Annotated[list[PoseConfig], Len(0, 1000)] = dc.field(
        default_factory=list
    )
    # How far it is lowered straight [m].
    lower: Length = 0.1
    # How far the hand retreats straight [m].
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
