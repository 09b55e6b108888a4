"""One control tick as a pure function: state in, command and report out."""

import dataclasses as dc
import math

import numpy as np

from remosplat_drake.controller.compiled_tick import settled_tick
from remosplat_drake.controller.decision import brake
from remosplat_drake.controller.guidance.guidance import DIRECT, Guidance
from remosplat_drake.controller.reactive_law import ReactiveLaw
from remosplat_drake.controller.tick_by_steps import tick_by_steps
from remosplat_drake.controller.tick_inputs import TickInputs
from remosplat_drake.controller.verification.protective_separation import (
    Monitoring,
    least_separation,
)
from remosplat_drake.robot.robot_state import RobotState
from remosplat_drake.scene.mover import Movers
from remosplat_drake.signals.aim import Aim
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
    aim = Aim.of(aim)
    problem = _unknown_surroundings(q, clearances)
    if problem:
        return _blind_report(law, time, q, aim, u_previous, problem)
    given = TickInputs(
        time,
        q,
        aim,
        clearances.within(law.collision.influence),
        field,
        u_previous,
        guidance,
        state,
        motion,
        movers,
    )
    report = settled_tick(law, given) or tick_by_steps(law, given)
    if movers is None or not len(movers):
        return report
    state = state or law.robot.state(q)
    separation = _separation(law, state, report.command, time, motion, movers)
    return dc.replace(report, separation=separation)


def _unknown_surroundings(q: np.ndarray, clearances: Clearances) -> str:
    # A sum of squares is finite where all terms are; nothing is that large.
    if not math.isfinite(np.dot(q, q)):
        return "measured configuration is not finite"
    n_W, distance = clearances.direction_W, clearances.distance
    is_known = math.isfinite(np.dot(distance, distance)) or clearances.is_known
    if not (is_known and math.isfinite(np.vdot(n_W, n_W))):
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


def _separation(
    law: ReactiveLaw,
    state: RobotState,
    u: np.ndarray,
    time: float,
    motion: Motion | None,
    movers: Movers,
) -> Separation | None:
    """Returns where the protective separation distance is kept least."""
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
