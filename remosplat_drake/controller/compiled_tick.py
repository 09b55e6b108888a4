"""One control tick in one compiled call, and its report."""

from time import perf_counter

import numpy as np

from remosplat_drake.base.packed import Packed
from remosplat_drake.controller.compiled_program import named_binding
from remosplat_drake.controller.decision import (
    NOT_FEASIBLE,
    TOO_SUDDEN,
    yielding_reason,
)
from remosplat_drake.controller.kernels.decide import NOT_DECIDED
from remosplat_drake.controller.kernels.settle import (
    Settled,
    settle_tick,
    verify_tick,
)
from remosplat_drake.controller.program_data import names_of, row_name
from remosplat_drake.controller.reactive_law import ReactiveLaw
from remosplat_drake.controller.tick_inputs import TickInputs
from remosplat_drake.controller.verification.kernels.verified import OBJECTIONS
from remosplat_drake.controller.verification.verify import Verdict
from remosplat_drake.scene.mover import Movers
from remosplat_drake.signals import tick_report
from remosplat_drake.signals.binding import COLLISION, Binding
from remosplat_drake.signals.compiled_map import Misplacement
from remosplat_drake.signals.tick_report import STATUSES, TickReport


def settled_tick(law: ReactiveLaw, given: TickInputs) -> TickReport | None:
    """Runs a tick as `run_tick` does, in one compiled call.

    Args:
        law: The control law.
        given: What the tick is given.

    Returns:
        The report, without the separation from what moves; None where kernels
        cannot run the tick: with another solver, ingredients from outside, a
        map that only Python can ask, a robot that obeys late, or an aim that is
        not known.
    """
    start = perf_counter()
    found = _settled(law, given)
    if found is None:
        return None
    parts, clearances = law.compiled.ingredients, given.clearances
    binding = named_binding(parts, law.robot, given.movers, *found.binding)
    end = perf_counter()
    return TickReport(
        time=given.time,
        q=np.array(given.q, float),
        command=found.command,
        status=STATUSES[found.status],
        reason=_reason(found, law, given.movers),
        scale=found.scale,
        clearances=clearances,
        kept=found.kept,
        tight=tight_clearances(binding, len(clearances)),
        aim=given.aim,
        binding=binding,
        line_deviation=_line_deviation(law, given),
        objection=OBJECTIONS[found.objection],
        timings={"one_call": end - start},
    )


def _settled(law: ReactiveLaw, given: TickInputs) -> Settled | None:
    loop, field, clearances = law.loop, given.field, given.clearances
    placed = field.placed if field.is_lipschitz else None
    if loop is None or placed is None:
        return None
    if given.motion is not None or not given.aim.is_known:
        return None
    rows = clearances.sphere, clearances.distance, clearances.direction_W
    found = Settled(
        *settle_tick(
            loop,
            law.robot.arrays,
            *placed,
            given.moving.arrays,
            given.moving.age(given.time),
            given.aim.arrays,
            # Copies, since numba compiles for arrays that may be written.
            tuple(np.array(values) for values in rows),
            np.array(given.q, float),
            np.array(given.u_previous, float),
            given.guidance.arrays,
        )
    )
    return None if found.status == NOT_DECIDED else found


def compiled_verdict(
    law: ReactiveLaw,
    given: TickInputs,
    placed: tuple[Packed, Misplacement],
    u: np.ndarray,
) -> Verdict:
    """Verifies a command as `verified_command` does, in one compiled call.

    Args:
        law: The control law.
        given: What the tick is given.
        placed: The map, as `DistanceField.placed`; it is 1-Lipschitz.
        u: The wanted command, shape (n_u,).
    """
    compiled, off = placed
    command, scale, objection = verify_tick(
        law.arrays,
        law.robot.arrays,
        compiled,
        off,
        given.moving.arrays,
        given.moving.age(given.time),
        # Copies, since numba compiles for arrays that may be written.
        np.array(given.q, float),
        np.array(given.clearances.sphere),
        np.array(given.clearances.distance),
        float(law.collision.stopping_for(given.guidance)),
        np.array(u, float),
        np.array(given.u_previous, float),
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


def _reason(found: Settled, law: ReactiveLaw, movers: Movers | None) -> str:
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
        part = law.compiled.ingredients[number]
        said = names_of(part.about(law.robot, movers, about))
        names.append(row_name(part.term, said))
    return yielding_reason(names)


def _line_deviation(law: ReactiveLaw, given: TickInputs) -> float:
    if not given.aim.has_line:
        return float("nan")
    return given.aim.line_deviation(law.robot.end_effector_poses(given.q))
