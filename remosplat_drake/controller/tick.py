"""One control tick as a pure function: state in, command and report out."""

import dataclasses as dc
from collections.abc import Sequence
from time import perf_counter

import numpy as np

from remosplat_drake.base.errors import FieldError
from remosplat_drake.base.ranges import check_ranges
from remosplat_drake.controller.controller_config import (
    LONGEST_VERIFIED,
    ReactiveControllerConfig,
    make_ingredients,
)
from remosplat_drake.controller.decision import Decision, Solver, brake, decide
from remosplat_drake.controller.guidance.guidance import DIRECT, Guidance
from remosplat_drake.controller.ingredients import collision_damper
from remosplat_drake.controller.reactive_program import (
    Ingredient,
    Tick,
    build_program,
)
from remosplat_drake.controller.solvers import make_solver
from remosplat_drake.controller.verification.self_sweep import SelfClearance
from remosplat_drake.controller.verification.verify import (
    Surroundings,
    verified_command,
)
from remosplat_drake.robot.pose_error import pose_error
from remosplat_drake.robot.robot_model import RobotModel, RobotState
from remosplat_drake.signals.distance_field import Clearances, DistanceField
from remosplat_drake.signals.tick_report import TickReport

_TIGHT = 1e-4
"""Rows this close to equality count as tight [m/s]."""


@dc.dataclass(frozen=True, eq=False)
class ReactiveLaw:
    """The control law: what stays the same from tick to tick.

    Attributes:
        robot: The robot it drives.
        config: Its parameters.
        dt: Control period [s].
        ingredients: Costs and constraints of the program.
        solver: The convex solver.
        self_clearance: What verification keeps the robot from itself; None:
            nothing.
    """

    robot: RobotModel
    config: ReactiveControllerConfig
    dt: float
    ingredients: Sequence[Ingredient]
    solver: Solver
    self_clearance: SelfClearance | None

    @staticmethod
    def make(
        config: ReactiveControllerConfig, robot: RobotModel, dt: float
    ) -> "ReactiveLaw":
        """The law that a configuration stands for.

        Raises:
            FieldError: A value of it is unusable, or `dt` is.
        """
        check_ranges(config)
        if config.verify and not 0 < dt <= LONGEST_VERIFIED:
            raise FieldError(
                "ReactiveLaw",
                "dt",
                f"must lie in (0, {LONGEST_VERIFIED}] with `verify`, got {dt}",
            )
        return ReactiveLaw(
            robot,
            config,
            dt,
            make_ingredients(config, robot),
            make_solver(config.solver, "scenario"),
            _self_clearance(config, robot),
        )


def _self_clearance(
    config: ReactiveControllerConfig, robot: RobotModel
) -> SelfClearance | None:
    if not (config.verify and config.self_collision.enabled):
        return None
    return SelfClearance.make(robot, config.self_collision.stopping)


def run_tick(
    law: ReactiveLaw,
    time: float,
    q: np.ndarray,
    X_WT: np.ndarray,
    clearances: Clearances,
    field: DistanceField,
    u_previous: np.ndarray,
    guidance: Guidance = DIRECT,
    state: RobotState | None = None,
) -> TickReport:
    """Runs one tick (paper eq. 1 to 4, then verify-then-scale).

    Args:
        law: The control law.
        time: Time of the tick [s].
        q: Measured configuration, shape (n_q,).
        X_WT: Target pose, shape (4, 4).
        clearances: The oracle's answer at q.
        field: The map, for verification.
        u_previous: The command being executed, shape (n_u,).
        guidance: How the tick is bent.
        state: Kinematics at q, if the caller has them already.
    """
    start = perf_counter()
    problem = _unknown_surroundings(q, clearances)
    if problem:
        return _blind_report(law, time, q, X_WT, u_previous, problem)
    clearances = clearances.within(law.config.collision.influence)
    state = state or law.robot.state(q)
    after_kinematics = perf_counter()
    if np.isfinite(X_WT).all():
        tick = Tick(
            law.robot,
            state,
            X_WT,
            pose_error(state.X_WE, X_WT),
            clearances,
            u_previous,
            law.dt,
            guidance,
        )
        program = build_program(tick, law.ingredients)
        after_build = perf_counter()
        decision = decide(tick, law.ingredients, law.solver, program)
    else:
        after_build = perf_counter()
        decision = brake(law.robot, u_previous, law.dt, "target is not finite")
    after_solve = perf_counter()
    command, scale = _verified(
        law, field, state, decision.u, u_previous, clearances, guidance
    )
    end = perf_counter()
    kept, tight = _row_flags(decision, len(clearances))
    return TickReport(
        time=time,
        q=q,
        command=command,
        status=decision.status,
        reason=decision.reason,
        scale=scale,
        clearances=clearances,
        kept=kept,
        tight=tight,
        X_WT=X_WT,
        timings={
            "kinematics": after_kinematics - start,
            "build": after_build - after_kinematics,
            "solve": after_solve - after_build,
            "verify": end - after_solve,
        },
    )


def _unknown_surroundings(q: np.ndarray, clearances: Clearances) -> str:
    if not np.isfinite(q).all():
        return "measured configuration is not finite"
    # Infinitely far is an answer, infinitely deep is none.
    known = (clearances.distance > -np.inf).all()
    if not (known and np.isfinite(clearances.direction_W).all()):
        return "clearances are not finite"
    return ""


def _blind_report(
    law: ReactiveLaw,
    time: float,
    q: np.ndarray,
    X_WT: np.ndarray,
    u_previous: np.ndarray,
    reason: str,
) -> TickReport:
    """A braking ramp that nothing can verify."""
    none = np.zeros(0, bool)
    decision = brake(law.robot, u_previous, law.dt, reason)
    return TickReport(
        time=time,
        q=q,
        command=decision.u,
        status=decision.status,
        reason=decision.reason,
        scale=1.0,
        clearances=Clearances.none(),
        kept=none,
        tight=none,
        X_WT=X_WT,
    )


def _verified(
    law: ReactiveLaw,
    field: DistanceField,
    state: RobotState,
    u: np.ndarray,
    u_previous: np.ndarray,
    clearances: Clearances,
    guidance: Guidance,
) -> tuple[np.ndarray, float]:
    """The command that may be applied, and its fraction."""
    if not law.config.verify:
        return u, 1.0
    robot, collision = law.robot, law.config.collision
    around = Surroundings(
        robot,
        field,
        state,
        np.minimum(
            clearances.per_sphere(len(state.spheres)), collision.influence
        ),
        collision.stopping_for(guidance),
        law.dt,
        robot.acceleration_limit,
        law.self_clearance,
    )
    return verified_command(around, u, u_previous)


def _row_flags(decision: Decision, m: int) -> tuple[np.ndarray, np.ndarray]:
    program = decision.program
    rows = program and program.rows.get(collision_damper.NAME)
    if not rows:
        return np.zeros(m, bool), np.zeros(m, bool)
    tight = rows.kept & (rows.A @ decision.u >= rows.b - _TIGHT)
    return rows.kept, tight
