"""Builds the quadratic program of a tick for inspection."""

import numpy as np

from remosplat_drake.controller.ingredients.kernels.assemble import (
    assemble_tick,
)
from remosplat_drake.controller.program.ingredient import added
from remosplat_drake.controller.program.kernels.outside import joined
from remosplat_drake.controller.program.tick import Tick
from remosplat_drake.controller.tick.compiled_law import CompiledLaw
from remosplat_drake.controller.tick.tick_program import RowNames, TickProgram
from remosplat_drake.scene.mover import STILL


def program_of(compiled: CompiledLaw, tick: Tick) -> TickProgram:
    """Builds the quadratic program of a tick, before any fallback.

    Args:
        compiled: The ingredients.
        tick: The state of the tick.

    Raises:
        TermError: A term is invalid. The error names the term and its
            ingredient.
        NameTakenError: Two terms of one kind have the same name.
        IngredientError: An ingredient raises an exception.
    """
    # The arrays are copied, since kernels are compiled for writable arrays.
    clearances = tick.clearances
    rows = (
        clearances.sphere.copy(),
        clearances.distance.copy(),
        clearances.direction_W.copy(),
    )
    tube = tick.sphere_tube
    if tube is None:
        tube = np.zeros(len(tick.robot.spheres))
    movers = STILL if tick.movers is None else tick.movers
    found = assemble_tick(
        compiled.parts,
        compiled.near,
        tick.robot.arrays,
        movers.arrays,
        movers.age(tick.time),
        tick.aim.arrays,
        rows,
        np.array(tick.state.q, float),
        np.array(tick.u_previous, float),
        float(tick.dt),
        tube,
        tick.guidance.arrays,
    )
    compiled.check(found)
    arrays, outside = found.program, None
    if compiled.outside:
        bounds = np.array(
            [arrays.lower, arrays.upper, arrays.free_lower, arrays.free_upper]
        )
        outside = added(compiled.outside, bounds, compiled.names, tick)
        arrays = joined(arrays, outside.arrays)
    names = RowNames(compiled.ingredients, tick.robot, tick.movers, outside)
    return TickProgram(arrays, names)
