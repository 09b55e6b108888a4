"""Computes one control tick, as a pure function of its inputs."""

from time import perf_counter

import numpy as np

from remosplat_drake.controller.program.guidance import DIRECT, Guidance
from remosplat_drake.controller.program.kernels.binding_arrays import BOUND_PART
from remosplat_drake.controller.program.kernels.compiled_terms import NO_PART
from remosplat_drake.controller.program.program_terms import row_name
from remosplat_drake.controller.tick.kernels.settle import (
    UNKNOWN,
    Settled,
    settle_tick,
)
from remosplat_drake.controller.tick.reactive_law import ReactiveLaw
from remosplat_drake.controller.tick.tick_calls import TickCalls
from remosplat_drake.controller.tick.tick_inputs import TickInputs
from remosplat_drake.controller.tick.tick_program import RowNames
from remosplat_drake.controller.verification.kernels.verified import OBJECTIONS
from remosplat_drake.controller.verification.map_calls import map_for_kernels
from remosplat_drake.controller.verification.protective_separation import (
    Monitoring,
    least_separation,
)
from remosplat_drake.scene.mover import Movers
from remosplat_drake.signals import tick_report
from remosplat_drake.signals.aim import Aim
from remosplat_drake.signals.binding import (
    BOUND,
    JOINT_LIMIT,
    NONE_BINDS,
    Binding,
    BoundRow,
)
from remosplat_drake.signals.distance_field import Clearances, DistanceField
from remosplat_drake.signals.motion import Motion, prompt_motion
from remosplat_drake.signals.row_arrays import row_arrays
from remosplat_drake.signals.separation import Separation
from remosplat_drake.signals.side_rows import with_side_rows
from remosplat_drake.signals.target import Target
from remosplat_drake.signals.tick_report import STATUSES, TickReport

TOO_SUDDEN = "infeasible with acceleration bounds"
"""Reason for dropping acceleration bounds."""

BindingArrays = tuple[np.ndarray, np.ndarray, np.ndarray]
"""Type of the result of `binding_arrays`."""

NOT_FEASIBLE = "no feasible command found"
"""Reason for braking if the program is infeasible even without acceleration
bounds."""


def run_tick(
    law: ReactiveLaw,
    time: float,
    q: np.ndarray,
    aim: Aim | Target | np.ndarray,
    clearances: Clearances,
    field: DistanceField,
    u_previous: np.ndarray,
    guidance: Guidance = DIRECT,
    motion: Motion | None = None,
    movers: Movers | None = None,
    periods: float = 1.0,
) -> TickReport:
    """Computes a tick: the program (paper eq. 1 to 4), and verify-then-scale.

    Args:
        law: The control law.
        time: Time of the tick [s].
        q: Configuration for which the command is computed, shape (n_q,) [rad,
            m]. For a robot with delay, it is predicted for the time after all
            commands sent so far have acted; otherwise, it is measured.
        aim: The targets of the end effectors, as an `Aim`. A `Target` or a pose
            X_WT of shape (4, 4) is also accepted; it is the target of the first
            end effector.
        clearances: The distances and directions of the distance oracle at q.
        field: The map, which verification queries along the command's path.
        u_previous: The command that was sent last, shape (n_u,).
        guidance: The guidance selected by `GuidanceSelector`.
        motion: Predicted motion that is caused by commands sent so far; None
            for a robot without delay.
        movers: The movers; None if none are known.
        periods: Number of control periods since `u_previous` was sent. It is
            more than one if the tick is late. After 1.5 periods, the station
            brakes by itself.

    Returns:
        The report, which contains the command. The command is a step of the
        braking ramp if q or the aim is not finite, if the clearances are
        unknown, or if a term is invalid.

    Raises:
        NameTakenError: Two terms of one kind have the same name.
        IngredientError: A user's ingredient raises an exception.
    """
    start = perf_counter()
    late = prompt_motion(law.robot.n_u) if motion is None else motion.arrays
    given = TickInputs(time, Aim.of(aim), field, guidance, late, movers)
    # The arrays are copied, since Numba would compile again for read-only
    # arrays.
    q, u = np.array(q, float), np.array(u_previous, float)
    near = clearances.within(law.collision.influence)
    stopping = guidance.stopping
    if stopping is None:
        stopping = law.collision.stopping
    near = with_side_rows(near, field, law.robot, q, stopping)
    calls = TickCalls(law, given)
    with calls as line:
        found = _settled(law, given, near, q, u, float(periods), line)
    problem = UNKNOWN[found.unknown] or calls.unusable
    names = RowNames(law.compiled.ingredients, law.robot, movers, calls.outside)
    binding = named_binding(found.binding, names)
    seconds = perf_counter() - start
    timings = {"solve": calls.solving, "tick": seconds - calls.solving}
    return TickReport(
        time=time,
        q=q,
        command=found.command,
        status=STATUSES[found.status],
        reason=problem or _reason(found, names),
        scale=found.scale,
        clearances=Clearances.none() if found.unknown else near,
        kept=found.kept,
        tight=found.tight,
        aim=given.aim,
        binding=binding,
        inside=_inside(law, found, names, q),
        line_deviation=_line_deviation(law, given.aim, q),
        objection=OBJECTIONS[found.objection],
        separation=_separation(law, given, q, found.command),
        payload=law.robot.payload,
        timings=timings,
    )


def _settled(
    law: ReactiveLaw,
    given: TickInputs,
    near: Clearances,
    q: np.ndarray,
    u_previous: np.ndarray,
    periods: float,
    line: int,
) -> Settled:
    movers = given.moving
    return Settled(
        *settle_tick(
            law.arrays,
            law.robot.arrays,
            *map_for_kernels(given.field),
            movers.arrays,
            movers.age(given.time),
            given.motion,
            float(given.time),
            given.aim.arrays,
            row_arrays(near),
            q,
            u_previous,
            periods,
            given.guidance.arrays,
            line,
        )
    )


def named_binding(found: BindingArrays, names: RowNames) -> Binding:
    """Returns the active rows with their names.

    Args:
        found: The result of `binding_arrays`.
        names: Function that returns the subject of a row.
    """
    tight, A, push = found
    if not len(tight):
        return NONE_BINDS
    rows = []
    for part, index, about in tight.tolist():
        is_bound = part == BOUND_PART
        row = (BOUND, index, ()) if is_bound else names.name(part, index, about)
        rows.append(BoundRow(*row))
    return Binding(tuple(rows), A, push)


def _inside(
    law: ReactiveLaw, found: Settled, names: RowNames, q: np.ndarray
) -> BoundRow | None:
    """Returns the row with the deepest violation; None if there is none."""
    if found.inside[0] != NO_PART:
        return BoundRow(*names.name(*found.inside))
    robot = law.robot
    beyond = robot.excess(q)
    if not beyond.max() > 0.0:
        return None
    joint = int(beyond.argmax())
    return BoundRow(JOINT_LIMIT, joint, (robot.joint_names[joint],))


def _reason(found: Settled, names: RowNames) -> str:
    """Returns the reason why the command is not the optimum of the program."""
    status = STATUSES[found.status]
    if status == tick_report.OPTIMAL:
        return ""
    if status == tick_report.ACCELERATION_DROPPED:
        return TOO_SUDDEN
    if status == tick_report.BRAKING:
        return NOT_FEASIBLE
    rows = [
        names.name(part, 0, about) for part, about in found.yielded.tolist()
    ]
    said = [row_name(name, about) for name, _, about in rows]
    return f"infeasible; yielded: {', '.join(said)}"


def _line_deviation(law: ReactiveLaw, aim: Aim, q: np.ndarray) -> float:
    if not aim.has_line:
        return float("nan")
    return aim.line_deviation(law.robot.end_effector_poses(q))


def _separation(
    law: ReactiveLaw, given: TickInputs, q: np.ndarray, u: np.ndarray
) -> Separation | None:
    """Returns the pair with the least margin of the separation distance."""
    robot, movers, motion = law.robot, given.movers, given.motion
    if movers is None or not len(movers) or not np.isfinite(q).all():
        return None
    delay = motion.start - given.time if motion.is_late else 0.0
    tube = robot.sphere_tube(motion.tube, np.abs(u))
    monitoring = Monitoring.make(
        u, robot.acceleration_limit, law.dt, law.movers.separation, delay
    )
    return least_separation(
        robot.spheres.links,
        robot.state(q),
        movers,
        given.time,
        u,
        monitoring,
        tube,
    )
