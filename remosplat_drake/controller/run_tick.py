"""One control tick as a pure function: state in, command and report out."""

import math
from time import perf_counter

import numpy as np

from remosplat_drake.controller.binding import find_binding
from remosplat_drake.controller.decision import Decision, brake, decide
from remosplat_drake.controller.guidance.guidance import DIRECT, Guidance
from remosplat_drake.controller.reactive_law import ReactiveLaw
from remosplat_drake.controller.tick import Tick
from remosplat_drake.controller.verification.committed import committed
from remosplat_drake.controller.verification.protective_separation import (
    Monitoring,
    least_separation,
)
from remosplat_drake.controller.verification.verify import (
    Surroundings,
    Verdict,
    verified_command,
)
from remosplat_drake.robot.robot_state import RobotState
from remosplat_drake.scene.mover import MoverArrays, Movers
from remosplat_drake.signals.aim import Aim
from remosplat_drake.signals.binding import COLLISION, NONE_BINDS, Binding
from remosplat_drake.signals.distance_field import Clearances, DistanceField
from remosplat_drake.signals.motion import Motion
from remosplat_drake.signals.separation import Separation
from remosplat_drake.signals.target import Target
from remosplat_drake.signals.tick_report import TickReport


def run_tick(
    law: ReactiveLaw,
    time: float,
    q: np.ndarray,
    aim: Aim | Target | np.ndarray,
    clearances: Clearances,
    field: DistanceField,
    u_previous: np.ndarray,
    guidance: Guidance = DIRECT,
    state: RobotState | None = None,
    motion: Motion | None = None,
    movers: Movers | None = None,
) -> TickReport:
    """Runs one tick: the program (paper eq. 1 to 4), then verify-then-scale.

    Args:
        law: The control law.
        time: Time of the tick [s].
        q: Configuration to plan from, measured or where all commands in flight
            lead, shape (n_q,) [rad, m].
        aim: What the end effectors shall reach: an `Aim`, or for the first of
            them a `Target` or the pose X_WT of a plain one, shape (4, 4).
        clearances: The oracle's distances and directions at q.
        field: The map, which verification asks along the command's path.
        u_previous: The command being executed, shape (n_u,).
        guidance: How the tick is bent, as `GuidanceSelector` has chosen.
        state: Kinematics at q, if the caller has them already.
        motion: What the robot is about to do already; None where it obeys at
            once.
        movers: What moves; None if nothing is known to.

    Returns:
        The command, and how it came about. Where q or the aim is not
        finite, or the clearances are not known, it is a step of the braking
        ramp.
    """
    start, aim = perf_counter(), Aim.of(aim)
    problem = _unknown_surroundings(q, clearances)
    if problem:
        return _blind_report(law, time, q, aim, u_previous, problem)
    clearances = clearances.within(law.collision.influence)
    state = state or law.robot.state(q)
    after_kinematics = perf_counter()
    if aim.is_known:
        sphere_tube = None
        if motion is not None:
            sphere_tube = law.robot.sphere_tube(
                motion.model.tube, np.abs(u_previous)
            )
        tick = Tick(
            law.robot,
            state,
            aim,
            clearances,
            u_previous,
            law.dt,
            guidance,
            sphere_tube,
            movers,
            time,
        )
        program = law.program(tick)
        after_build = perf_counter()
        decision = decide(
            tick, law.ingredients, law.solver, program, strict=law.strict
        )
    else:
        after_build = perf_counter()
        decision = brake(law.robot, u_previous, law.dt, "target is not finite")
    after_solve = perf_counter()
    verdict = _verified(
        law,
        field,
        state,
        decision.u,
        u_previous,
        clearances,
        guidance,
        motion,
        _movers_at(movers, time, motion),
    )
    separation = _separation(law, state, verdict.command, time, motion, movers)
    end = perf_counter()
    program, binding = decision.program, NONE_BINDS
    if program is not None:
        binding = find_binding(program, decision.u)
    kept, tight = _row_flags(decision, binding, len(clearances))
    return TickReport(
        time=time,
        q=q,
        command=verdict.command,
        status=decision.status,
        reason=decision.reason,
        scale=verdict.scale,
        clearances=clearances,
        kept=kept,
        tight=tight,
        aim=aim,
        binding=binding,
        line_deviation=aim.line_deviation(state.X_WEs),
        objection=verdict.objection,
        separation=separation,
        timings={
            "kinematics": after_kinematics - start,
            "build": after_build - after_kinematics,
            "solve": after_solve - after_build,
            "verify": end - after_solve,
        },
    )


def _unknown_surroundings(q: np.ndarray, clearances: Clearances) -> str:
    # A sum is finite where all terms are: these few are, or are unit vectors.
    if not math.isfinite(float(q.sum())):
        return "measured configuration is not finite"
    directions = float(clearances.direction_W.sum())
    if not (clearances.is_known and math.isfinite(directions)):
        return "clearances are not finite"
    return ""


def _blind_report(
    law: ReactiveLaw,
    time: float,
    q: np.ndarray,
    aim: Aim,
    u_previous: np.ndarray,
    reason: str,
) -> TickReport:
    """Reports a step of the braking ramp that nothing can verify."""
    none = np.zeros(0, bool)
    decision = brake(law.robot, u_previous, law.dt, reason)
    return TickReport(
        time=time,
        q=q,
        command=decision.u,
        status=decision.status,
        reason=decision.reason,
        scale=1.0,
        clearances=Clearances.none(),
        kept=none,
        tight=none,
        aim=aim,
    )


def _verified(
    law: ReactiveLaw,
    field: DistanceField,
    state: RobotState,
    u: np.ndarray,
    u_previous: np.ndarray,
    clearances: Clearances,
    guidance: Guidance,
    motion: Motion | None,
    movers: MoverArrays | None,
) -> Verdict:
    """Returns the command that may be applied, and how it differs from u."""
    if not law.verify:
        return Verdict(u, 1.0)
    robot, collision = law.robot, law.collision
    around = Surroundings(
        robot,
        field,
        state,
        np.minimum(
            clearances.per_sphere(len(state.spheres)), collision.influence
        ),
        collision.stopping_for(guidance),
        law.dt,
        robot.acceleration_limit,
        law.self_clearance,
        movers=movers,
        separation=float(law.movers.separation),
    )
    if motion is not None:
        around = committed(around, motion, u, u_previous)
    return verified_command(around, u, u_previous)


def _movers_at(
    movers: Movers | None, time: float, motion: Motion | None
) -> MoverArrays | None:
    """Returns what moves, as it is known when a command begins to act."""
    if movers is None or not len(movers):
        return None
    seen = movers.at(time)
    start = time if motion is None else motion.start
    return seen._replace(age=seen.age + start - time)


def _separation(
    law: ReactiveLaw,
    state: RobotState,
    u: np.ndarray,
    time: float,
    motion: Motion | None,
    movers: Movers | None,
) -> Separation | None:
    """Returns where the protective separation distance is kept least."""
    if movers is None or not len(movers):
        return None
    robot, delay, tube = law.robot, 0.0, np.zeros(len(law.robot.spheres))
    if motion is not None:
        delay = motion.start - time
        tube = robot.sphere_tube(motion.model.tube, np.abs(u))
    monitoring = Monitoring.make(
        u, robot.acceleration_limit, law.dt, law.movers.separation, delay
    )
    return least_separation(
        robot.spheres.links, state, movers, time, u, monitoring, tube
    )


def _row_flags(
    decision: Decision, binding: Binding, m: int
) -> tuple[np.ndarray, np.ndarray]:
    tight = np.zeros(m, bool)
    tight[[row.index for row in binding.rows if row.name == COLLISION]] = True
    program = decision.program
    rows = program and program.rows.get(COLLISION)
    return (rows.kept if rows else np.zeros(m, bool)), tight
