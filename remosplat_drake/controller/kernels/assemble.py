"""The library's ingredients, added to the program of a tick by one kernel."""

from typing import NamedTuple

import numpy as np

from remosplat_drake.base.kernels import helper, kernel
from remosplat_drake.controller.ingredients.active_collision_cost import (
    ActiveCollisionCost,
    ActiveCollisionSettings,
    add_active_collision_cost,
)
from remosplat_drake.controller.ingredients.base_orientation_cost import (
    BaseOrientationCost,
    BaseOrientationSettings,
    add_base_orientation_cost,
)
from remosplat_drake.controller.ingredients.collision_damper import (
    CollisionDamper,
    CollisionSettings,
    add_collision_damper,
)
from remosplat_drake.controller.ingredients.joint_limit_damper import (
    JointLimitDamper,
    JointLimitSettings,
    add_joint_limit_damper,
)
from remosplat_drake.controller.ingredients.manipulability_cost import (
    ManipulabilityCost,
    ManipulabilitySettings,
    add_manipulability_cost,
)
from remosplat_drake.controller.ingredients.mover_damper import (
    MoverDamper,
    MoverSettings,
    add_mover_damper,
)
from remosplat_drake.controller.ingredients.path_tracking import (
    PathTracking,
    PathTrackingSettings,
    add_path_tracking,
)
from remosplat_drake.controller.ingredients.self_collision_damper import (
    SelfCollisionDamper,
    SelfCollisionSettings,
    add_self_collision_damper,
)
from remosplat_drake.controller.ingredients.servo_tracking import (
    ServoSettings,
    ServoTracking,
    add_servo_tracking,
)
from remosplat_drake.controller.ingredients.velocity_cost import (
    VelocityCost,
    VelocityCostSettings,
    add_velocity_cost,
)
from remosplat_drake.controller.ingredients.velocity_limits import (
    VelocityLimits,
    VelocityLimitsSettings,
    add_velocity_limits,
)
from remosplat_drake.controller.kernels.dense import prune
from remosplat_drake.controller.kernels.tick_arrays import (
    ProgramArrays,
    find_movers,
    make_program,
    make_tick,
    near_arrays,
)
from remosplat_drake.robot.robot_arrays import state_arrays
from remosplat_drake.scene.kernels.mover_reach import aged

PARTS = (
    ServoTracking,
    VelocityCost,
    VelocityLimits,
    JointLimitDamper,
    CollisionDamper,
    SelfCollisionDamper,
    ActiveCollisionCost,
    ManipulabilityCost,
    BaseOrientationCost,
    PathTracking,
    MoverDamper,
)
"""Kinds of ingredients, in the order of `Parts`."""

YIELDING = tuple(
    PARTS.index(kind)
    for kind in (
        MoverDamper,
        JointLimitDamper,
        SelfCollisionDamper,
        CollisionDamper,
    )
)
"""Whose rows yield in an infeasible program, those that yield first first."""


class Parts(NamedTuple):
    """The settings of the library's ingredients, and which of them there are.

    Attributes:
        servo: Settings of the `ServoTracking`.
        velocity: Settings of the `VelocityCost`.
        limits: Settings of the `VelocityLimits`.
        joints: Settings of the `JointLimitDamper`.
        collision: Settings of the `CollisionDamper`.
        own: Settings of the `SelfCollisionDamper`.
        active: Settings of the `ActiveCollisionCost`.
        arm: Settings of the `ManipulabilityCost`.
        bearing: Settings of the `BaseOrientationCost`.
        path: Settings of the `PathTracking`.
        movers: Settings of the `MoverDamper`.
        present: Which of these the law has, shape (11,), bool.
    """

    servo: ServoSettings
    velocity: VelocityCostSettings
    limits: VelocityLimitsSettings
    joints: JointLimitSettings
    collision: CollisionSettings
    own: SelfCollisionSettings
    active: ActiveCollisionSettings
    arm: ManipulabilitySettings
    bearing: BaseOrientationSettings
    path: PathTrackingSettings
    movers: MoverSettings
    present: np.ndarray


@helper
def assemble(
    parts,
    robot,
    state,
    aim,
    rows,
    movers,
    near,
    u_previous,
    dt,
    tube,
    guidance,
) -> ProgramArrays:
    """Builds the program of a tick.

    Args:
        parts: The `Parts`.
        robot: The `RobotArrays`.
        state: The `StateArrays`.
        aim: The `AimArrays`.
        rows: Spheres, distances and directions of the m clearances.
        movers: The `MoverArrays`.
        near: Where to look whether links are near each other, the
            `NearQuestion`.
        u_previous: The command that is being executed, shape (n_u,).
        dt: Control period [s].
        tube: By how much each sphere may be off its path, shape (n,) [m].
        guidance: The `GuidanceArrays`.
    """
    found = find_movers(
        movers,
        state.p_WS,
        robot.radius,
        parts.movers.influence,
        parts.active.lead,
        parts.active.mover_influence,
    )
    links = near_arrays(near, state.X_WL)
    tick = make_tick(
        robot, state, aim, rows, found, links, u_previous, dt, tube, guidance
    )
    most = len(rows[0]) + len(links.pair) + 2 * len(parts.joints.gain)
    most += len(tick.moving.sphere)
    has = parts.present
    program = make_program(
        robot.velocity_limit, len(robot.body_E), len(has), most
    )
    if has[0]:
        add_servo_tracking(parts.servo, 0, tick, program)
    if has[1]:
        add_velocity_cost(parts.velocity, 1, tick, program)
    if has[2]:
        add_velocity_limits(parts.limits, 2, tick, program)
    if has[3]:
        add_joint_limit_damper(parts.joints, 3, tick, program)
    if has[4]:
        add_collision_damper(parts.collision, 4, tick, program)
    if has[5]:
        add_self_collision_damper(parts.own, 5, tick, program)
    if has[6]:
        add_active_collision_cost(parts.active, 6, tick, program)
    if has[7]:
        add_manipulability_cost(parts.arm, 7, tick, program)
    if has[8]:
        add_base_orientation_cost(parts.bearing, 8, tick, program)
    if has[9]:
        add_path_tracking(parts.path, 9, tick, program)
    if has[10]:
        add_mover_damper(parts.movers, 10, tick, program)
    prune(program)
    return program


@kernel
def assemble_tick(
    parts,
    near,
    robot,
    movers,
    age,
    aim,
    rows,
    q,
    u_previous,
    dt,
    tube,
    guidance,
) -> ProgramArrays:
    """Builds the program of a tick, as Python asks for it.

    Args:
        parts: See `assemble`, as of all that is not named here.
        near: See above.
        robot: See above.
        movers: The `MoverArrays` at their stamp.
        age: How old what is known of the movers is [s].
        aim: See above.
        rows: See above.
        q: The configuration, shape (n_q,) [rad, m].
        u_previous: See above.
        dt: See above.
        tube: See above.
        guidance: See above.
    """
    return assemble(
        parts,
        robot,
        state_arrays(robot, q),
        aim,
        rows,
        aged(movers, age),
        near,
        u_previous,
        dt,
        tube,
        guidance,
    )
