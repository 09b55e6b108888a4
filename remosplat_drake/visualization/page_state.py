"""`PageState`: the page's text about the state of a run, and its buttons.

This module makes the page's texts about the run as a whole, and selects the
buttons that act on the robot. After the program has ended, texts and buttons
must not suggest that the robot still moves.
"""

import dataclasses as dc

from remosplat_drake.signals import motion_status as states
from remosplat_drake.signals.motion_status import NOT_STARTED, MotionStatus
from remosplat_drake.signals.supervisor_state import (
    STARTING,
    UNARMED,
    SupervisorState,
)
from remosplat_drake.signals.supervisor_state import (
    STOPPED as AT_REST,
)

WAITING = "waiting"
"""Phase in which nothing moves until a person presses START."""
LIVE = "live"
"""Phase in which the robot moves, or may move at any moment."""
HELD = "held"
"""Phase in which an obstacle or a limit keeps the robot from its target, but
the supervisor has not stopped it."""
STOPPED = "stopped"
"""Phase in which the supervisor has stopped the robot."""
REACHED, MISSED = "reached", "missed"
"""Phases after the end of the run, in which nothing moves any more."""
REPLAYED = "replayed"
"""Phase of the replay of a recorded run."""
STILL = "still"
"""Phase of a page that shows a fixed scene."""

START, STOP, RELEASE = "start", "stop", "release"
"""The buttons of a page."""


@dc.dataclass(frozen=True)
class PageState:
    """The state of a run, as the page shows it to a viewer.

    Attributes:
        phase: WAITING, LIVE, HELD, STOPPED, REACHED, MISSED, REPLAYED or
            STILL.
        title: The state in a word or two.
        text: A sentence that describes the state further; may be empty.
        buttons: The buttons that have an effect now, out of START, STOP and
            RELEASE.
    """

    phase: str
    title: str
    text: str = ""
    buttons: tuple[str, ...] = ()

    @property
    def is_over(self) -> bool:
        """Whether the run has ended."""
        return self.phase in (REACHED, MISSED, REPLAYED)

    def document(self) -> dict:
        """Returns the state as types of JSON."""
        return {**dc.asdict(self), "over": self.is_over}


def preparing(text: str) -> PageState:
    """Returns the state before a run can start.

    Args:
        text: The present step of the preparation.
    """
    return PageState(WAITING, "Preparing", text)


def waiting(goal: str) -> PageState:
    """Returns the state while a run waits until a viewer presses START.

    Args:
        goal: Purpose of the run, in a sentence.
    """
    return PageState(WAITING, "Ready", goal, (START,))


def supervised(
    supervision: SupervisorState,
    *,
    releases: bool,
    motion_status: MotionStatus = NOT_STARTED,
) -> PageState:
    """Returns the state of a run with a supervisor.

    Args:
        supervision: The supervisor's state.
        releases: Whether the page may release stops. It must not release a real
            robot.
        motion_status: The robot's motion status, which the page shows while the
            supervisor does not stop the robot.
    """
    reason = ": ".join(filter(None, (supervision.reason, supervision.refusal)))
    if not supervision.is_latched:
        if (
            supervision.mode == STARTING
            and motion_status.kind == states.WAITING
        ):
            return PageState(LIVE, "Starting", reason, (STOP,))
        return _alive(motion_status, (STOP,))
    if supervision.reason == UNARMED:
        return PageState(WAITING, "Not armed", reason, (STOP,))
    if supervision.mode != AT_REST:
        return PageState(STOPPED, "Stopping", reason, (STOP,))
    buttons = (STOP, RELEASE) if releases else (STOP,)
    return PageState(STOPPED, "Stopped", reason, buttons)


def unsupervised(motion_status: MotionStatus = NOT_STARTED) -> PageState:
    """Returns the state of a run without a supervisor; it has no STOP.

    Args:
        motion_status: The robot's state.
    """
    if motion_status.kind == states.WAITING:
        text = "this run has no supervisor, so the page cannot stop it"
        return PageState(LIVE, "Live", text)
    return _alive(motion_status, ())


def _alive(motion_status: MotionStatus, buttons: tuple[str, ...]) -> PageState:
    if motion_status.kind == states.HELD:
        return PageState(HELD, "Held", motion_status.text, buttons)
    text = "" if motion_status.kind == states.WAITING else motion_status.text
    return PageState(LIVE, "Live", text, buttons)


def without_map(state: PageState) -> PageState:
    """Returns a state whose text adds that the robot has no map yet.

    Args:
        state: The robot's state.
    """
    if state.phase != LIVE:
        return state
    text = "; ".join(filter(None, ("scan first", state.text)))
    return dc.replace(state, phase=HELD, title="Live, without a map", text=text)


def ended(text: str, *, reached: bool) -> PageState:
    """Returns the state after a run.

    Args:
        text: Outcome of the run, in a sentence.
        reached: Whether the last target was reached.
    """
    title = "Reached" if reached else "Not reached"
    return PageState(REACHED if reached else MISSED, title, text)


def replayed(text: str) -> PageState:
    """Returns the state of the replay of a recorded run.

    Args:
        text: Description of the run.
    """
    return PageState(REPLAYED, "Replay", text)


def still(text: str) -> PageState:
    """Returns the state of a page that shows a fixed scene.

    Args:
        text: Description of the scene.
    """
    return PageState(STILL, "Inspect", text)
