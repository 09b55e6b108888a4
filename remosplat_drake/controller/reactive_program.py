"""The quadratic program of one tick, built by its ingredients.

Decision variables are the command u and the slack delta of the end-effector
twist (paper section III-A); what is minimised and what must hold comes from
the ingredients, one small class each.
"""

import dataclasses as dc
from collections.abc import Container, Sequence
from functools import cached_property
from typing import Protocol

import numpy as np
from pydrake.solvers import MathematicalProgram

from remosplat_drake.base.errors import RemoSplatError
from remosplat_drake.controller.active_set import DenseProgram
from remosplat_drake.controller.drake_program import DrakeProgram, fill
from remosplat_drake.controller.guidance.guidance import DIRECT, Guidance
from remosplat_drake.controller.kernels.dense import (
    HOPELESS,
    dense,
    tight_rows,
)
from remosplat_drake.controller.kernels.tick_arrays import ProgramArrays
from remosplat_drake.controller.program_data import (
    Label,
    ProgramData,
    Rows,
    Tracking,
    tracking_name,
)
from remosplat_drake.controller.servo import error_scale
from remosplat_drake.robot.pose_error import PoseError
from remosplat_drake.robot.robot_model import RobotModel, RobotState
from remosplat_drake.scene.mover import Movers
from remosplat_drake.signals.aim import Aim
from remosplat_drake.signals.distance_field import Clearances
from remosplat_drake.signals.near_movers import NearMovers
from remosplat_drake.signals.target import Target


@dc.dataclass(frozen=True, eq=False)
class Tick:
    """All that one tick knows.

    Attributes:
        robot: The robot, with its limits and kinematics.
        state: Kinematics at the measured configuration q.
        aim: What the end effectors shall reach.
        clearances: The distances of the robot's spheres to the map that lie
            within the influence distance.
        u_previous: The command that is being executed, shape (n_u,).
        dt: Control period [s].
        guidance: How the tick is bent, as `GuidanceSelector` has chosen.
        sphere_tube: By how much each sphere may be off its predicted path, at
            the speeds of the command that is being executed, shape (n,) [m];
            None where the robot obeys at once.
        movers: What moves; None if nothing is known to.
        time: The time of the tick [s].

    Example:
        >>> import remosplat_drake as rs
        >>> class FaceTarget:
        ...     def AddToProgram(self, program, tick):
        ...         if tick.error.distance < 0.1:
        ...             program.add_linear_cost("wait", program.upper * 0)
    """

    robot: RobotModel
    state: RobotState
    aim: Aim
    clearances: Clearances
    u_previous: np.ndarray
    dt: float
    guidance: Guidance = DIRECT
    sphere_tube: np.ndarray | None = None
    movers: Movers | None = None
    time: float = 0.0

    def near_movers(self, within: float, ahead: float = 0.0) -> NearMovers:
        """Finds what moves near the robot as it stands.

        Args:
            within: Pairs of a sphere and a mover at or beyond this distance
                are left out [m].
            ahead: How far ahead movers are looked at [s]: then they are where
                their twists lead them.
        """
        if self.movers is None:
            return NearMovers.none()
        movers = self.movers.moved_on(ahead, ahead) if ahead else self.movers
        return NearMovers.find(movers, self.time, self.state.spheres, within)

    @property
    def target(self) -> Target:
        """The target, the first of several."""
        return self.aim.first

    @property
    def X_WT(self) -> np.ndarray:
        """Pose of the target T in the world W, shape (4, 4)."""
        return self.target.X_WT

    @cached_property
    def errors(self) -> tuple[PoseError, ...]:
        """The pose error to each of the aim's targets, in what that asks."""
        return self.aim.errors(self.state.X_WEs)

    @property
    def error(self) -> PoseError:
        """The pose error to the target, the first of several."""
        return self.errors[0]

    @property
    def error_scales(self) -> list[float]:
        """The paper's error e of each target [m]; see `servo.error_scale`."""
        items = zip(self.errors, self.aim.items, strict=True)
        return [error_scale(e.p_ET_E, t.arrays) for e, (_, t) in items]

    @property
    def error_scale(self) -> float:
        """The paper's error e: L1 distance to the target, at least 1e-3 [m].

        Of several targets, the largest. Costs divide by it; the bound keeps
        them finite at the target.
        """
        return max(self.error_scales)

    @cached_property
    def approach_rates(self) -> np.ndarray:
        """The rows J_d = n' Jv_WS of all m clearances, shape (m, n_u).

        J_d u is the rate at which a clearance shrinks [m/s] (paper eq. 16).
        """
        clearances = self.clearances
        return np.einsum(
            "mi,mij->mj",
            clearances.direction_W,
            self.state.Jv_WS[clearances.sphere],
        )


class Ingredient(Protocol):
    """A cost or constraint of the program.

    Any object with this method is one. The controller and its rollouts share
    it, so `AddToProgram` must depend on its arguments alone; and it must be
    possible to pickle it if rollouts run in a process of their own.

    Example:
        >>> import remosplat_drake as rs
        >>> class PreferStill:
        ...     def AddToProgram(self, program, tick):
        ...         program.add_quadratic_cost("still", program.upper * 0 + 0.1)
        >>> robot = rs.load_robot("frankie")
        >>> parts = [*rs.default_ingredients(robot), PreferStill()]
        >>> law = rs.ReactiveLaw(robot, parts)
    """

    def AddToProgram(self, program: "ReactiveProgram", tick: Tick) -> None:
        """Adds what the ingredient stands for to the program of one tick.

        Args:
            program: Takes costs, rows and bounds, each by a name of its own.
            tick: What is known at the tick: the robot's state, the target,
                the clearances and the command being executed.
        """
        ...


class IngredientMaker(Protocol):
    """The settings of an ingredient that needs to know the robot.

    Any `Config` with this method is one, and a scenario may name it in
    `controller.extra`.
    """

    def make(self, robot: RobotModel) -> Ingredient:
        """Makes the ingredient.

        Args:
            robot: The robot that the controller drives.
        """
        ...


class Named(Protocol):
    """What `CompiledIngredient` says of its terms, for people."""

    term: str

    def about(self, tick: Tick, number: int) -> str | tuple[str, ...]:
        """Says what a row is about; see `CompiledIngredient`."""
        ...


@dc.dataclass(frozen=True, eq=False)
class Labels:
    """Says what rows that a kernel has added are about.

    Attributes:
        part: The ingredient that they are of.
        tick: What is known at the tick.
        number: What the kernel has noted of each row, shape (m,).
    """

    part: Named
    tick: Tick
    number: np.ndarray

    def __call__(self, i: int) -> str | tuple[str, ...]:
        """Says what row i is about."""
        return self.part.about(self.tick, int(self.number[i]))


class TermError(RemoSplatError, ValueError):
    """A term of the program has a name that is taken, or the wrong shape."""


class ReactiveProgram(ProgramData):
    """What the ingredients of one tick add to.

    The program minimises the sum of all costs over the command u, shape
    (n_u,), within the bounds and subject to all rows. A term's name may be
    used once for each kind of term.

    `prog` is the same program as Drake's `MathematicalProgram`, `dense` as
    matrices in u alone. An ingredient may add to `prog` itself what the
    methods here do not express; `dense` then leaves that out.

    Args:
        velocity_limit: Bounds on |u| to begin with, shape (n_u,) [rad/s, m/s].
        use_acceleration: Whether ingredients may add acceleration bounds.
        relax: Names of the sets of rows whose negative right-hand sides are
            raised to zero. Where these are all, u = 0 is feasible.

    Attributes:
        use_acceleration: Whether ingredients may add acceleration bounds.
        has_acceleration_bounds: Whether an ingredient has added acceleration
            bounds.
        relax: Names of the sets of rows whose negative right-hand sides are
            raised to zero.
        yielded: Names of the rows whose right-hand sides were raised.
        arrays: All terms as kernels have added them; None where ingredients
            have added them one by one.

    Example:
        >>> import remosplat_drake as rs
        >>> import numpy as np
        >>> program = rs.ReactiveProgram(np.ones(9))
        >>> program.add_quadratic_cost("stand still", np.ones(9))
        >>> program.add_linear_cost("turn left", -np.eye(9)[1])
    """

    def __init__(
        self,
        velocity_limit: np.ndarray,
        *,
        use_acceleration: bool = True,
        relax: Container[str] = (),
    ):
        super().__init__(velocity_limit)
        self.use_acceleration = use_acceleration
        self.has_acceleration_bounds = False
        self.relax = relax
        self.yielded: list[str] = []
        self.arrays: ProgramArrays | None = None
        self._source: tuple[Sequence[Named], Tick] | None = None
        self._drake: DrakeProgram | None = None
        self._is_finished = False

    @staticmethod
    def from_arrays(
        arrays: ProgramArrays,
        ingredients: Sequence[Named],
        tick: Tick,
    ) -> "ReactiveProgram":
        """Makes a finished program of the terms that kernels have added.

        Args:
            arrays: The terms.
            ingredients: The ingredients, in the kernels' order; their terms
                have different names.
            tick: What is known at the tick.
        """
        program = ReactiveProgram(tick.robot.velocity_limit)
        program.lower, program.upper = arrays.lower, arrays.upper
        has, spans = arrays.has.tolist(), arrays.rows.tolist()
        for k, part in enumerate(ingredients):
            is_linear, is_quadratic = has[k]
            if is_linear:
                program.add_linear_cost(part.term, arrays.linear[k])
            if is_quadratic:
                program.add_quadratic_cost(part.term, arrays.quadratic[k])
            first, last = spans[k]
            if first < last:
                span = slice(first, last)
                program.rows[part.term] = Rows(
                    arrays.A[span],
                    arrays.b[span],
                    arrays.kept[span],
                    Labels(part, tick, arrays.about[span]),
                )
        _, tracker, accelerates, _, _ = arrays.count.tolist()
        first = 0
        for effector, last in enumerate(arrays.tracked.tolist()):
            if not tracker or last == first:
                continue
            name = tracking_name(
                ingredients[tracker - 1].term, tick.robot.effectors[effector]
            )
            program.trackings[name] = Tracking(
                name,
                arrays.J[first:last],
                arrays.V[first:last],
                float(arrays.price[first]),
                arrays.limit[first:last],
            )
            first = last
        program.has_acceleration_bounds = bool(accelerates)
        program.arrays, program._source = arrays, (ingredients, tick)
        program._is_finished = True
        return program

    def weakened(
        self, *, use_acceleration: bool = True, relax: Container[str] = ()
    ) -> "ReactiveProgram | None":
        """Returns the program with less demanded, as `build_program` builds it.

        None where it is not what kernels have added alone: then it must be
        built anew.

        Args:
            use_acceleration: Whether acceleration bounds stay.
            relax: Names of the sets of rows whose negative right-hand sides
                are raised to zero.
        """
        if self.arrays is None or self._source is None:
            return None
        (parts, tick), arrays = self._source, self.arrays
        b, count = arrays.b.copy(), arrays.count.copy()
        if not use_acceleration:
            count[2] = 0
            free = {"lower": arrays.free_lower, "upper": arrays.free_upper}
            arrays = arrays._replace(**free)
        yielded = []
        for name, rows in self.rows.items():
            if name in relax:
                yielded += rows.yielding(name)
        for part, (first, last) in zip(
            parts, arrays.rows.tolist(), strict=True
        ):
            if part.term in relax:
                b[first:last] = np.maximum(b[first:last], 0.0)
        arrays = arrays._replace(b=b, count=count, kept=arrays.kept.copy())
        program = ReactiveProgram.from_arrays(arrays, parts, tick)
        program.use_acceleration, program.relax = use_acceleration, relax
        program.yielded = yielded
        A, b = arrays.A[: count[0]], b[: count[0]]
        arrays.kept[: count[0]] = program.can_bind(A, b)
        arrays.count[4] = program.excess(A, b) > HOPELESS
        return program

    @property
    def is_hopeless(self) -> bool:
        """Whether a row cannot hold within the bounds, as kernels have seen.

        Then no solver need be asked.
        """
        return self.arrays is not None and bool(self.arrays.count[4])

    def add_linear_cost(self, name: str, c: np.ndarray) -> None:
        """Adds the cost c'u.

        Args:
            name: Name of the cost, unique among the linear costs.
            c: Vector of the cost, shape (n_u,).

        Raises:
            TermError: There is a linear cost of that name already, or c has
                another shape.
        """
        self._check("a linear cost", name, name in self.linear, c, (self.n_u,))
        self.linear[name] = c

    def add_quadratic_cost(self, name: str, weights: np.ndarray) -> None:
        """Adds the cost u' diag(weights) u / 2.

        Args:
            name: Name of the cost, unique among the quadratic costs.
            weights: Weights of the squared entries of u, shape (n_u,); none
                may be negative.

        Raises:
            TermError: There is a quadratic cost of that name already, or the
                weights have another shape.
        """
        taken = name in self.quadratic
        self._check("a quadratic cost", name, taken, weights, (self.n_u,))
        self.quadratic[name] = weights

    def add_rows(
        self,
        name: str,
        A: np.ndarray,
        b: np.ndarray,
        label: Label = "row {}".format,
    ) -> None:
        """Adds the rows A u <= b.

        Args:
            name: Name of the set of rows, unique among these.
            A: Coefficients of the rows, shape (m, n_u).
            b: Right-hand sides of the rows, shape (m,).
            label: Says what row i is about, for people: names of links or
                joints, or a text. It is asked only where the row must yield
                or holds the command back.

        Raises:
            TermError: There are rows of that name already, or A has another
                shape.
        """
        self._check(
            "a set of rows", name, name in self.rows, A, (len(b), self.n_u)
        )
        rows = Rows(A, b, np.ones(len(b), bool), label)
        if name in self.relax:
            self.yielded += rows.yielding(name)
            rows = dc.replace(rows, b=np.maximum(b, 0.0))
        self.rows[name] = rows

    def track(
        self,
        name: str,
        J: np.ndarray,
        V: np.ndarray,
        *,
        price: float,
        limit: np.ndarray,
    ) -> None:
        """Tracks the end effector's twist: J u + delta = V with a slack delta.

        The slack costs price |delta|^2 / 2. A twist is tracked in as many
        directions as there are rows: all six, or fewer.

        Args:
            name: Name of this tracking, unique among the trackings.
            J: Jacobian of the end effector in W, angular above
                translational, shape (6, n_u); or r directions of it.
            V: The wanted twist V_WE, angular above translational, shape (6,)
                [rad/s, m/s]; or the same directions of it, shape (r,).
            price: Weight of the squared slack in the cost.
            limit: Bounds on |delta|, shape (r,) [rad/s, m/s].

        Raises:
            TermError: There is a tracking of that name already, or J has
                another shape.
        """
        taken = name in self.trackings
        self._check("tracking", name, taken, J, (len(V), self.n_u))
        self.trackings[name] = Tracking(name, J, V, price, limit)

    def _check(
        self,
        kind: str,
        name: str,
        taken: bool,
        array: np.ndarray,
        shape: tuple[int, ...],
    ) -> None:
        if taken:
            raise TermError(f"there is {kind} {name!r} already")
        if np.shape(array) != shape:
            raise TermError(
                f"{name!r}: expected the shape {shape}, got {np.shape(array)}"
            )

    def extend(self, ingredients: Sequence[Ingredient], tick: Tick) -> None:
        """Adds further ingredients to a finished program, and finishes it.

        Args:
            ingredients: The ingredients.
            tick: What is known at the tick.

        Raises:
            TermError: A term's name is taken, or it has the wrong shape.
        """
        self.arrays, self._is_finished = None, False
        for ingredient in ingredients:
            ingredient.AddToProgram(self, tick)
        self.finish()

    def dense(self) -> DenseProgram:
        """Returns the program in u alone, its slack replaced by V - J u."""
        if self.arrays is None:
            return super().dense()
        return DenseProgram(*dense(self.arrays))

    def tight_rows(
        self, u: np.ndarray, tolerance: float
    ) -> list[tuple[str, int]]:
        """Finds the rows that are kept and hold with equality.

        Args:
            u: A command, shape (n_u,).
            tolerance: By how much less than b a row may be [m/s, rad/s].

        Returns:
            The name of each one's set, and its number in that.
        """
        if self.arrays is None or self._source is None:
            return super().tight_rows(u, tolerance)
        numbers = tight_rows(self.arrays, u, tolerance).tolist()
        if not numbers:
            return []
        spans = zip(self._source[0], self.arrays.rows.tolist(), strict=True)
        return [
            (part.term, i - first)
            for part, (first, last) in spans
            for i in numbers
            if first <= i < last
        ]

    def finish(self):
        """Marks the rows that cannot bind, once all terms have been added.

        A row whose largest value within the bounds of u does not exceed b_i
        is redundant: leaving it out changes nothing but the solver's time.
        """
        for name, rows in self.rows.items():
            kept = self.can_bind(rows.A, rows.b)
            self.rows[name] = dc.replace(rows, kept=kept)
        self._is_finished = True
        if self._drake is not None:
            fill(self._drake, self)

    @property
    def prog(self) -> MathematicalProgram:
        """The program as Drake's `MathematicalProgram`."""
        return self.drake.prog

    @property
    def drake(self) -> "DrakeProgram":
        """Drake's program and its variables, made when first asked for."""
        if self._drake is None:
            self._drake = DrakeProgram(self.n_u, extended=not self._is_finished)
            if self._is_finished:
                fill(self._drake, self)
        return self._drake

    @property
    def u(self) -> np.ndarray:
        """Drake's decision variables of the command, shape (n_u,)."""
        return self.drake.u

    @property
    def is_extended(self) -> bool:
        """Whether an ingredient has asked for `prog` and may have used it.

        What it has added, only Drake's program knows; `dense` does not.
        """
        return self._drake is not None and self._drake.extended


def build_program(
    tick: Tick,
    ingredients: Sequence[Ingredient],
    *,
    use_acceleration: bool = True,
    relax: Container[str] = (),
) -> ReactiveProgram:
    """Builds the program of one tick afresh.

    Args:
        tick: What is known at the tick: the robot's state, the target, the
            clearances and the command being executed.
        ingredients: Costs and constraints, in any order.
        use_acceleration: Whether ingredients may add acceleration bounds.
        relax: Names of the sets of rows whose negative right-hand sides are
            raised to zero.

    Returns:
        The finished program.

    Raises:
        TermError: Two terms of a kind share a name, or one has the wrong
            shape.
    """
    program = ReactiveProgram(
        tick.robot.velocity_limit,
        use_acceleration=use_acceleration,
        relax=relax,
    )
    for ingredient in ingredients:
        ingredient.AddToProgram(program, tick)
    program.finish()
    return program
