"""A baseline for comparison: Drake's own differential inverse kinematics.

Drake's `DifferentialInverseKinematicsSystem` supports neither splats nor a base
that cannot move sideways. This module adapts it as follows, so that the
comparison is fair:

- The baseline gets the scene's true solids, like the method `sdf-hard`, so that
  the results of these two methods are comparable. They have the same spheres,
  stopping and influence distances, velocity limits and joint-limit margins. The
  desired twist is that of the paper's servo with the paper's gains.
- The plant's world frame is the robot's base frame B: the base's joints remain
  at zero, and the scene moves. Only the joints x and yaw of the base are
  active, which excludes sideways motion exactly.
- Costs and constraints are Drake's: least squares on the twist, the home
  posture in the null space, and collision constraints. If Drake finds no
  solution, the robot stands still. Drake's collision constraints allow a
  distance to decrease to the stopping distance within one tick. The paper's
  constraints allow only a tenth of the remaining margin per tick.
"""

import os
import sys
from collections.abc import Iterator
from contextlib import contextmanager

import numpy as np
from pydrake.common.value import AbstractValue
from pydrake.multibody.inverse_kinematics import (
    DifferentialInverseKinematicsSystem as DiffIk,
)
from pydrake.multibody.math import SpatialVelocity
from pydrake.planning import DofMask, JointLimits
from pydrake.systems.framework import BusValue

from remosplat_drake.base.errors import RemoSplatError
from remosplat_drake.benchmark.custom_controller import Control
from remosplat_drake.benchmark.drake_baseline_model import (
    SIDEWAYS,
    CollisionModel,
    make_collision_model,
)
from remosplat_drake.controller.controller_config import gain_set
from remosplat_drake.controller.program.servo import servo_twist
from remosplat_drake.oracle.signed_distance import SignedDistanceField
from remosplat_drake.robot.pose_error import pose_error
from remosplat_drake.robot.robot_model import RobotModel
from remosplat_drake.signals.distance_field import DistanceField

GAINS = gain_set("paper")
"""The paper's gain set: settings of the servo, the distances and the
margins."""

TWIST_WEIGHT = 100.0
"""Weight of tracking relative to the cost of the posture, as in Drake's
documentation."""

POSTURE_GAIN = 1.0
"""Gain towards the home posture, in the null space of tracking [1/s]."""


def make_control(
    robot: RobotModel, field: DistanceField, X_WT: np.ndarray, dt: float
) -> Control:
    """Makes the controller, as a function for `custom_controller`.

    Args:
        robot: Model of a robot with a differential base.
        field: Distances to the true solids; no other map is accepted.
        X_WT: Target pose of the end effector in W, shape (4, 4).
        dt: Control period [s].

    Returns:
        A function from q (n_q,) and the previous u (n_u,) to the next u (n_u,).

    Raises:
        RemoSplatError: The map does not consist of solids, or the base is
            fixed.
    """
    if not isinstance(field, SignedDistanceField):
        raise RemoSplatError(
            "drake-ik: Drake's collision checker needs a scene of true "
            "solids, not a splat or a capture"
        )
    if not robot.n_base:
        raise RemoSplatError("drake-ik: needs a robot with a mobile base")
    model = make_collision_model(robot, field.scene)
    system = _make_system(robot, model, dt)
    context = system.CreateDefaultContext()
    rest = model.positions(np.array([0.0, 0.0, 0.0, *robot.home]))
    system.get_input_port_nominal_posture().FixValue(context, rest)

    def control(q: np.ndarray, u_previous: np.ndarray) -> np.ndarray:
        state = robot.state(q)
        w, v = servo_twist(
            pose_error(state.X_WE, X_WT),
            GAINS.servo.gain,
            GAINS.servo.fastest,
        )
        R_BW = state.X_WB[:3, :3].T
        twists = BusValue()
        twists.Set(
            model.end_effector,
            AbstractValue.Make(SpatialVelocity(R_BW @ w, R_BW @ v)),
        )
        system.get_input_port_position().FixValue(context, model.positions(q))
        system.get_input_port_desired_cartesian_velocities().FixValue(
            context, AbstractValue.Make(twists)
        )
        with _quiet():
            u = system.get_output_port_commanded_velocity().Eval(context)
        # The solver may exceed limits by its tolerance.
        return u / max(1.0, np.max(np.abs(u) / robot.velocity_limit))

    return control


@contextmanager
def _quiet() -> Iterator[None]:
    """Suppresses the solver's output, for which Drake has no option."""
    sys.stdout.flush()
    stdout, nowhere = os.dup(1), os.open(os.devnull, os.O_WRONLY)
    os.dup2(nowhere, 1)
    try:
        yield
    finally:
        os.dup2(stdout, 1)
        os.close(stdout)
        os.close(nowhere)


def _make_system(robot: RobotModel, model: CollisionModel, dt: float) -> DiffIk:
    tracking = DiffIk.LeastSquaresCost.Config()
    tracking.cartesian_qp_weight = TWIST_WEIGHT
    centring = DiffIk.JointCenteringCost.Config()
    centring.posture_gain = POSTURE_GAIN
    collision = DiffIk.CollisionConstraint.Config()
    collision.safety_distance = GAINS.collision.stopping
    collision.influence_distance = GAINS.collision.influence
    recipe = DiffIk.Recipe()
    recipe.AddIngredient(DiffIk.LeastSquaresCost(tracking))
    recipe.AddIngredient(DiffIk.JointCenteringCost(centring))
    recipe.AddIngredient(_limits(robot))
    recipe.AddIngredient(DiffIk.CollisionConstraint(collision))
    plant = model.checker.plant()
    active = np.arange(plant.num_positions()) < model.n_u
    unlimited = np.full(3, np.inf)
    return DiffIk(
        recipe=recipe,
        task_frame=plant.world_frame().scoped_name().get_full(),
        collision_checker=model.checker,
        active_dof=DofMask(active.tolist()),
        time_step=dt,
        K_VX=1.0,
        Vd_TG_limit=SpatialVelocity(unlimited, unlimited),
    )


def _limits(robot: RobotModel) -> "DiffIk.JointVelocityLimitConstraint":
    """Returns velocity limits that decrease near joint limits (paper)."""
    config = DiffIk.JointVelocityLimitConstraint.Config()
    config.min_margin = np.radians(GAINS.joint_limits.stop)
    config.influence_margin = np.radians(GAINS.joint_limits.influence)
    unlimited = np.full(robot.n_u, np.inf)
    lower, upper = (
        np.delete(limit, SIDEWAYS)
        for limit in (robot.position_lower, robot.position_upper)
    )
    limits = JointLimits(
        position_lower=lower,
        position_upper=upper,
        velocity_lower=-robot.velocity_limit,
        velocity_upper=robot.velocity_limit,
        acceleration_lower=-unlimited,
        acceleration_upper=unlimited,
    )
    return DiffIk.JointVelocityLimitConstraint(config, limits)
