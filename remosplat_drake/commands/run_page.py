"""Shows the state of a run on its page, before the run and after it."""

from collections.abc import Sequence

from remosplat_drake.app.map_grade import GOOD, grade_map, wrong_by
from remosplat_drake.app.map_knowledge import MapKnowledge
from remosplat_drake.app.run_result import RunResult
from remosplat_drake.app.scenario import Scenario
from remosplat_drake.safety.gates import Gate
from remosplat_drake.signals import motion_status as states
from remosplat_drake.visualization.page import MeshcatPage
from remosplat_drake.visualization.page_state import PageState
from remosplat_drake.visualization.saved_page.account import Account, Moment

_LISTED_KINDS = (states.MOVING, states.HELD, states.STOPPED)
"""Kinds of robot states that a saved page lists as events of a run."""


def show_verdict(page: MeshcatPage, knowledge: MapKnowledge) -> None:
    """Shows the grade of a map as a coloured badge on the page.

    Args:
        page: The page of the run on that map.
        knowledge: Content, error and problems of the map.
    """
    error = knowledge.error
    if error.largest is None and not error.trouble:
        page.set_badge(GOOD, "Map", "the true geometry")
        return
    largest = error.largest
    parts = [
        "" if largest is None else wrong_by(largest),
        error.trouble,
        *error.warnings,
    ]
    grade = grade_map(error)
    text = "; ".join(filter(None, parts))
    page.set_badge(grade, f"Map {grade}:", text)


def show_warnings(page: MeshcatPage, warnings: Sequence[Gate]) -> None:
    """Shows the warnings about a run, before it begins.

    Args:
        page: The page.
        warnings: The warnings, one sentence each.
    """
    page.set_status("", "start", "; ".join(gate.problem for gate in warnings))


def account_of(
    result: RunResult,
    scenario: Scenario,
    state: PageState,
    facts: list[tuple[str, str]],
    start: float,
) -> Account:
    """Returns the summary of a run for a saved page.

    Args:
        result: Result of the run.
        scenario: The scenario that was run.
        state: The page's text about the result.
        facts: Names and values of the measurements.
        start: Time of the diagram at which the recording begins [s].
    """
    trajectory = result.trajectory
    collision = scenario.controller.collision
    time = trajectory.time - start
    moments = [
        Moment(at, motion_status.text)
        for at, motion_status in result.motion_history
        if motion_status.kind in _LISTED_KINDS
    ]
    if len(time):
        moments.append(Moment(float(time[-1]), state.title))
    return Account(
        state=state,
        time=time,
        q=trajectory.q[:-1],
        clearance=trajectory.clearance,
        stopping=collision.stopping,
        influence=collision.influence,
        moments=moments,
        facts=facts,
    )
