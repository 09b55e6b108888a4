"""`MotionStatus`: a robot's state and its cause, as a sentence and as data."""

import dataclasses as dc

import numpy as np

from remosplat_drake.signals.binding import JOINT_LIMIT, MOVER, SELF_COLLISION
from remosplat_drake.signals.thing import KINDS as KINDS_OF_THINGS

WAITING = "waiting"
"""Kind: the robot has not started, and waits for a condition."""
MOVING = "moving"
"""Kind: the robot moves to its target."""
HELD = "held"
"""Kind: the robot is at rest away from its target."""
REACHED = "reached"
"""Kind: the robot is at its target."""
STOPPING = "stopping"
"""Kind: the supervisor brakes the robot."""
STOPPED = "stopped"
"""Kind: the supervisor has stopped the robot until an operator releases it."""
ENDED = "ended"
"""Kind: the run is over, and the target was not reached."""

KINDS = (WAITING, MOVING, HELD, REACHED, STOPPING, STOPPED, ENDED)
"""All kinds of a robot's state."""

CONSTRAINT = "constraint"
"""Cause: a constraint of the controller's quadratic program that no other cause
describes."""
VERIFICATION = "verification"
"""Cause: verification rejects every command towards the target, since the robot
could not stop in time."""
NO_COMMAND = "no command"
"""Cause: the controller finds no feasible command, and brakes."""
NOT_OBEYED = "not obeyed"
"""Cause: the robot does not follow its commands, as in shadow mode."""
NOTHING = "nothing"
"""Cause: no constraint is active; the optimum of the quadratic program is no
motion."""
BASE = "base"
"""Cause: the base is not allowed to drive, or its safety scanner stopped it."""
LOCALIZATION = "localization"
"""Cause: the pose of the base in the map is not known well enough."""
SUPERVISOR = "supervisor"
"""Cause: the supervisor has stopped the robot."""
NO_CONFIGURATION = "no configuration"
"""Cause: no configuration reaches the target, or none was found."""
NO_PATH = "no path"
"""Cause: no path to the target was found."""

CAUSES = (
    *KINDS_OF_THINGS,
    JOINT_LIMIT,
    SELF_COLLISION,
    MOVER,
    CONSTRAINT,
    VERIFICATION,
    NO_COMMAND,
    NOT_OBEYED,
    NOTHING,
    BASE,
    LOCALIZATION,
    SUPERVISOR,
    NO_CONFIGURATION,
    NO_PATH,
)
"""All causes that keep a robot from moving: kinds of objects in the scene,
constraints of the robot, and other causes."""


@dc.dataclass(frozen=True, eq=False)
class MotionStatus:
    """The robot's state and its cause; copying returns the object itself.

    Attributes:
        kind: One of `KINDS`.
        text: The whole state in one sentence, for display.
        distance: Distance from the end effector to the target [m]; NaN if
            unknown.
        cause: The cause that keeps the robot from moving, one of `CAUSES`;
            empty if there is none.
        thing: Name of the cause, for example "the shelf" or "joint 4".
        link: Name of the link that cannot move, or that a stop concerns; empty
            if there is none.
        p_W: Point in W at which the robot cannot move on, or that a stop
            concerns, shape (3,) [m]; None if there is none.
        clearance: Distance from `link` to `thing` [m]; None if there is none.
        way: Statement of guidance about a way around the cause, for display;
            may be empty.
    """

    kind: str
    text: str
    distance: float = float("nan")
    cause: str = ""
    thing: str = ""
    link: str = ""
    p_W: np.ndarray | None = None
    clearance: float | None = None
    way: str = ""

    def __post_init__(self) -> None:
        """Copies a point that is a view, which keeps a larger array alive."""
        if self.p_W is not None and self.p_W.base is not None:
            object.__setattr__(self, "p_W", self.p_W.copy())

    def __deepcopy__(self, memo) -> "MotionStatus":
        return self

    @property
    def is_obstructed(self) -> bool:
        """Whether a cause keeps the robot from moving, or did at the end."""
        return self.kind in (HELD, STOPPING, STOPPED, ENDED)

    def is_news_after(self, before: "MotionStatus") -> bool:
        """Returns whether an earlier state has another kind, cause or name.

        Args:
            before: The earlier state.
        """
        names = "kind", "cause", "thing", "link", "way"
        return any(getattr(self, n) != getattr(before, n) for n in names)

    def document(self) -> dict:
        """Returns the attributes as a JSON object; unknown ones are null."""
        fields = {f.name: getattr(self, f.name) for f in dc.fields(self)}
        known = bool(np.isfinite(self.distance))
        fields["distance"] = self.distance if known else None
        fields["p_W"] = None if self.p_W is None else self.p_W.tolist()
        return fields


NOT_STARTED = MotionStatus(WAITING, "waiting for the first control tick")
"""The state before the first tick."""
