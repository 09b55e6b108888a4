"""`make_ingredients`: makes an ingredient of each of the library's classes."""

from remosplat_drake.controller import ingredients as ing
from remosplat_drake.controller.program.compiled_ingredient import (
    CompiledIngredient,
)
from remosplat_drake.robot.robot_model import RobotModel


def make_ingredients(
    robot: RobotModel,
    *,
    servo: ing.ServoTrackingConfig | None = None,
    velocity_cost: ing.VelocityCostConfig | None = None,
    velocity_limits: ing.VelocityLimitsConfig | None = None,
    joint_limits: ing.JointLimitDamperConfig | None = None,
    collision: ing.CollisionDamperConfig | None = None,
    self_collision: ing.SelfCollisionDamperConfig | None = None,
    active_collision: ing.ActiveCollisionCostConfig | None = None,
    manipulability: ing.ManipulabilityCostConfig | None = None,
    base_orientation: ing.BaseOrientationCostConfig | None = None,
    path_tracking: ing.PathTrackingConfig | None = None,
    movers: ing.MoverDamperConfig | None = None,
) -> list[CompiledIngredient]:
    """Makes an ingredient of each of the library's classes.

    Args:
        robot: The robot to drive.
        servo: Settings of the servo tracking. For these and all other settings,
            None means the default values.
        velocity_cost: Settings of the velocity cost.
        velocity_limits: Settings of the velocity limits.
        joint_limits: Settings of the joint limit damper.
        collision: Settings of the collision damper.
        self_collision: Settings of the self-collision damper.
        active_collision: Settings of the active collision cost.
        manipulability: Settings of the manipulability cost.
        base_orientation: Settings of the base orientation cost.
        path_tracking: Settings of the path tracking.
        movers: Settings of the mover damper.
    """
    collision = collision or ing.CollisionDamperConfig()
    movers = movers or ing.MoverDamperConfig()
    own = self_collision or ing.SelfCollisionDamperConfig()
    active = active_collision or ing.ActiveCollisionCostConfig()
    return [
        ing.ServoTracking(servo or ing.ServoTrackingConfig(), collision),
        ing.VelocityCost(velocity_cost or ing.VelocityCostConfig()),
        ing.VelocityLimits(velocity_limits or ing.VelocityLimitsConfig()),
        ing.JointLimitDamper(joint_limits or ing.JointLimitDamperConfig()),
        ing.CollisionDamper(collision),
        ing.SelfCollisionDamper(own, robot),
        ing.ActiveCollisionCost(active, collision, movers),
        ing.ManipulabilityCost(
            manipulability or ing.ManipulabilityCostConfig()
        ),
        ing.BaseOrientationCost(
            base_orientation or ing.BaseOrientationCostConfig()
        ),
        ing.PathTracking(path_tracking or ing.PathTrackingConfig()),
        ing.MoverDamper(movers),
    ]
