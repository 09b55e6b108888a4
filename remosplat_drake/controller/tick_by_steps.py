"""One control tick step by step: any solver, ingredients, map and robot."""

from time import perf_counter

import numpy as np

from remosplat_drake.controller.binding import find_binding
from remosplat_drake.controller.compiled_tick import (
    compiled_verdict,
    tight_clearances,
)
from remosplat_drake.controller.decision import brake, decide
from remosplat_drake.controller.guidance.guidance import Guidance
from remosplat_drake.controller.reactive_law import ReactiveLaw
from remosplat_drake.controller.tick import Tick
from remosplat_drake.controller.verification.committed import committed
from remosplat_drake.controller.verification.verify import (
    Surroundings,
    Verdict,
    verified_command,
)
from remosplat_drake.robot.robot_state import RobotState
from remosplat_drake.scene.mover import MoverArrays, Movers
from remosplat_drake.signals.aim import Aim
from remosplat_drake.signals.binding import COLLISION, NONE_BINDS
from remosplat_drake.signals.distance_field import Clearances, DistanceField
from remosplat_drake.signals.motion import Motion
from remosplat_drake.signals.tick_report import TickReport


def tick_by_steps(
    law: ReactiveLaw,
    time: float,
    q: np.ndarray,
    aim: Aim,
    clearances: Clearances,
    field: DistanceField,
    u_previous: np.ndarray,
    guidance: Guidance,
    state: RobotState | None,
    motion: Motion | None,
    movers: Movers | None,
) -> TickReport:
    """Runs a tick as `run_tick` does, step by step.

    Args:
        law: The control law.
        time: Time of the tick [s].
        q: Configuration to plan from, finite, shape (n_q,) [rad, m].
        aim: What the end effectors shall reach.
        clearances: The oracle's answer there, all within the influence
            distance.
        field: The map, which verification asks along the command's path.
        u_previous: The command being executed, shape (n_u,).
        guidance: How the tick is bent.
        state: Kinematics at q, if the caller has them already.
        motion: What the robot is about to do already; None where it obeys at
            once.
        movers: What moves; None if nothing is known to.

    Returns:
        The report, without the separation from what moves.
    """
    start = perf_counter()
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
    if not law.verify:
        verdict = Verdict(decision.u, 1.0)
    elif motion is None and field.is_lipschitz and field.placed is not None:
        verdict = compiled_verdict(
            law,
            field.placed,
            time,
            q,
            clearances,
            decision.u,
            u_previous,
            guidance,
            movers,
        )
    else:
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
    end = perf_counter()
    m, program = len(clearances), decision.program
    kept, binding = np.zeros(0, bool), NONE_BINDS
    if program is not None:
        binding = find_binding(program, decision.u)
        kept = program.kept(COLLISION)
    return TickReport(
        time=time,
        q=state.q,
        command=verdict.command,
        status=decision.status,
        reason=decision.reason,
        scale=verdict.scale,
        clearances=clearances,
        kept=kept if len(kept) else np.zeros(m, bool),
        tight=tight_clearances(binding, m),
        aim=aim,
        binding=binding,
        line_deviation=aim.line_deviation(state.X_WEs),
        objection=verdict.objection,
        timings={
            "kinematics": after_kinematics - start,
            "build": after_build - after_kinematics,
            "solve": after_solve - after_build,
            "verify": end - after_solve,
        },
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
