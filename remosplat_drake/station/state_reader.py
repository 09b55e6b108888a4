"""`StateReader`: reads the robot's measurements from a dynamic station."""

from collections.abc import Sequence
from functools import partial

import numpy as np
from pydrake.multibody.plant import MultibodyPlant
from pydrake.systems.framework import (
    BasicVector,
    Context,
    DiagramBuilder,
    LeafSystem,
)

from remosplat_drake.robot.robot_model import RobotModel
from remosplat_drake.signals import station_ports as ports
from remosplat_drake.station.hand import (
    HandGeometry,
    finger_joints,
    finger_slices,
)
from remosplat_drake.station.motors import motor_rows


class StateReader(LeafSystem):
    """Outputs the robot's measurements, from the state of the whole plant.

    .. pydrake_system::

        name: StateReader
        input_ports:
        - plant_state
        - plant_actuation
        output_ports:
        - base.pose_measured
        - base.velocity_measured
        - panda.position_measured
        - panda.velocity_measured
        - hand.state

    The ports have the names of `signals.station_ports`. The input `plant_state`
    is the plant's state, and `plant_actuation` its net actuation.
    `base.velocity_measured` is (v, omega) with v along the measured heading, as
    wheel odometry measures it; for an omnidirectional base it is (v, speed to
    the left, omega). A robot on a fixed base has no `base` ports, and each
    gripper has `hand` ports of its own.
    """

    def __init__(
        self,
        *,
        plant: MultibodyPlant,
        robot: RobotModel,
        hands: Sequence[HandGeometry],
    ):
        """Declares the ports.

        Args:
            plant: The finalized plant.
            robot: The robot in the plant; its description names the ports.
            hands: Geometry of the robot's grippers.
        """
        super().__init__()
        joints = [
            plant.GetJointByName(name)
            for name in (*robot.joint_names, *finger_joints(hands))
        ]
        self._q = np.array([joint.position_start() for joint in joints])
        self._v = plant.num_positions() + np.array(
            [joint.velocity_start() for joint in joints]
        )
        n_arm = len(robot.description.arm.joints)
        self._arm = slice(robot.n_q - n_arm, robot.n_q)
        self._fingers = finger_slices(hands, robot.n_q)
        self._finger_motors = [motor_rows(plant, hand.joints) for hand in hands]
        self._input = self.DeclareVectorInputPort(
            "plant_state", plant.num_multibody_states()
        )
        self._actuation = self.DeclareVectorInputPort(
            "plant_actuation", plant.num_actuators()
        )
        description = robot.description
        outputs = [
            (ports.arm_position(description), n_arm, self._calc_arm),
            (ports.arm_velocity(description), n_arm, self._calc_arm_velocity),
        ]
        if description.base:
            outputs += [
                (ports.BASE_POSE, 3, self._calc_base),
                (
                    ports.BASE_VELOCITY,
                    description.n_base,
                    self._calc_base_velocity,
                ),
            ]
        for i, hand in enumerate(hands):
            self.DeclareVectorOutputPort(
                ports.hand_state(hand.hand),
                3,
                partial(self._calc_hand, i),
                {self._input.ticket(), self._actuation.ticket()},
            )
        for name, size, calc in outputs:
            self.DeclareVectorOutputPort(
                name, size, calc, {self._input.ticket()}
            )

    def AddToBuilder(
        self, builder: DiagramBuilder, plant: MultibodyPlant
    ) -> "StateReader":
        """Adds this system to a diagram, and connects it to the plant."""
        builder.AddNamedSystem("state_reader", self)
        builder.Connect(plant.get_state_output_port(), self._input)
        builder.Connect(plant.get_net_actuation_output_port(), self._actuation)
        return self

    def _calc_arm(self, context: Context, output: BasicVector) -> None:
        output.SetFromVector(self._input.Eval(context)[self._q[self._arm]])

    def _calc_arm_velocity(self, context: Context, output: BasicVector) -> None:
        output.SetFromVector(self._input.Eval(context)[self._v[self._arm]])

    def _calc_base(self, context: Context, output: BasicVector) -> None:
        output.SetFromVector(self._input.Eval(context)[self._q[:3]])

    def _calc_base_velocity(
        self, context: Context, output: BasicVector
    ) -> None:
        x = self._input.Eval(context)
        yaw = x[self._q[2]]
        x_dot, y_dot, omega = x[self._v[:3]]
        forward = np.cos(yaw) * x_dot + np.sin(yaw) * y_dot
        left = np.cos(yaw) * y_dot - np.sin(yaw) * x_dot
        speeds = [forward, left][: output.size() - 1]
        output.SetFromVector([*speeds, omega])

    def _calc_hand(self, i: int, context: Context, output: BasicVector) -> None:
        x, fingers = self._input.Eval(context), self._fingers[i]
        width, rate = x[self._q[fingers]], x[self._v[fingers]]
        force = -self._actuation.Eval(context)[self._finger_motors[i]].mean()
        output.SetFromVector([width.sum(), rate.sum(), force])
