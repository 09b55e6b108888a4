"""Programs of ticks, built as a law builds them, and what ticks decide."""

from collections.abc import Sequence

from remosplat_drake.controller.program.ingredient import AnyIngredient
from remosplat_drake.controller.program.solvers import Solver
from remosplat_drake.controller.program.tick import Tick
from remosplat_drake.controller.tick.compiled_law import CompiledLaw
from remosplat_drake.controller.tick.program_of import (
    program_of as program_of_law,
)
from remosplat_drake.controller.tick.reactive_law import ReactiveLaw
from remosplat_drake.controller.tick.run_tick import run_tick
from remosplat_drake.controller.tick.tick_program import TickProgram
from remosplat_drake.oracle.signed_distance import SignedDistanceField
from remosplat_drake.scene.primitive_scene import PrimitiveScene
from remosplat_drake.signals.tick_report import TickReport


def program_of(tick: Tick, ingredients: Sequence[AnyIngredient]) -> TickProgram:
    """Builds the program of a tick as it stands."""
    return program_of_law(CompiledLaw(tick.robot, ingredients), tick)


def decided(
    tick: Tick, ingredients: Sequence[AnyIngredient], solver: str | Solver
) -> TickReport:
    """Runs a tick whose command nothing verifies."""
    law = ReactiveLaw(
        tick.robot, ingredients, tick.dt, solver=solver, verify=False
    )
    return run_tick(
        law,
        tick.time,
        tick.state.q,
        tick.aim,
        tick.clearances,
        SignedDistanceField(PrimitiveScene().with_floor()),
        tick.u_previous,
        tick.guidance,
        movers=tick.movers,
    )
