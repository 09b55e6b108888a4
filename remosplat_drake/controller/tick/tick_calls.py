"""Handles calls from kernels to Python during a tick."""

from time import perf_counter

from remosplat_drake.base.python_calls import Arguments
from remosplat_drake.controller.ingredients.kernels.assemble import Assembled
from remosplat_drake.controller.program.active_set import INFEASIBLE, OPTIMAL
from remosplat_drake.controller.program.ingredient import added
from remosplat_drake.controller.program.kernels.tick_arrays import ProgramArrays
from remosplat_drake.controller.program.quadratic_program import (
    QuadraticProgram,
)
from remosplat_drake.controller.program.reactive_program import ReactiveProgram
from remosplat_drake.controller.program.slack_form import SlackForm
from remosplat_drake.controller.program.solvers import (
    ActiveSetSolver,
    DrakeSolver,
)
from remosplat_drake.controller.program.term import TermError
from remosplat_drake.controller.tick.reactive_law import ReactiveLaw
from remosplat_drake.controller.tick.tick_inputs import TickInputs
from remosplat_drake.controller.verification.map_calls import (
    MapCalls,
    is_pythons,
)
from remosplat_drake.robot.robot_arrays import StateArrays
from remosplat_drake.signals.distance_field import Clearances, DistanceField


def asks_python(law: ReactiveLaw, field: DistanceField) -> bool:
    """Returns whether ticks call Python functions; such ticks need one thread.

    They do if the map, an ingredient or the solver is not compiled.

    Args:
        law: The control law.
        field: The map.
    """
    is_known = isinstance(law.solver, ActiveSetSolver | DrakeSolver)
    return is_pythons(field) or bool(law.compiled.outside) or not is_known


class TickCalls(MapCalls):
    """Python functions that kernels call in a tick, or in steps of a rollout.

    Attributes:
        outside: The latest terms of ingredients in Python; None if there are
            none.
        solving: Wall-clock time that Drake's solvers took [s].
        unusable: Description of an invalid term, because of which the robot
            brakes; empty if all terms are valid.
    """

    def __init__(self, law: ReactiveLaw, given: TickInputs):
        """Prepares the functions.

        Args:
            law: The control law, for its solver and its ingredients.
            given: The inputs of the tick, or of the first tick of the rollout.
        """
        super().__init__(law.robot, given.field)
        self._law, self._given = law, given
        self.outside: ReactiveProgram | None = None
        self.solving = 0.0
        self.unusable = ""

    def _answers(self) -> tuple:
        return *super()._answers(), self._add, self._solve, self._refuse

    def _check(self) -> None:
        if isinstance(self._calls.error, TermError):
            self.unusable = str(self._calls.error)
        else:
            super()._check()

    def _add(self, arguments: Arguments) -> int:
        """Calls the ingredients in Python; see `add_outside`."""
        law, compiled = self._law, self._law.compiled
        bounds, costs, flags = (arguments[i] for i in range(3))
        # The arrays are copied, since a kernel's memory is freed when the
        # kernel returns.
        n = len(StateArrays._fields)
        told = [arguments[i].copy() for i in range(3, n + 8)]
        state, (u_previous, *rows) = StateArrays(*told[:n]), told[n:]
        tick = self._given.tick(
            law, state, u_previous, Clearances(*rows), arguments[n + 8]
        )
        self.outside = added(
            compiled.outside, bounds.copy(), compiled.names, tick
        )
        self.outside.write(bounds, costs, flags)
        return self._calls.handed(self.outside.more)

    def _solve(self, arguments: Arguments) -> int:
        """Solves a program that kernels cannot solve; see `decide`."""
        start = perf_counter()
        u, *form = (arguments[i] for i in range(11))
        extension = None if self.outside is None else self.outside.extension
        program = QuadraticProgram(SlackForm(*form), extension)
        optimum = self._law.solver.solve(program)
        if optimum is not None:
            u[:] = optimum
        self.solving += perf_counter() - start
        return INFEASIBLE if optimum is None else OPTIMAL

    def _refuse(self, arguments: Arguments) -> int:
        """Describes an invalid term of a compiled ingredient; see `settle`."""
        n = len(ProgramArrays._fields)
        program = ProgramArrays(*(arguments[i] for i in range(n)))
        found = Assembled(program, arguments[n], arguments[n + 1])
        self._law.compiled.check(found)
        return 0
