"""One control tick in one compiled call, and its report."""

from collections.abc import Sequence
from time import perf_counter

import numpy as np

from remosplat_drake.base.packed import Packed
from remosplat_drake.controller.compiled_program import named_binding
from remosplat_drake.controller.decision import (
    NOT_FEASIBLE,
    TOO_SUDDEN,
    yielding_reason,
)
from remosplat_drake.controller.guidance.guidance import Guidance
from remosplat_drake.controller.kernels.compiled_ingredient import (
    CompiledIngredient,
)
from remosplat_drake.controller.kernels.decide import NOT_DECIDED
from remosplat_drake.controller.kernels.settle import (
    Settled,
    settle_tick,
    verify_tick,
)
from remosplat_drake.controller.program_data import names_of, row_name
from remosplat_drake.controller.reactive_law import ReactiveLaw
from remosplat_drake.controller.verification.kernels.verified import OBJECTIONS
from remosplat_drake.controller.verification.verify import Verdict
from remosplat_drake.scene.mover import STILL, Movers
from remosplat_drake.signals import tick_report
from remosplat_drake.signals.aim import Aim
from remosplat_drake.signals.binding import COLLISION, Binding
from remosplat_drake.signals.compiled_map import Misplacement
from remosplat_drake.signals.distance_field import Clearances, DistanceField
from remosplat_drake.signals.tick_report import STATUSES, TickReport


def settled_tick(
    law: ReactiveLaw,
    time: float,
    q: np.ndarray,
    aim: Aim,
    clearances: Clearances,
    field: DistanceField,
    u_previous: np.ndarray,
    guidance: Guidance,
    movers: Movers | None,
) -> TickReport | None:
    """Runs a tick as `run_tick` does, in one compiled call.

    Args:
        law: The control law.
        time: Time of the tick [s].
        q: Measured configuration, finite, shape (n_q,) [rad, m].
        aim: What the end effectors shall reach, finite.
        clearances: The oracle's answer at q, all within the influence distance.
        field: The map, which verification asks along the command's path.
        u_previous: The command being executed, shape (n_u,).
        guidance: How the tick is bent.
        movers: What moves; None if nothing is known to.

    Returns:
        The report, without the separation from what moves; None where kernels
        cannot run the tick: with another solver, ingredients from outside, or
        a map that only Python can ask.
    """
    start, loop = perf_counter(), law.loop
    placed = field.placed if field.is_lipschitz else None
    if loop is None or placed is None:
        return None
    q = np.array(q, float)
    moving = STILL if movers is None else movers
    rows = clearances.sphere, clearances.distance, clearances.direction_W
    found = Settled(
        *settle_tick(
            loop,
            law.robot.arrays,
            *placed,
            moving.arrays,
            moving.age(time),
            aim.arrays,
            # Copies, since numba compiles for arrays that may be written.
            tuple(np.array(values) for values in rows),
            q,
            np.array(u_previous, float),
            guidance.arrays,
        )
    )
    if found.status == NOT_DECIDED:
        return None
    parts = law.compiled.ingredients
    binding = named_binding(parts, law.robot, movers, *found.binding)
    end = perf_counter()
    return TickReport(
        time=time,
        q=q,
        command=found.command,
        status=STATUSES[found.status],
        reason=_reason(found, parts, law, movers),
        scale=found.scale,
        clearances=clearances,
        kept=found.kept,
        tight=tight_clearances(binding, len(clearances)),
        aim=aim,
        binding=binding,
        line_deviation=_line_deviation(law, aim, q),
        objection=OBJECTIONS[found.objection],
        timings={"one_call": end - start},
    )


def compiled_verdict(
    law: ReactiveLaw,
    placed: tuple[Packed, Misplacement],
    time: float,
    q: np.ndarray,
    clearances: Clearances,
    u: np.ndarray,
    u_previous: np.ndarray,
    guidance: Guidance,
    movers: Movers | None,
) -> Verdict:
    """Verifies a command as `verified_command` does, in one compiled call.

    Args:
        law: The control law.
        placed: The map, as `DistanceField.placed`; it is 1-Lipschitz.
        time: Time of the tick [s].
        q: Measured configuration, shape (n_q,) [rad, m].
        clearances: The oracle's answer there.
        u: The wanted command, shape (n_u,).
        u_previous: The command being executed, shape (n_u,).
        guidance: How the tick is bent.
        movers: What moves; None if nothing is known to.
    """
    compiled, off = placed
    moving = STILL if movers is None else movers
    command, scale, objection = verify_tick(
        law.arrays,
        law.robot.arrays,
        compiled,
        off,
        moving.arrays,
        moving.age(time),
        # Copies, since numba compiles for arrays that may be written.
        np.array(q, float),
        np.array(clearances.sphere),
        np.array(clearances.distance),
        float(law.collision.stopping_for(guidance)),
        np.array(u, float),
        np.array(u_previous, float),
    )
    return Verdict(command, scale, OBJECTIONS[objection])


def tight_clearances(binding: Binding, m: int) -> np.ndarray:
    """Returns which of m clearances hold with equality, shape (m,), bool.

    Args:
        binding: All rows that do.
        m: Number of clearances.
    """
    tight = np.zeros(m, bool)
    for row in binding.rows:
        if row.name == COLLISION:
            tight[row.index] = True
    return tight


def _reason(
    found: Settled,
    parts: Sequence[CompiledIngredient],
    law: ReactiveLaw,
    movers: Movers | None,
) -> str:
    """Says why the command is not the optimum of the whole program."""
    status = STATUSES[found.status]
    if status == tick_report.OPTIMAL:
        return ""
    if status == tick_report.ACCELERATION_DROPPED:
        return TOO_SUDDEN
    if status == tick_report.BRAKING:
        return NOT_FEASIBLE
    names = []
    for number, about in found.yielded.tolist():
        part = parts[number]
        said = names_of(part.about(law.robot, movers, about))
        names.append(row_name(part.term, said))
    return yielding_reason(names)


def _line_deviation(law: ReactiveLaw, aim: Aim, q: np.ndarray) -> float:
    if not aim.has_line:
        return float("nan")
    return aim.line_deviation(law.robot.end_effector_poses(q))
