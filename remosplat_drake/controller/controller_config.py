"""`ReactiveControllerConfig` and the named gain sets."""

import dataclasses as dc
from collections.abc import Iterator
from itertools import pairwise
from typing import Annotated, cast

from annotated_types import Len

from remosplat_drake.base.ranges import Config, OneOf, check_ranges
from remosplat_drake.controller import ingredients as ing
from remosplat_drake.controller.guidance.guidance_config import GuidanceConfig
from remosplat_drake.controller.ingredients.deflection import NEAR
from remosplat_drake.controller.ingredients.make_ingredients import (
    make_ingredients,
)
from remosplat_drake.controller.planning.planning_config import PlanningConfig
from remosplat_drake.controller.program.ingredient import (
    AnyIngredient,
    Ingredient,
    IngredientMaker,
)
from remosplat_drake.controller.program.solvers import CLARABEL, SOLVERS
from remosplat_drake.controller.rest_config import RestConfig
from remosplat_drake.robot.robot_model import RobotModel

GAINS = ("paper", "tuned", "fast")
"""Names of the gain sets: the paper's published gains, gains for gentle motion,
and gains with which the robot moves as fast as it can."""


@dc.dataclass
class ReactiveControllerConfig(Config):
    """Settings of the reactive controller, and of its costs and constraints.

    The costs and constraints of the quadratic program are called ingredients.
    The default values are the gain set `fast`.
    """

    # Gain set that determines the default values of all other fields.
    gains: Annotated[str, OneOf(GAINS, "gain set")] = "fast"
    # Convex solver of the quadratic program. `active_set` is this library's
    # solver, and all others are Drake's. `mosek` and `gurobi` need a licence.
    solver: Annotated[str, OneOf(SOLVERS, "solver")] = CLARABEL
    # Whether each command and its braking ramp are checked, before the command
    # is applied, for collision with the map, self-collision and joint limits.
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
    path_tracking: ing.PathTrackingConfig = dc.field(
        default_factory=ing.PathTrackingConfig
    )
    movers: ing.MoverDamperConfig = dc.field(
        default_factory=ing.MoverDamperConfig
    )
    # Additional ingredients from outside the library, each written as
    # `package.module:Class` or `!package.module:Class {field: value}`.
    extra: Annotated[list[Ingredient | IngredientMaker], Len(0, 100)] = (
        dc.field(default_factory=list)
    )
    guidance: GuidanceConfig = dc.field(default_factory=GuidanceConfig)
    rest: RestConfig = dc.field(default_factory=RestConfig)

    PRESET = "gains"

    @classmethod
    def preset(cls, name: str) -> "ReactiveControllerConfig":
        """Makes a new configuration from the gain set of a given name.

        Args:
            name: One of `GAINS`.
        """
        return gain_set(name)

    def check(self) -> Iterator[tuple[str, str]]:
        """Checks that each stopping distance is smaller than the one before it.

        `guidance.tiers` are smaller stopping distances that guidance may try.
        They must decrease, and must be smaller than the stopping distance of
        the collision damper. If guidance is enabled, the damper's stopping
        distance must also be smaller than `NEAR`, the clearance below which an
        obstacle deflects the servo's velocity.

        Yields:
            The name of a field that is invalid, and a description of the
            problem.
        """
        stopping, guidance = self.collision.stopping, self.guidance
        if not all(a > b for a, b in pairwise([stopping, *guidance.tiers])):
            yield (
                "guidance.tiers",
                "must decrease, and be below the stopping distance"
                f" {stopping} of `collision`, got {guidance.tiers}",
            )
        if guidance.enabled and not stopping < NEAR:
            yield (
                "guidance.enabled",
                f"needs a collision.stopping below {NEAR}, got {stopping}",
            )

    def ingredients_of(self, robot: RobotModel) -> list[AnyIngredient]:
        """Makes the ingredients; see `default_ingredients`.

        Args:
            robot: The robot to drive.
        """
        return default_ingredients(robot, self)

    @property
    def smallest_stopping(self) -> float:
        """The smallest stopping distance d_s that the controller may use [m].

        It is the collision damper's stopping distance. If guidance is enabled,
        it is the last of `guidance.tiers`.
        """
        tiers = self.guidance.tiers if self.guidance.enabled else []
        return min([self.collision.stopping, *tiers])


def _paper_gains() -> ReactiveControllerConfig:
    """Makes the paper's gain set (sections III-A and IV; authors' code)."""
    return ReactiveControllerConfig(
        gains="paper",
        verify=False,
        servo=ing.ServoTrackingConfig(gain=2.5, max_speed=0.5),
        velocity_cost=ing.VelocityCostConfig(weight=0.01),
        joint_limits=_gentle_joints(),
        collision=ing.CollisionDamperConfig(gain=1.0),
        path_tracking=_gentle_path(),
        velocity_limits=ing.VelocityLimitsConfig(acceleration=False),
        self_collision=ing.SelfCollisionDamperConfig(enabled=False),
        active_collision=ing.ActiveCollisionCostConfig(gain=1.0),
        manipulability=ing.ManipulabilityCostConfig(gain=1.0),
        base_orientation=ing.BaseOrientationCostConfig(gain=0.5),
        guidance=_gentle_guidance(enabled=False),
        rest=RestConfig(enabled=False),
    )


def _tuned_gains() -> ReactiveControllerConfig:
    """Makes the gentle gain set, with which no sphere exceeds 0.35 m/s."""
    return ReactiveControllerConfig(
        gains="tuned",
        servo=ing.ServoTrackingConfig(gain=4.0, max_speed=0.35),
        joint_limits=_gentle_joints(),
        collision=ing.CollisionDamperConfig(gain=1.0),
        path_tracking=_gentle_path(),
        guidance=_gentle_guidance(),
    )


def _gentle_joints() -> ing.JointLimitDamperConfig:
    return ing.JointLimitDamperConfig(gain=1.0, slide_gain=0.25)


def _gentle_path() -> ing.PathTrackingConfig:
    return ing.PathTrackingConfig(look_ahead=0.2, max_speed=0.35)


def _gentle_guidance(enabled: bool = True) -> GuidanceConfig:
    return GuidanceConfig(
        enabled=enabled,
        planning=PlanningConfig(at_once=False, approach_scale=1.0),
    )


GAIN_SETS = {
    "paper": _paper_gains,
    "tuned": _tuned_gains,
    "fast": ReactiveControllerConfig,
}
"""Functions that make the gain sets, keyed by name."""


def gain_set(name: str) -> ReactiveControllerConfig:
    """Makes a new configuration from the gain set of a given name.

    Args:
        name: One of `GAINS`.

    Raises:
        KeyError: There is no such gain set.
    """
    return GAIN_SETS[name]()


def default_ingredients(
    robot: RobotModel, config: ReactiveControllerConfig | None = None
) -> list[AnyIngredient]:
    """Makes the ingredients: the costs and constraints of a configuration.

    Args:
        robot: The robot to drive.
        config: Settings of the controller and its ingredients; None for the
            gain set `fast`.

    Returns:
        The library's eleven ingredients, and then those of `config.extra`.

    Raises:
        FieldError: A value of the configuration is invalid.

    Example:
        >>> import remosplat_drake as rs
        >>> robot = rs.load_robot("frankie")
        >>> [type(part).__name__ for part in rs.default_ingredients(robot)][:2]
        ['ServoTracking', 'VelocityCost']
    """
    config = config or ReactiveControllerConfig()
    check_ranges(config)
    return [
        *make_ingredients(
            robot,
            servo=config.servo,
            velocity_cost=config.velocity_cost,
            velocity_limits=config.velocity_limits,
            joint_limits=config.joint_limits,
            collision=config.collision,
            self_collision=config.self_collision,
            active_collision=config.active_collision,
            manipulability=config.manipulability,
            base_orientation=config.base_orientation,
            path_tracking=config.path_tracking,
            movers=config.movers,
        ),
        *(_made(extra, robot) for extra in config.extra),
    ]


def _made(
    extra: Ingredient | IngredientMaker, robot: RobotModel
) -> AnyIngredient:
    """Returns `extra`, or makes an ingredient from it if it is a maker."""
    if hasattr(extra, "AddToProgram"):
        return cast(Ingredient, extra)
    return cast(IngredientMaker, extra).make(robot)
