"""`PageState`: the state of a run, as the page says it, and its buttons.

A page must not look live when the program behind it has stopped. Its texts
about the run as a whole, and its buttons that act on the robot, come from here.
"""

import dataclasses as dc

from remosplat_drake.signals import standing as stands
from remosplat_drake.signals.standing import NOT_STARTED, Standing
from remosplat_drake.signals.supervisor_state import (
    STARTING,
    UNARMED,
    SupervisorState,
)
from remosplat_drake.signals.supervisor_state import (
    STOPPED as AT_REST,
)

WAITING = "waiting"
"""Phase in which nothing moves until a person says so."""
LIVE = "live"
"""Phase in which the robot moves, or may at any moment."""
HELD = "held"
"""Phase in which something holds the robot back, though nothing stops it."""
STOPPED = "stopped"
"""Phase in which the supervisor has stopped the robot."""
REACHED, MISSED = "reached", "missed"
"""Phases after the end of the run: nothing moves any more."""
REPLAYED = "replayed"
"""Phase of a run that is shown again."""
STILL = "still"
"""Phase of a page on which nothing ever moves."""

START, STOP, RELEASE = "start", "stop", "release"
"""The buttons of a page."""


@dc.dataclass(frozen=True)
class PageState:
    """The robot's state, for a viewer of the page.

    Attributes:
        phase: WAITING, LIVE, HELD, STOPPED, REACHED, MISSED, REPLAYED or
            STILL.
        title: The robot's state, in a word or two.
        text: The same in a sentence; empty if there is no more to say.
        buttons: START, STOP and RELEASE, as far as they do something now.
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
        """Returns the state as JSON has it."""
        return {**dc.asdict(self), "over": self.is_over}


def preparing(text: str) -> PageState:
    """Returns the state before a run can start.

    Args:
        text: What is being done.
    """
    return PageState(WAITING, "Preparing", text)


def waiting(goal: str) -> PageState:
    """Returns the state before a run that a viewer of the page starts.

    Args:
        goal: What the run is for, in a sentence.
    """
    return PageState(WAITING, "Ready", goal, (START,))


def supervised(
    supervision: SupervisorState,
    *,
    releases: bool,
    standing: Standing = NOT_STARTED,
) -> PageState:
    """Returns the state while a supervisor watches over the robot.

    Args:
        supervision: What the supervisor does.
        releases: Whether the page may release stops, which a real robot's
            may not.
        standing: The robot's state while nothing is stopped.
    """
    reason = ": ".join(filter(None, (supervision.reason, supervision.refusal)))
    if not supervision.is_latched:
        if supervision.mode == STARTING and standing.kind == stands.WAITING:
            return PageState(LIVE, "Starting", reason, (STOP,))
        return _alive(standing, (STOP,))
    if supervision.reason == UNARMED:
        return PageState(WAITING, "Not armed", reason, (STOP,))
    if supervision.mode != AT_REST:
        return PageState(STOPPED, "Stopping", reason, (STOP,))
    buttons = (STOP, RELEASE) if releases else (STOP,)
    return PageState(STOPPED, "Stopped", reason, buttons)


def unsupervised(standing: Standing = NOT_STARTED) -> PageState:
    """Returns the state of a run without a supervisor: nothing stops it.

    Args:
        standing: The robot's state.
    """
    if standing.kind == stands.WAITING:
        text = "no supervisor: the page cannot stop this run"
        return PageState(LIVE, "Live", text)
    return _alive(standing, ())


def _alive(standing: Standing, buttons: tuple[str, ...]) -> PageState:
    if standing.kind == stands.HELD:
        return PageState(HELD, "Held", standing.text, buttons)
    text = "" if standing.kind == stands.WAITING else standing.text
    return PageState(LIVE, "Live", text, buttons)


def without_map(state: PageState) -> PageState:
    """Returns the state of a robot that moves only where it has no map.

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
        text: How it ended, in a sentence.
        reached: Whether the last target was reached.
    """
    title = "Reached" if reached else "Not reached"
    return PageState(REACHED if reached else MISSED, title, text)


def replayed(text: str) -> PageState:
    """Returns the state of a run that is shown again.

    Args:
        text: Which run it is.
    """
    return PageState(REPLAYED, "Replay", text)


def still(text: str) -> PageState:
    """Returns the state of a page on which nothing ever moves.

    Args:
        text: What it shows.
    """
    return PageState(STILL, "Inspect", text)
