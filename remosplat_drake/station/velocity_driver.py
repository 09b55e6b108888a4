"""`VelocityDriver`: computes the motors' commands from a station's commands."""

from collections.abc import Sequence

import numpy as np
from pydrake.common.value import Value
from pydrake.multibody.plant import MultibodyPlant
from pydrake.multibody.tree import ModelInstanceIndex
from pydrake.systems.framework import (
    BasicVector,
    Context,
    DiagramBuilder,
    LeafSystem,
    ValueProducer,
)

from remosplat_drake.robot.robot_model import RobotModel
from remosplat_drake.signals import station_ports as ports
from remosplat_drake.signals.station_status import StationStatus
from remosplat_drake.station.commands import CommandInputs, StationCommand
from remosplat_drake.station.hand import (
    HandGeometry,
    finger_slices,
    width_rate,
)
from remosplat_drake.station.motors import Motors, actuator_by_joint


class VelocityDriver(LeafSystem):
    """Computes the motors' desired velocities from a station's commands.

    .. pydrake_system::

        name: VelocityDriver
        input_ports:
        - base.velocity_commanded
        - panda.velocity_commanded
        - hand.command
        - plant_state
        output_ports:
        - desired_state_<model instance>
        - status

    At each step of the plant, the matrix N(q) at the *measured* yaw converts
    the base's speeds to velocities of x, y and yaw. So a command never includes
    sideways slip of a differential base. If a command is not finite, the
    desired velocities are zero, and `status` contains the reason. The ports
    have the names of `signals.station_ports`. `plant_state` is the plant's
    state, and each `desired_state_...` is connected to the port of its model
    instance.
    """

    def __init__(
        self,
        *,
        plant: MultibodyPlant,
        robot: RobotModel,
        hands: Sequence[HandGeometry],
        motors: Motors,
        hand_speed: float,
    ):
        """Declares the ports.

        Args:
            plant: The finalized plant, whose actuators have their gains.
            robot: The robot in the plant; its description names the ports.
            hands: Geometry of the robot's grippers.
            motors: The motors of the robot's joints.
            hand_speed: Speed at which a gripper's width changes [m/s].
        """
        super().__init__()
        self._robot = robot
        self._hands = tuple(hands)
        self._motors = motors
        self._hand_speed = hand_speed
        joints = [plant.GetJointByName(name) for name in motors.joints]
        self._position = np.array([j.position_start() for j in joints])
        self._velocity = plant.num_positions() + np.array(
            [j.velocity_start() for j in joints]
        )
        self._commands = CommandInputs(self, robot)
        self._state_input = self.DeclareVectorInputPort(
            "plant_state", plant.num_multibody_states()
        )
        self._desired = self.DeclareCacheEntry(
            "desired_velocities",
            ValueProducer(
                allocate=Value(np.zeros(0)).Clone, calc=self._calc_desired
            ),
            {self._commands.ticket, self._state_input.ticket()},
        )
        for instance in actuated_instances(plant):
            self._declare_desired_state(plant, instance)
        self.DeclareAbstractOutputPort(
            ports.STATUS,
            lambda: Value(StationStatus()),
            self._calc_status,
            {self._commands.ticket},
        )

    def _declare_desired_state(
        self, plant: MultibodyPlant, instance: ModelInstanceIndex
    ) -> None:
        rows, source = desired_state_rows(plant, instance, self._motors)

        def calc(context: Context, output: BasicVector) -> None:
            x_desired = np.zeros(output.size())
            x_desired[rows] = self._desired.Eval(context)[source]
            output.SetFromVector(x_desired)

        self.DeclareVectorOutputPort(
            desired_state_port(plant, instance),
            plant.get_desired_state_input_port(instance).size(),
            calc,
            {self._desired.ticket()},
        )

    def AddToBuilder(
        self, builder: DiagramBuilder, plant: MultibodyPlant
    ) -> "VelocityDriver":
        """Adds this system to a diagram, and connects it to the plant."""
        builder.AddNamedSystem("velocity_driver", self)
        builder.Connect(plant.get_state_output_port(), self._state_input)
        for instance in actuated_instances(plant):
            builder.Connect(
                self.GetOutputPort(desired_state_port(plant, instance)),
                plant.get_desired_state_input_port(instance),
            )
        return self

    def _calc_desired(self, context: Context, value: Value) -> None:
        x = self._state_input.Eval(context)
        value.set_value(
            desired_velocities(
                self._commands.read(context),
                x[self._position],
                x[self._velocity],
                self._robot,
                self._hands,
                self._motors,
                self._hand_speed,
            )
        )

    def _calc_status(self, context: Context, output: Value) -> None:
        output.set_value(self._commands.read(context).status)


def desired_velocities(
    command: StationCommand,
    q: np.ndarray,
    v: np.ndarray,
    robot: RobotModel,
    hands: Sequence[HandGeometry],
    motors: Motors,
    hand_speed: float,
) -> np.ndarray:
    """Computes the desired velocities of all motors.

    Args:
        command: The station's checked command.
        q: Positions of the motors' joints, shape (m,) [m, rad].
        v: Velocities of the motors' joints, shape (m,) [m/s, rad/s].
        robot: The robot.
        hands: Geometry of the robot's grippers.
        motors: The motors of the robot's joints.
        hand_speed: Speed at which a gripper's width changes [m/s].

    Returns:
        The velocities, shape (m,) [m/s, rad/s].
    """
    desired = np.zeros(len(q))
    configuration = q[: robot.n_q]
    u = command.u
    if robot.n_base:
        slides = slice(robot.n_base - 1)
        headings = robot.velocity_map(configuration)[:2, slides]
        u = u.copy()
        u[slides] = near(u[slides], v[:2] @ headings, motors.drive_error)
    desired[: robot.n_q] = robot.velocity_map(configuration) @ u
    slices = finger_slices(hands, robot.n_q)
    for hand, fingers, told in zip(hands, slices, command.hands, strict=True):
        if told.width is None:
            continue
        rate = width_rate(q[fingers].sum(), told.width, hand, hand_speed)
        # This limits the force of the damper to the commanded force, also if
        # the finger is blocked.
        error = max(told.force, 0.0) / motors.damping[fingers]
        desired[fingers] = near(rate / len(hand.joints), v[fingers], error)
    return desired


def near(desired, measured, error):
    """Clamps `desired` to [`measured` - `error`, `measured` + `error`]."""
    return measured + np.clip(desired - measured, -error, error)


def desired_state_rows(
    plant: MultibodyPlant, instance: ModelInstanceIndex, motors: Motors
) -> tuple[np.ndarray, list[int]]:
    """Finds the velocities of motors in a model instance's desired state.

    Args:
        plant: The finalized plant.
        instance: A model instance with actuators.
        motors: The motors.

    Returns:
        The rows of the desired state that are velocities of motors, and the
        indices of these motors.
    """
    joint_of = {v: k for k, v in actuator_by_joint(plant).items()}
    joints = [
        joint_of[index] for index in plant.GetJointActuatorIndices(instance)
    ]
    motor = [i for i, joint in enumerate(joints) if joint in motors.joints]
    source = [motors.joints.index(joints[i]) for i in motor]
    return len(joints) + np.array(motor, int), source


def actuated_instances(plant: MultibodyPlant) -> list[ModelInstanceIndex]:
    """Lists the model instances of a plant that have actuators."""
    return [
        ModelInstanceIndex(i)
        for i in range(plant.num_model_instances())
        if plant.num_actuators(ModelInstanceIndex(i))
    ]


def desired_state_port(
    plant: MultibodyPlant, instance: ModelInstanceIndex
) -> str:
    """Returns the name of the output port that drives a model instance."""
    return f"desired_state_{plant.GetModelInstanceName(instance)}"
