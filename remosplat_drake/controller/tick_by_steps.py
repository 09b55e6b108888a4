"""One control tick step by step: any solver, ingredients, map and robot."""

import numpy as np

from remosplat_drake.base.clock import Laps
from remosplat_drake.controller.binding import find_binding
from remosplat_drake.controller.compiled_tick import (
    compiled_verdict,
    tight_clearances,
)
from remosplat_drake.controller.decision import Decision, brake, decide
from remosplat_drake.controller.reactive_law import ReactiveLaw
from remosplat_drake.controller.term import TermError
from remosplat_drake.controller.tick import Tick
from remosplat_drake.controller.tick_inputs import TickInputs
from remosplat_drake.controller.verification.committed import committed
from remosplat_drake.controller.verification.verify import (
    Surroundings,
    Verdict,
    verified_command,
)
from remosplat_drake.robot.robot_state import RobotState
from remosplat_drake.scene.mover import MoverArrays
from remosplat_drake.signals.binding import COLLISION, NONE_BINDS
from remosplat_drake.signals.tick_report import TickReport


def tick_by_steps(law: ReactiveLaw, given: TickInputs) -> TickReport:
    """Runs a tick as `run_tick` does, step by step.

    Args:
        law: The control law.
        given: What the tick is given.

    Returns:
        The report, without the separation from what moves.
    """
    laps = Laps()
    state = given.state or law.robot.state(given.q)
    laps.end("kinematics")
    try:
        decision = _decision(law, given, state, laps)
    except TermError as error:
        decision = _brake(law, given, str(error))
    laps.end("solve")
    verdict = _verdict(law, given, state, decision.u)
    laps.end("verify")
    return _report(given, state, decision, verdict, laps.seconds)


def _decision(
    law: ReactiveLaw, given: TickInputs, state: RobotState, laps: Laps
) -> Decision:
    if not given.aim.is_known:
        return _brake(law, given, "target is not finite")
    tick = _tick(law, given, state)
    program = law.program(tick)
    laps.end("build")
    return decide(tick, program, law.solver, strict=law.strict)


def _brake(law: ReactiveLaw, given: TickInputs, reason: str) -> Decision:
    return brake(law.robot, given.u_previous, law.dt, reason)


def _tick(law: ReactiveLaw, given: TickInputs, state: RobotState) -> Tick:
    """What the program's ingredients are told."""
    sphere_tube = None
    if given.motion is not None:
        sphere_tube = law.robot.sphere_tube(
            given.motion.model.tube, np.abs(given.u_previous)
        )
    return Tick(
        law.robot,
        state,
        given.aim,
        given.clearances,
        given.u_previous,
        law.dt,
        given.guidance,
        sphere_tube,
        given.movers,
        given.time,
    )


def _verdict(
    law: ReactiveLaw, given: TickInputs, state: RobotState, u: np.ndarray
) -> Verdict:
    """Returns the command that may be applied, and how it differs from u."""
    if not law.verify:
        return Verdict(u, 1.0)
    field = given.field
    if given.motion is None and field.is_lipschitz and field.placed is not None:
        return compiled_verdict(law, given, field.placed, u)
    robot, collision = law.robot, law.collision
    around = Surroundings(
        robot,
        field,
        state,
        np.minimum(
            given.clearances.per_sphere(len(state.spheres)),
            collision.influence,
        ),
        collision.stopping_for(given.guidance),
        law.dt,
        robot.acceleration_limit,
        law.self_clearance,
        movers=_movers_at_start(given),
        separation=float(law.movers.separation),
    )
    if given.motion is not None:
        around = committed(around, given.motion, u, given.u_previous)
    return verified_command(around, u, given.u_previous)


def _movers_at_start(given: TickInputs) -> MoverArrays | None:
    """Returns what moves, as it is known when a command begins to act."""
    if given.movers is None or not len(given.movers):
        return None
    time, motion = given.time, given.motion
    seen = given.movers.at(time)
    start = time if motion is None else motion.start
    return seen._replace(age=seen.age + start - time)


def _report(
    given: TickInputs,
    state: RobotState,
    decision: Decision,
    verdict: Verdict,
    timings: dict[str, float],
) -> TickReport:
    m, program = len(given.clearances), decision.program
    kept, binding = np.zeros(0, bool), NONE_BINDS
    if program is not None:
        binding = find_binding(program, decision.u)
        kept = program.kept(COLLISION)
    return TickReport(
        time=given.time,
        q=state.q,
        command=verdict.command,
        status=decision.status,
        reason=decision.reason,
        scale=verdict.scale,
        clearances=given.clearances,
        kept=kept if len(kept) else np.zeros(m, bool),
        tight=tight_clearances(binding, m),
        aim=given.aim,
        binding=binding,
        line_deviation=given.aim.line_deviation(state.X_WEs),
        objection=verdict.objection,
        timings=timings,
    )
