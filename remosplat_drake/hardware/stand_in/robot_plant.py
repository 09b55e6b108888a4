"""`RobotPlant`: the rigid bodies of the dynamic station, without a diagram."""

from collections.abc import Sequence

import numpy as np
from pydrake.multibody.tree import ModelInstanceIndex
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import DiagramBuilder

from remosplat_drake.hardware.stand_in.simulated_arm import ArmMeasurement
from remosplat_drake.robot.robot_model import RobotModel
from remosplat_drake.scene.objects.scene_object import SceneObject
from remosplat_drake.scene.primitive_scene import PrimitiveScene
from remosplat_drake.signals.station_status import StationStatus
from remosplat_drake.station.commands import HandCommand, StationCommand
from remosplat_drake.station.dynamic_station import add_dynamic_body
from remosplat_drake.station.motors import motor_rows
from remosplat_drake.station.station_config import DynamicStation
from remosplat_drake.station.velocity_driver import (
    actuated_instances,
    desired_state_rows,
    desired_velocities,
)

_RUNNING = StationStatus()

_INSTANT = 1e-9
"""Largest time difference that counts as a rounding error [s]."""


PERIOD = 0.005
"""Time between two steps of the bodies in a stand-in [s]. Steps of a
millisecond would take half of the time of a slow core, and the stand-in must
not be late.
"""


class RobotPlant:
    """The robot's rigid bodies and motors, advanced by calls of `step`.

    The motors have the control law of the dynamic station. This class calls the
    law directly, once per step of the bodies, because an evaluation through
    Drake's ports would take as long as the simulation of the bodies. A step of
    the bodies lasts for the station's `time_step`. Between two steps, the robot
    continues at the velocity of the latest step.

    Attributes:
        robot: The robot.
    """

    def __init__(
        self,
        config: DynamicStation,
        robot: RobotModel,
        scene: PrimitiveScene | None,
        q0: np.ndarray,
        objects: Sequence[SceneObject] = (),
    ):
        """Builds the bodies; the robot stands still.

        Args:
            config: Physics of the dynamic station.
            robot: The robot.
            scene: The solids with which the robot may collide; None if there
                are none.
            q0: Initial configuration, shape (n_q,).
            objects: Objects that a hand may grasp, at their initial poses.
        """
        builder = DiagramBuilder()
        body = add_dynamic_body(
            builder, config, robot, scene, q0, objects=objects
        )
        plant = body.plant
        self.robot, self._body = robot, body
        self._hand_speed = config.hand_speed
        self._period = config.time_step
        self._stepped, self._since = 0.0, 0.0
        self._simulator = Simulator(builder.Build())
        self._context = plant.GetMyMutableContextFromRoot(
            self._simulator.get_mutable_context()
        )
        joints = [plant.GetJointByName(name) for name in body.motors.joints]
        self._position = np.array([j.position_start() for j in joints])
        self._velocity = plant.num_positions() + np.array(
            [j.velocity_start() for j in joints]
        )
        self._inputs = [self._fix(i) for i in actuated_instances(plant)]
        self._n_arm = len(robot.home)
        arm = joints[robot.n_q - self._n_arm : robot.n_q]
        instance = arm[0].model_instance()
        self._torques = plant.get_net_actuation_output_port()
        self._arm_motors = motor_rows(plant, [j.name() for j in arm])
        self._finger_motors = [
            row for hand in body.hands for row in motor_rows(plant, hand.joints)
        ]
        self._external = plant.get_generalized_contact_forces_output_port(
            instance
        )
        of_instance = plant.GetVelocitiesFromArray(
            instance, np.arange(float(plant.num_velocities()))
        ).tolist()
        self._arm = [of_instance.index(j.velocity_start()) for j in arm]
        self._simulator.Initialize()
        self._measure()

    def _fix(self, instance: ModelInstanceIndex):
        """Fixes the input for the desired state of a model instance."""
        plant = self._body.plant
        port = plant.get_desired_state_input_port(instance)
        x_desired = np.zeros(port.size())
        fixed = port.FixValue(self._context, x_desired)
        rows, source = desired_state_rows(plant, instance, self._body.motors)
        return fixed, x_desired, rows, source

    def _measure(self) -> None:
        plant = self._body.plant
        x = plant.GetPositionsAndVelocities(self._context)
        self._q, self._v = x[self._position], x[self._velocity]

    def step(
        self, t: float, base: np.ndarray, arm: np.ndarray, hand: np.ndarray
    ) -> None:
        """Advances the robot to time t.

        If a step of the bodies ends before or at time t, this command is used
        for the whole step.

        Args:
            t: Time at the end of the step [s].
            base: Commands to the base, shape (n_base,) [m/s, rad/s].
            arm: Commanded joint rates, shape (n,) [rad/s].
            hand: Commanded width and bound on the force, shape (2,) [m, N];
                ignored by a robot without a hand.
        """
        self._since = t - self._stepped
        if self._since < self._period - _INSTANT:
            return
        hands = (HandCommand(*hand),) * len(self._body.hands)
        command = StationCommand(np.concatenate([base, arm]), hands, _RUNNING)
        desired = desired_velocities(
            command,
            self._q,
            self._v,
            self.robot,
            self._body.hands,
            self._body.motors,
            self._hand_speed,
        )
        for fixed, x_desired, rows, source in self._inputs:
            x_desired[rows] = desired[source]
            fixed.GetMutableData().get_mutable_value().SetFromVector(x_desired)
        self._simulator.AdvanceTo(t)
        self._stepped, self._since = t, 0.0
        self._measure()

    @property
    def q(self) -> np.ndarray:
        """Configuration (x, y, yaw, arm), shape (n_q,) [m, rad]."""
        n = self.robot.n_q
        return self._q[:n] + self._since * self._v[:n]

    @property
    def arm(self) -> ArmMeasurement:
        """Positions, rates and torques that the arm's sensors measure."""
        n = self.robot.n_q
        return ArmMeasurement(
            self.q[n - self._n_arm :],
            self._v[n - self._n_arm : n],
            self._torques.Eval(self._context)[self._arm_motors],
            self._external.Eval(self._context)[self._arm],
        )

    @property
    def base_velocity(self) -> np.ndarray:
        """True speeds forward and to the left, and turning rate, shape (3,).

        They are in m/s, m/s and rad/s. Shape (0,) without a base.
        """
        if not self.robot.n_base:
            return np.zeros(0)
        x_dot, y_dot, yaw_rate = self._v[:3]
        c, s = np.cos(self._q[2]), np.sin(self._q[2])
        return np.array(
            [c * x_dot + s * y_dot, c * y_dot - s * x_dot, yaw_rate]
        )

    @property
    def hand(self) -> np.ndarray:
        """True opening of the hand, its rate and force, (3,) [m, m/s, N]."""
        n = self.robot.n_q
        effort = self._torques.Eval(self._context)[self._finger_motors]
        force = -effort.mean() if len(effort) else 0.0
        return np.array([self._q[n:].sum(), self._v[n:].sum(), force])
