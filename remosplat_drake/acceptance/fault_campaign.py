"""The fault campaign: checks the reactions of robot and controller to faults.

The simulated robot and the controller are separate processes on an LCM network,
as in a laboratory. One fault is injected while the robot moves. While the fault
lasts, a release of the stop must be refused. Then the fault is removed, and the
robot must stay at rest until the stop is released. After the release, the robot
must continue. The simulated robot's true motion is evaluated.
"""

import dataclasses as dc
import math
import tempfile
from collections.abc import Sequence
from pathlib import Path

from remosplat_drake.acceptance.fault_case import (
    GOES_ON,
    MOVES,
    REACHES,
    STAYS,
    STOPS,
    FaultCase,
    Part,
)
from remosplat_drake.acceptance.fault_run import STOP_LIMIT, FaultRun
from remosplat_drake.acceptance.hardware_processes import STAND_IN
from remosplat_drake.acceptance.motion_judge import (
    CREEP,
    StopQuality,
    TrueRun,
    distance_moved,
    judge_stop,
    true_clearance,
)
from remosplat_drake.app.run_result import REACHED
from remosplat_drake.app.world import World
from remosplat_drake.base.errors import MissingExtraError

_ATTEMPTS = 5
"""A case is run at most this many times if its runs fail before the fault
begins."""


@dc.dataclass(frozen=True)
class FaultResult:
    """The result of one case of the fault campaign.

    Attributes:
        case: The case with its fault.
        reason: Reason of the stop, as the controller displays it.
        time_to_zero: Time from the fault to a standstill [s]; NaN if there was
            none.
        moved_after: Largest distance that any part of the robot moved between
            the standstill and the release [m]; NaN if there was no standstill.
        refusal: Answer of the controller to a release while the fault was
            present.
        resumed: Behaviour after the release: REACHES, MOVES or STAYS. It is
            STAYS if there was no release.
        clearance: Smallest true distance from the scene over the whole run
            [m].
        problem: Deviation from the expected outcome; empty if there is none.
    """

    case: FaultCase
    reason: str
    time_to_zero: float = math.nan
    moved_after: float = math.nan
    refusal: str = ""
    resumed: str = ""
    clearance: float = math.nan
    problem: str = ""


def run_case(
    case: FaultCase, world: World, stand_in: Sequence[str] = STAND_IN
) -> FaultResult:
    """Runs robot and controller with one fault, and judges the outcome.

    Args:
        case: The fault to inject, and the outcome to expect.
        world: World of the default scenario, with the true geometry.
        stand_in: Command line of the simulated robot, which takes the arguments
            of `hardware-sim`.
    """
    problem = ""
    for _ in range(_ATTEMPTS):
        with tempfile.TemporaryDirectory() as folder:
            try:
                run = FaultRun(case, Path(folder), stand_in)
            except MissingExtraError as error:
                return FaultResult(case, str(error), problem="not tried")
            problem = run.carry_out()
            if not problem:
                return _judged(run, case, world)
    return FaultResult(case, problem, problem="not tried")


def _judged(run: FaultRun, case: FaultCase, world: World) -> FaultResult:
    """Judges a run in a world with the true geometry of its case."""
    assert world.truth_field is not None
    robot, true_run = world.robot, TrueRun.read(run.motion)
    result = FaultResult(
        case,
        run.reason,
        refusal=run.refusal,
        resumed=_resumed(run, true_run, world),
        clearance=true_clearance(true_run, robot, world.truth_field),
    )
    if case.outcome != GOES_ON:
        stop = _judged_stop(run, case, true_run.until(run.released), world)
        result = dc.replace(result, **vars(stop))
    problem = (
        _without_effect(run, case)
        or run.company.problem(robot)
        or _problem(result)
    )
    return dc.replace(result, problem=problem)


def _judged_stop(
    run: FaultRun, case: FaultCase, true_run: TrueRun, world: World
) -> StopQuality:
    """Judges the stop from the motion until the release."""
    if case.part is Part.DRIVER_KILLED:
        # The record of a killed robot is lost. So the time of the last command
        # is used as the time of rest, and the record of the new process shows
        # whether the robot moved.
        moved = judge_stop(true_run, -math.inf, world.robot).moved_after
        return StopQuality(run.commanded - run.began, moved)
    began = run.first_stop if case.part is Part.TARGET else run.began
    return judge_stop(true_run, began, world.robot)


def _resumed(run: FaultRun, true_run: TrueRun, world: World) -> str:
    """Returns REACHES, MOVES or STAYS: the behaviour after the release."""
    if run.events[-1].get("outcome") == REACHED:
        return REACHES if math.isfinite(run.released) else STAYS
    after = true_run.since(run.released)
    return MOVES if distance_moved(after, world.robot) > CREEP else STAYS


def _without_effect(run: FaultRun, case: FaultCase) -> str:
    """Returns a problem if the controller did not detect the fault, or ""."""
    status = case.tick_status
    statuses = run.events[-1].get("statuses", {}) if status else {}
    if status and status not in statuses:
        return f"the fault had no effect: no tick was {status!r}"
    return ""


def _problem(result: FaultResult) -> str:
    case, reason = result.case, result.reason
    if not result.clearance > 0:
        return f"overlaps the scene by {-1e3 * result.clearance:.1f} mm"
    if result.clearance < case.clearance:
        return f"the clearance fell to {1e3 * result.clearance:.1f} mm"
    if case.outcome == GOES_ON:
        return ""
    if case.outcome == STOPS and not reason:
        return "the supervisor did not stop the robot"
    if not case.expects(reason):
        return f"the reason does not contain {case.reason!r}"
    if not result.time_to_zero < STOP_LIMIT:
        return "the robot did not come to rest"
    if not result.moved_after < CREEP:
        return f"the robot moved again by {1e3 * result.moved_after:.1f} mm"
    if case.refusal is not None and not result.refusal:
        return "a release was not refused while the fault was present"
    if (case.refusal or "") not in result.refusal:
        return f"a release was {result.refusal!r}"
    expected = result.resumed if case.resumes is None else case.resumes
    if case.outcome == STOPS and result.resumed != expected:
        return f"after the release: {result.resumed or 'nothing moved'!r}"
    return ""
