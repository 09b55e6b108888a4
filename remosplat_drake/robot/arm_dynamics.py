"""`ArmDynamics`: computes the arm's joint torques; has the motors' limits."""

import dataclasses as dc

import numpy as np
from pydrake.multibody.plant import MultibodyPlant

from remosplat_drake.base.kernels.packed import Packed
from remosplat_drake.robot.inverse_dynamics import (
    MassArrays,
    inverse_dynamics,
    motors,
)
from remosplat_drake.robot.kinematics import KinematicTree
from remosplat_drake.robot.payload import Payload


@dc.dataclass(frozen=True, eq=False)
class ArmDynamics:
    """Inverse dynamics of a robot, with the masses of its model file.

    The class does not compute forces of the base's motors.

    Attributes:
        tree: The robot's tree.
        masses: The masses of its bodies.
        limit: Largest torques of the arm's joints, shape (n_arm,) [N m, N];
            infinite if the model file states none.
    """

    tree: KinematicTree
    masses: Packed[MassArrays]
    limit: np.ndarray

    @staticmethod
    def read(
        plant: MultibodyPlant,
        tree: KinematicTree,
        base_joints: list[str],
        arm_joints: list[str],
    ) -> "ArmDynamics":
        """Reads the dynamics from a finalized plant.

        Args:
            plant: A plant with the robot alone.
            tree: The robot's tree.
            base_joints: Names of the base's joints.
            arm_joints: Names of the arm's joints.
        """
        efforts = {
            name: motor.effort_limit() for name, motor in motors(plant).items()
        }
        limit = np.array([efforts.get(name, np.inf) for name in arm_joints])
        masses = MassArrays.read(plant, tree, [*base_joints, *arm_joints])
        return ArmDynamics(tree, masses, limit)

    def holding(self, tree: KinematicTree, payload: Payload) -> "ArmDynamics":
        """Returns the dynamics of the robot with a payload in its hand.

        Args:
            tree: The robot's tree with the payload as its last body.
            payload: The payload.
        """
        masses = self.masses.values
        held = masses._replace(
            mass=np.append(masses.mass, payload.mass),
            p_BBcm=np.concatenate([masses.p_BBcm, payload.p_OOcm[None]]),
            I_BBcm=np.concatenate([masses.I_BBcm, payload.I_OOcm[None]]),
        )
        return ArmDynamics(tree, Packed(held), self.limit)

    def torques(
        self, q: np.ndarray, v: np.ndarray, a: np.ndarray
    ) -> np.ndarray:
        """Computes the torques of the arm's joints, (k, m, n_arm) [N m, N].

        Args:
            q: Configurations, shape (k, n_q) [rad, m].
            v: Rates dq/dt of m motions through each configuration, shape (k, m,
                n_q) [rad/s, m/s].
            a: Second derivatives of q for these motions, shape (k, m, n_q)
                [rad/s^2, m/s^2].
        """
        found = inverse_dynamics(self.tree.arrays, self.masses, q, v, a)
        return found[:, :, q.shape[1] - len(self.limit) :]
