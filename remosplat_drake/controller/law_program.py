"""`LawProgram`: the program of a tick, which can demand less."""

from abc import ABC, abstractmethod
from collections.abc import Container

from remosplat_drake.controller.reactive_program import ReactiveProgram


class LawProgram(ReactiveProgram, ABC):
    """The finished program of a tick, as a law builds it."""

    @abstractmethod
    def weakened(
        self, *, use_acceleration: bool = True, relax: Container[str] = ()
    ) -> "LawProgram":
        """Returns the program with less demanded.

        Args:
            use_acceleration: Whether acceleration bounds stay.
            relax: Names of the sets of rows whose negative right-hand sides
                are raised to zero.

        Raises:
            TermError: An ingredient from outside adds what cannot be used; the
                text names both.
            NameTakenError: Two terms of a kind have one name.
            IngredientError: An ingredient from outside raises.
        """
