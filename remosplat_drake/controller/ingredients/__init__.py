"""Ingredients: costs and constraints of the controller's quadratic program."""

from remosplat_drake.controller.ingredients.active_collision_cost import (
    ActiveCollisionCost,
    ActiveCollisionCostConfig,
)
from remosplat_drake.controller.ingredients.base_orientation_cost import (
    BaseOrientationCost,
    BaseOrientationCostConfig,
)
from remosplat_drake.controller.ingredients.collision_damper import (
    CollisionDamper,
    CollisionDamperConfig,
)
from remosplat_drake.controller.ingredients.joint_limit_damper import (
    JointLimitDamper,
    JointLimitDamperConfig,
)
from remosplat_drake.controller.ingredients.manipulability_cost import (
    ManipulabilityCost,
    ManipulabilityCostConfig,
)
from remosplat_drake.controller.ingredients.mover_damper import (
    MoverDamper,
    MoverDamperConfig,
)
from remosplat_drake.controller.ingredients.path_tracking import (
    PathTracking,
    PathTrackingConfig,
)
from remosplat_drake.controller.ingredients.self_collision_damper import (
    SelfCollisionDamper,
    SelfCollisionDamperConfig,
)
from remosplat_drake.controller.ingredients.servo_tracking import (
    ServoTracking,
    ServoTrackingConfig,
)
from remosplat_drake.controller.ingredients.velocity_cost import (
    VelocityCost,
    VelocityCostConfig,
)
from remosplat_drake.controller.ingredients.velocity_limits import (
    VelocityLimits,
    VelocityLimitsConfig,
)

__all__ = [
    "ActiveCollisionCost",
    "ActiveCollisionCostConfig",
    "BaseOrientationCost",
    "BaseOrientationCostConfig",
    "CollisionDamper",
    "CollisionDamperConfig",
    "JointLimitDamper",
    "JointLimitDamperConfig",
    "ManipulabilityCost",
    "ManipulabilityCostConfig",
    "MoverDamper",
    "MoverDamperConfig",
    "PathTracking",
    "PathTrackingConfig",
    "SelfCollisionDamper",
    "SelfCollisionDamperConfig",
    "ServoTracking",
    "ServoTrackingConfig",
    "VelocityCost",
    "VelocityCostConfig",
    "VelocityLimits",
    "VelocityLimitsConfig",
]
