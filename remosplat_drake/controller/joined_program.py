"""`JoinedProgram`: a program to which ingredients from outside have added."""

from collections.abc import Container, Sequence

from remosplat_drake.controller.compiled_program import CompiledProgram
from remosplat_drake.controller.ingredient import Ingredient, complete
from remosplat_drake.controller.law_program import LawProgram
from remosplat_drake.controller.tick import Tick


class JoinedProgram(LawProgram):
    """The finished program of kernels' terms and of those from outside."""

    def __init__(
        self,
        compiled: CompiledProgram,
        outside: Sequence[Ingredient],
        tick: Tick,
    ):
        """Takes the kernels' terms, and lets the ingredients add theirs.

        Args:
            compiled: The kernels' terms; what is left out there, the
                ingredients leave out, too.
            outside: The ingredients from outside.
            tick: What is known at the tick.

        Raises:
            TermError: A term cannot be used; the text names it and its
                ingredient.
            NameTakenError: Two terms of a kind have one name.
            IngredientError: An ingredient raises.
        """
        super().__init__(
            tick.robot.velocity_limit,
            use_acceleration=compiled.use_acceleration,
            relax=compiled.relax,
        )
        self._compiled, self._outside, self._tick = compiled, outside, tick
        self.lower, self.upper = compiled.lower, compiled.upper
        self.terms = compiled.terms.copy()
        self.has_acceleration_bounds = compiled.has_acceleration_bounds
        self.yielded = list(compiled.yielded)
        complete(self, outside, tick)

    def weakened(
        self, *, use_acceleration: bool = True, relax: Container[str] = ()
    ) -> "JoinedProgram":
        """Returns the program with less demanded; see `LawProgram`."""
        less = self._compiled.weakened(
            use_acceleration=use_acceleration, relax=relax
        )
        return JoinedProgram(less, self._outside, self._tick)
