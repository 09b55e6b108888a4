"""`ReactiveLaw`: the control law, which consists of ingredients."""

import copy
from collections.abc import Iterable, Sequence
from functools import lru_cache
from typing import Any, Protocol, TypeVar

import numpy as np

from remosplat_drake.base.errors import FieldError
from remosplat_drake.base.kernels.packed import Packed
from remosplat_drake.controller.ingredients import (
    CollisionDamper,
    CollisionDamperConfig,
    MoverDamper,
    MoverDamperConfig,
    SelfCollisionDamper,
    SelfCollisionDamperConfig,
    VelocityLimits,
)
from remosplat_drake.controller.program.ingredient import (
    AnyIngredient,
    Ingredient,
)
from remosplat_drake.controller.program.reactive_program import ReactiveProgram
from remosplat_drake.controller.program.solvers import (
    ActiveSetSolver,
    Solver,
    make_solver,
)
from remosplat_drake.controller.program.tick import Tick
from remosplat_drake.controller.tick.compiled_law import CompiledLaw
from remosplat_drake.controller.tick.kernels.settle import LawArrays
from remosplat_drake.controller.tick.program_of import program_of
from remosplat_drake.controller.tick.tick_program import TickProgram
from remosplat_drake.controller.verification.kernels.verified import KeptArrays
from remosplat_drake.controller.verification.self_sweep import SelfClearance
from remosplat_drake.robot.braking import spare_time
from remosplat_drake.robot.payload import Payload
from remosplat_drake.robot.robot_model import RobotModel

T = TypeVar("T")


LONGEST_VERIFIED = 0.1
"""With verification, the control period is at most this time [s], since the
robot is not supervised between two ticks."""


class LawConfig(Protocol):
    """Protocol of a law's settings, such as `ReactiveControllerConfig`."""

    solver: str
    verify: bool

    def ingredients_of(self, robot: RobotModel) -> list[AnyIngredient]:
        """Makes the ingredients.

        Args:
            robot: The robot to drive.
        """
        ...


class ReactiveLaw:
    """The control law: its costs, constraints, distances and solver.

    A law has a list of ingredients, which are the costs and constraints of a
    quadratic program, and the solver of this program. Its distances are those
    of the `CollisionDamper` and the `SelfCollisionDamper` among the
    ingredients.

        law = ReactiveLaw(robot, [*default_ingredients(robot), MyCost()])

    To get the same law with another period, for example for rollouts, call
    `with_step`, which keeps all ingredients.

    Attributes:
        robot: The robot.
        ingredients: Costs and constraints of the program.
        compiled: The ingredients, packed for kernels.
        dt: Control period [s].
        solver: The convex solver of the program.
        verify: Whether each command is checked against the map before it is
            applied.
        strict: Whether acceleration bounds hold even in an infeasible program.
        collision: The influence distance d_i, beyond which the scene is
            ignored, and the stopping distance d_s, which verification keeps.
        self_clearance: The distances that verification keeps between the
            robot's own parts; None if it checks none.
        movers: Influence distance of movers, and the distance from them that
            verification keeps.

    Example:
        >>> import remosplat_drake as rs
        >>> robot = rs.load_robot("frankie")
        >>> law = rs.ReactiveLaw(robot, rs.default_ingredients(robot), dt=0.01)
        >>> law.with_step(0.1).ingredients is law.ingredients
        True
    """

    def __init__(
        self,
        robot: RobotModel,
        ingredients: Iterable[AnyIngredient],
        dt: float = 0.01,
        *,
        solver: str | Solver = "clarabel",
        verify: bool = True,
        collision: CollisionDamperConfig | None = None,
        self_collision: SelfCollisionDamperConfig | None = None,
    ):
        """Makes a law from ingredients.

        Args:
            robot: The robot to drive.
            ingredients: Costs and constraints, in any order.
            dt: Control period [s].
            solver: The name of a convex solver, one of `solvers.SOLVERS`, or a
                `Solver`.
            verify: Whether each command is checked against the map before it
                is applied.
            collision: Distances from the scene if the ingredients contain no
                `CollisionDamper`; None for its default values.
            self_collision: Self-collision distances if the ingredients contain
                no `SelfCollisionDamper`; None for its default values.

        Raises:
            FieldError: `dt` or the solver is invalid, or both an argument and
                an ingredient contain the same distances.
            NameTakenError: Two ingredients are of the same class of the
                library, or the name of a user's compiled ingredient is not
                unique.
            RemoSplatError: A compiled ingredient cannot be compiled.
        """
        _check_step(dt, verify)
        self.robot = robot
        self.ingredients: Sequence[AnyIngredient] = tuple(ingredients)
        self.compiled = CompiledLaw(robot, self.ingredients)
        self.dt = dt
        # This is the period of the station, even if a rollout takes longer
        # steps.
        self._spare = spare_time(dt)
        self.solver = _solver(solver)
        self.verify = verify
        self.strict = any(
            part.config.strict and part.config.acceleration
            for part in self.ingredients
            if isinstance(part, VelocityLimits)
        )
        self.collision = (
            self._distances(CollisionDamper, "collision", collision)
            or CollisionDamperConfig()
        )
        kept = (
            self._distances(
                SelfCollisionDamper, "self_collision", self_collision
            )
            or SelfCollisionDamperConfig()
        )
        self.movers = (
            self._distances(MoverDamper, "movers", None) or MoverDamperConfig()
        )
        own = SelfClearance.make(robot, kept.stopping)
        self.self_clearance = own if verify and kept.enabled else None
        self._own = own
        self._arrays: Packed[LawArrays] | None = None

    @staticmethod
    def make(
        config: LawConfig,
        robot: RobotModel,
        dt: float,
        ingredients: Iterable[Ingredient] = (),
    ) -> "ReactiveLaw":
        """Makes a law from the controller's settings.

        Args:
            config: Settings of the controller and its ingredients.
            robot: The robot to drive.
            dt: Control period [s].
            ingredients: Further ingredients, in addition to those of the
                settings.

        Raises:
            FieldError: A value of the settings or `dt` is invalid.
            NameTakenError: A further ingredient is of a class of the library.
        """
        return ReactiveLaw(
            robot,
            [*config.ingredients_of(robot), *ingredients],
            dt,
            solver=make_solver(config.solver, "scenario"),
            verify=config.verify,
        )

    def __getstate__(self) -> dict[str, Any]:
        # Addresses are removed, since they are invalid in another process.
        return {**vars(self), "_arrays": None}

    def program(self, tick: Tick) -> TickProgram:
        """Builds the program of a tick, before fallbacks, for inspection.

        Args:
            tick: The state of the tick.

        Raises:
            TermError: A term is invalid. The error names the term and its
                ingredient.
            NameTakenError: Two terms of one kind have the same name.
            IngredientError: An ingredient raises an exception.
        """
        return program_of(self.compiled, tick)

    @property
    def arrays(self) -> Packed[LawArrays]:
        """The law packed for kernels."""
        if self._arrays is None:
            compiled, n_u = self.compiled, self.robot.n_u
            own = self._own
            kept = KeptArrays(
                float(self.dt),
                self._spare,
                self.self_clearance is not None,
                own.arrays.values,
                float(own.stopping),
                float(self.movers.separation),
            )
            law = LawArrays(
                compiled.parts.values,
                bool(compiled.outside),
                ReactiveProgram(np.zeros(n_u)).more.values,
                isinstance(self.solver, ActiveSetSolver),
                float(self.dt),
                self.strict,
                float(self.collision.influence),
                float(self.collision.stopping),
                self.verify,
                compiled.near.values,
                kept,
            )
            self._arrays = Packed(law)
        return self._arrays

    def with_step(
        self, dt: float, *, solver: str | Solver | None = None
    ) -> "ReactiveLaw":
        """Returns the law with another period and the same ingredients.

        Args:
            dt: The other control period [s].
            solver: Another solver; None keeps the present one.

        Raises:
            FieldError: `dt` or the solver is invalid.
        """
        _check_step(dt, self.verify)
        law = copy.copy(self)
        law.dt, law._arrays = dt, None
        if solver is not None:
            law.solver = _solver(solver)
        return law

    def holding(self, payload: Payload | None) -> "ReactiveLaw":
        """Returns the law for the robot with another payload.

        Equal calls of this method return the same object.

        Args:
            payload: The payload; None if the robot carries nothing.
        """
        robot = self.robot.holding(payload)
        if robot is self.robot:
            return self
        return _for_robot(self, robot)

    def _for(self, robot: RobotModel) -> "ReactiveLaw":
        law = copy.copy(self)
        law.robot, law._arrays = robot, None
        law.ingredients = tuple(
            SelfCollisionDamper(part.config, robot)
            if isinstance(part, SelfCollisionDamper)
            else part
            for part in self.ingredients
        )
        law.compiled = CompiledLaw(robot, law.ingredients)
        law._own = SelfClearance.make(robot, self._own.stopping)
        if self.self_clearance is not None:
            law.self_clearance = law._own
        return law

    def _distances(self, kind: type, name: str, given: T | None) -> T | None:
        """Returns the settings of a kind's damper; `given` if it has none."""
        dampers: list[Any] = [
            i for i in self.ingredients if isinstance(i, kind)
        ]
        if dampers and given is not None:
            problem = (
                f"the ingredient {kind.__name__} has these settings already;"
                " omit the argument"
            )
            raise FieldError("ReactiveLaw", name, problem)
        return dampers[0].config if dampers else given


@lru_cache(maxsize=16)
def _for_robot(law: ReactiveLaw, robot: RobotModel) -> ReactiveLaw:
    return law._for(robot)


def _check_step(dt: float, verify: bool) -> None:
    longest = LONGEST_VERIFIED if verify else float("inf")
    if not 0 < dt <= longest:
        valid = f"lie in (0, {longest}] with `verify`" if verify else "exceed 0"
        raise FieldError("ReactiveLaw", "dt", f"must {valid}, got {dt}")


def _solver(solver: str | Solver) -> Solver:
    if isinstance(solver, str):
        return make_solver(solver, "ReactiveLaw")
    return solver
