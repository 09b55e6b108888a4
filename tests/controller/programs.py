"""Programs of ticks, built as a law builds them."""

from collections.abc import Sequence

from remosplat_drake.controller.compiled_law import CompiledLaw
from remosplat_drake.controller.ingredient import AnyIngredient
from remosplat_drake.controller.law_program import LawProgram
from remosplat_drake.controller.tick import Tick


def program_of(tick: Tick, ingredients: Sequence[AnyIngredient]) -> LawProgram:
    """Builds the program of a tick as it stands."""
    return CompiledLaw(tick.robot, ingredients).program(tick)
