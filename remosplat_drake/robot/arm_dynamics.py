"""`ArmDynamics`: the torques that a motion takes, and those of the motors."""

import dataclasses as dc
from functools import lru_cache

import numpy as np
from pydrake.multibody.plant import MultibodyPlant
from pydrake.multibody.tree import MultibodyForces

from remosplat_drake.robot.model_file import add_robot_model
from remosplat_drake.robot.robot_model import RobotModel


@dc.dataclass(frozen=True, eq=False)
class ArmDynamics:
    """Inverse dynamics of a robot, by the masses of its model file.

    The hand is empty. What the base's motors need is not looked at.

    Attributes:
        plant: A plant with the robot alone.
        rest: Positions of all joints of the plant; those that the robot locks
            are where they are locked.
        position: Places of q in the plant's positions, shape (n_q,).
        velocity: Places of dq/dt in the plant's velocities, shape (n_q,).
        limit: Largest torques of the arm's joints, shape (n_arm,) [N m, N];
            infinite where the model file has none.
    """

    plant: MultibodyPlant
    rest: np.ndarray
    position: np.ndarray
    velocity: np.ndarray
    limit: np.ndarray

    @staticmethod
    @lru_cache(maxsize=8)
    def of(robot: RobotModel) -> "ArmDynamics":
        """Reads the dynamics off the robot's model file, once for each robot.

        Args:
            robot: The robot.
        """
        plant = MultibodyPlant(time_step=0.0)
        add_robot_model(robot.description, plant)
        plant.Finalize()
        joints = [plant.GetJointByName(name) for name in robot.joint_names]
        efforts = {
            plant.get_joint_actuator(i).joint().name(): (
                plant.get_joint_actuator(i).effort_limit()
            )
            for i in plant.GetJointActuatorIndices()
        }
        rest = plant.GetPositions(plant.CreateDefaultContext())
        for name, value in robot.description.locked.items():
            rest[plant.GetJointByName(name).position_start()] = value
        return ArmDynamics(
            plant,
            rest,
            np.array([joint.position_start() for joint in joints]),
            np.array([joint.velocity_start() for joint in joints]),
            np.array(
                [
                    efforts.get(name, np.inf)
                    for name in robot.description.arm.joints
                ]
            ),
        )

    def torques(
        self, q: np.ndarray, v: np.ndarray, a: np.ndarray
    ) -> np.ndarray:
        """Computes the torques of the arm's joints, shape (k, n_arm) [N m, N].

        Args:
            q: Configurations, shape (k, n_q) [rad, m].
            v: Their rates dq/dt, shape (k, n_q) [rad/s, m/s].
            a: Their second derivatives, shape (k, n_q) [rad/s^2, m/s^2].
        """
        plant, positions = self.plant, self.rest.copy()
        context, forces = plant.CreateDefaultContext(), MultibodyForces(plant)
        velocities, accelerations = np.zeros((2, plant.num_velocities()))
        arm = self.velocity[len(self.velocity) - len(self.limit) :]
        found = np.empty((len(q), len(arm)))
        for k in range(len(q)):
            positions[self.position] = q[k]
            velocities[self.velocity] = v[k]
            accelerations[self.velocity] = a[k]
            plant.SetPositions(context, positions)
            plant.SetVelocities(context, velocities)
            plant.CalcForceElementsContribution(context, forces)
            needed = plant.CalcInverseDynamics(context, accelerations, forces)
            found[k] = needed[arm]
        return found
