"""`ReactiveControllerConfig` and the named gain sets."""

import dataclasses as dc
import math
from collections.abc import Callable
from itertools import pairwise

from remosplat_drake.controller import ingredients as ing
from remosplat_drake.controller.guidance.config import GuidanceConfig
from remosplat_drake.controller.guidance.deflection import NEAR
from remosplat_drake.controller.reactive_program import Ingredient
from remosplat_drake.controller.solvers import make_solver
from remosplat_drake.errors import FieldError, unknown_name
from remosplat_drake.robot.robot_model import RobotModel


@dc.dataclass
class ReactiveControllerConfig:
    """The controller's ingredients and safety switches.

    The defaults are the gain set `tuned`.
    """

    # Gain set that the fields below start from.
    gains: str = "tuned"
    # Convex solver: see controller/solvers.py.
    solver: str = "clarabel"
    # Whether each command is checked against the map before it is applied.
    verify: bool = True
    servo: ing.ServoTrackingConfig = dc.field(
        default_factory=ing.ServoTrackingConfig
    )
    velocity_cost: ing.VelocityCostConfig = dc.field(
        default_factory=ing.VelocityCostConfig
    )
    velocity_limits: ing.VelocityLimitsConfig = dc.field(
        default_factory=ing.VelocityLimitsConfig
    )
    joint_limits: ing.JointLimitDamperConfig = dc.field(
        default_factory=ing.JointLimitDamperConfig
    )
    collision: ing.CollisionDamperConfig = dc.field(
        default_factory=ing.CollisionDamperConfig
    )
    self_collision: ing.SelfCollisionDamperConfig = dc.field(
        default_factory=ing.SelfCollisionDamperConfig
    )
    active_collision: ing.ActiveCollisionCostConfig = dc.field(
        default_factory=ing.ActiveCollisionCostConfig
    )
    manipulability: ing.ManipulabilityCostConfig = dc.field(
        default_factory=ing.ManipulabilityCostConfig
    )
    base_orientation: ing.BaseOrientationCostConfig = dc.field(
        default_factory=ing.BaseOrientationCostConfig
    )
    guidance: GuidanceConfig = dc.field(default_factory=GuidanceConfig)

    @property
    def smallest_stopping(self) -> float:
        """The smallest stopping distance that may come into use [m]."""
        tiers = self.guidance.tiers if self.guidance.enabled else []
        return min([self.collision.stopping, *tiers])


def _paper_gains() -> ReactiveControllerConfig:
    """The authors' published numbers (paper section III-A, IV; their code)."""
    return ReactiveControllerConfig(
        gains="paper",
        verify=False,
        servo=ing.ServoTrackingConfig(gain=2.5, max_speed=0.5),
        velocity_cost=ing.VelocityCostConfig(weight=0.01),
        velocity_limits=ing.VelocityLimitsConfig(acceleration=False),
        self_collision=ing.SelfCollisionDamperConfig(enabled=False),
        active_collision=ing.ActiveCollisionCostConfig(gain=1.0),
        manipulability=ing.ManipulabilityCostConfig(gain=1.0),
        base_orientation=ing.BaseOrientationCostConfig(gain=0.5),
        guidance=GuidanceConfig(enabled=False),
    )


GAIN_SETS = {"paper": _paper_gains, "tuned": ReactiveControllerConfig}
"""Makers of the named configurations that a scenario may start from."""


def gain_set(name: str, where: str) -> ReactiveControllerConfig:
    """A fresh configuration with the gains of that name.

    Raises:
        FieldError: There is no such set.
    """
    if name not in GAIN_SETS:
        raise FieldError(
            where,
            "controller.gains",
            unknown_name("gain set", name, GAIN_SETS),
        )
    return GAIN_SETS[name]()


def check_config(config: ReactiveControllerConfig, where: str) -> None:
    """Checks the ranges that types cannot express.

    Raises:
        FieldError: A value is out of range; names the field.
    """

    def require(ok: bool, field: str, problem: str):
        if not ok:
            raise FieldError(where, f"controller.{field}", problem)

    make_solver(config.solver, where)
    positive = {
        "servo.gain": config.servo.gain,
        "servo.max_speed": config.servo.max_speed,
        "servo.slack_limit": config.servo.slack_limit,
        "velocity_cost.weight": config.velocity_cost.weight,
        "collision.gain": config.collision.gain,
        "joint_limits.gain": config.joint_limits.gain,
        "self_collision.gain": config.self_collision.gain,
    }
    for field, value in positive.items():
        require(value > 0, field, f"must be positive, got {value}")
    for field, value in {
        "active_collision.gain": config.active_collision.gain,
        "manipulability.gain": config.manipulability.gain,
        "base_orientation.gain": config.base_orientation.gain,
        "collision.stopping": config.collision.stopping,
        "self_collision.stopping": config.self_collision.stopping,
        "joint_limits.stop": config.joint_limits.stop,
    }.items():
        require(value >= 0, field, f"must not be negative, got {value}")
    require(
        0 < config.velocity_limits.fraction <= 1,
        "velocity_limits.fraction",
        f"must lie in (0, 1], got {config.velocity_limits.fraction}",
    )
    for name, near, far in (
        ("collision", config.collision.stopping, config.collision.influence),
        (
            "self_collision",
            config.self_collision.stopping,
            config.self_collision.influence,
        ),
        (
            "joint_limits",
            config.joint_limits.stop,
            config.joint_limits.influence,
        ),
    ):
        require(
            near < far < math.inf,
            f"{name}.influence",
            f"must exceed the stopping distance {near}, got {far}",
        )
    _check_guidance(config, where, require)


def _check_guidance(
    config: ReactiveControllerConfig,
    where: str,
    require: Callable[[bool, str, str], None],
) -> None:
    guidance = config.guidance
    make_solver(guidance.solver, where, "guidance.solver")
    require(
        guidance.budget >= 0,
        "guidance.budget",
        f"must not be negative, got {guidance.budget}",
    )
    require(
        0 < guidance.budget_ms < math.inf,
        "guidance.budget_ms",
        f"must be positive, got {guidance.budget_ms}",
    )
    require(
        guidance.step > 0,
        "guidance.step",
        f"must be positive, got {guidance.step}",
    )
    require(
        guidance.horizon > guidance.step,
        "guidance.horizon",
        f"must exceed the step, got {guidance.horizon}",
    )
    require(
        guidance.active_scale >= 0,
        "guidance.active_scale",
        f"must not be negative, got {guidance.active_scale}",
    )
    stopping = config.collision.stopping
    falling = pairwise([stopping, *guidance.tiers])
    require(
        all(a > b for a, b in falling) and all(d > 0 for d in guidance.tiers),
        "guidance.tiers",
        f"must fall from below the stopping distance {stopping} and stay"
        f" positive, got {guidance.tiers}",
    )
    require(
        not guidance.enabled or stopping < NEAR,
        "guidance.enabled",
        f"needs a collision.stopping below {NEAR}, got {stopping}",
    )


def make_ingredients(
    config: ReactiveControllerConfig, robot: RobotModel
) -> list[Ingredient]:
    """The ingredients that a configuration stands for."""
    return [
        ing.ServoTracking(config.servo, config.collision),
        ing.VelocityCost(config.velocity_cost),
        ing.VelocityLimits(config.velocity_limits),
        ing.JointLimitDamper(config.joint_limits),
        ing.CollisionDamper(config.collision),
        ing.SelfCollisionDamper(config.self_collision, robot),
        ing.ActiveCollisionCost(config.active_collision, config.collision),
        ing.ManipulabilityCost(config.manipulability),
        ing.BaseOrientationCost(config.base_orientation),
    ]
