"""`RobotPlant`: the dynamic station, driven step by step from outside."""

import numpy as np
from pydrake.multibody.plant import MultibodyPlant
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import Diagram, InputPort

from remosplat_drake.drivers.panda_commands import JOINTS
from remosplat_drake.drivers.simulated_panda import ArmMeasurement
from remosplat_drake.errors import RemoSplatError
from remosplat_drake.robot.robot_model import RobotModel
from remosplat_drake.station import ports


class RobotPlant:
    """The robot's bodies and motors, in steps of a millisecond.

    Drake steps the rigid bodies; here are only the few numbers that go in
    and out of each step.
    """

    def __init__(self, station: Diagram, robot: RobotModel):
        """Starts at the station's initial configuration.

        Args:
            station: A dynamic station.
            robot: The robot in it: a Panda with a hand on a mobile base.

        Raises:
            RemoSplatError: It is another kind of robot.
        """
        description = robot.description
        if (
            len(description.arm.joints) != JOINTS
            or not description.base
            or not description.hand
        ):
            raise RemoSplatError(
                f"{description.name}: the simulated drivers are those of a"
                " Panda with a hand on a mobile base"
            )
        self._simulator = Simulator(station)
        self._context = self._simulator.get_mutable_context()
        self._commands = [
            self._fix(station.GetInputPort(name))
            for name in (
                ports.BASE_COMMAND,
                ports.arm_command(description),
                ports.hand_command(description),
            )
        ]
        self._outputs = {
            name: station.GetOutputPort(name)
            for name in (
                ports.BASE_POSE,
                ports.BASE_VELOCITY,
                ports.hand_state(description),
            )
        }
        self._hand_state = ports.hand_state(description)
        self._arm_position = station.GetOutputPort(
            ports.arm_position(description)
        )
        self._arm_velocity = station.GetOutputPort(
            ports.arm_velocity(description)
        )
        plant = station.GetSubsystemByName("plant")
        assert isinstance(plant, MultibodyPlant)
        self._plant_context = plant.GetMyContextFromRoot(self._context)
        joint = plant.GetJointByName(description.arm.joints[0])
        arm = joint.model_instance()
        self._torque = plant.get_net_actuation_output_port(arm)
        self._external = plant.get_generalized_contact_forces_output_port(arm)
        self.command(np.zeros(2), np.zeros(JOINTS), np.array([self.hand[0], 0]))
        self._simulator.Initialize()

    def _fix(self, port: InputPort):
        return port.FixValue(self._context, np.zeros(port.size()))

    def command(
        self, base: np.ndarray, arm: np.ndarray, hand: np.ndarray
    ) -> None:
        """Sets what the motors do from now on.

        Args:
            base: Forward speed and yaw rate, shape (2,) [m/s, rad/s].
            arm: Joint rates, shape (7,) [rad/s].
            hand: Width and bound on the force, shape (2,) [m, N].
        """
        for fixed, values in zip(
            self._commands, (base, arm, hand), strict=True
        ):
            fixed.GetMutableData().get_mutable_value().SetFromVector(values)

    def advance_to(self, t: float) -> None:
        """Steps the rigid bodies up to time t [s]."""
        self._simulator.AdvanceTo(t)

    @property
    def arm(self) -> ArmMeasurement:
        """What the arm's sensors say now."""
        return ArmMeasurement(
            self._arm_position.Eval(self._context),
            self._arm_velocity.Eval(self._context),
            self._torque.Eval(self._plant_context),
            self._external.Eval(self._plant_context),
        )

    @property
    def base_pose(self) -> np.ndarray:
        """x, y, yaw in W, shape (3,) [m, m, rad]."""
        return self._outputs[ports.BASE_POSE].Eval(self._context)

    @property
    def base_velocity(self) -> np.ndarray:
        """Forward speed and yaw rate, shape (2,) [m/s, rad/s]."""
        return self._outputs[ports.BASE_VELOCITY].Eval(self._context)

    @property
    def hand(self) -> np.ndarray:
        """Width of the hand and its rate, shape (2,) [m, m/s]."""
        return self._outputs[self._hand_state].Eval(self._context)
