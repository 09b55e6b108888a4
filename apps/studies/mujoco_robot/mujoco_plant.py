"""`MujocoPlant`: the stand-in's rigid bodies, moved by MuJoCo."""

from collections.abc import Sequence

import mujoco
import numpy as np
from pydrake.multibody.plant import MultibodyPlant

from apps.studies.mujoco_robot.model import STEP, mujoco_model
from remosplat_drake.base.errors import RemoSplatError
from remosplat_drake.hardware.stand_in.robot_plant import RobotPlant
from remosplat_drake.hardware.stand_in.simulated_arm import ArmMeasurement
from remosplat_drake.robot.model_file import add_robot_model
from remosplat_drake.robot.robot_model import RobotModel
from remosplat_drake.scene.objects.scene_object import SceneObject
from remosplat_drake.scene.primitive_scene import PrimitiveScene
from remosplat_drake.signals.station_status import StationStatus
from remosplat_drake.station.commands import HandCommand, StationCommand
from remosplat_drake.station.hand import hand_geometries
from remosplat_drake.station.motors import effort_limits, make_motors
from remosplat_drake.station.station_config import DynamicStation
from remosplat_drake.station.velocity_driver import desired_velocities, near


class MujocoPlant(RobotPlant):
    """A robot whose dynamics and contacts are MuJoCo's.

    Its commands, measurements and motors are those of `RobotPlant`.
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
            config: Hand speed and time constant of the motors.
            robot: The robot.
            scene: The solids that the robot may bump into; None for none.
            q0: Configuration to start from, shape (n_q,).
            objects: None are supported.

        Raises:
            RemoSplatError: There are objects.
        """
        if objects:
            raise RemoSplatError("objects are not simulated by MuJoCo")
        self.robot, self._config, self._since = robot, config, 0.0
        drakes = MultibodyPlant(time_step=0.0)
        add_robot_model(robot.description, drakes)
        self._hands = hand_geometries(robot.description, drakes)
        drakes.Finalize()
        self._motors = make_motors(robot, self._hands, q0, config)
        # In one step, force f closes the error e = f / d + f dt / M. A bound on
        # the force itself would be explicit, and light joints would chatter.
        effort = effort_limits(drakes, robot, self._motors.joints)
        share = effort / self._motors.damping
        self._most = share * (1.0 + STEP / config.velocity_time_constant)
        self._model = mujoco_model(robot, drakes, scene, self._motors)
        self._data = mujoco.MjData(self._model)
        joints = [self._model.joint(name) for name in self._motors.joints]
        self._at = np.array([joint.qposadr[0] for joint in joints])
        self._dof = np.array([joint.dofadr[0] for joint in joints])
        start = dict(zip(robot.joint_names, q0, strict=True))
        for name, place in zip(self._motors.joints, self._at, strict=True):
            locked = robot.description.locked.get(name, 0.0)
            self._data.qpos[place] = start.get(name, locked)
        mujoco.mj_forward(self._model, self._data)
        self._measure()

    def _measure(self) -> None:
        self._q = self._data.qpos[self._at].copy()
        self._v = self._data.qvel[self._dof].copy()

    def step(
        self, t: float, base: np.ndarray, arm: np.ndarray, hand: np.ndarray
    ) -> None:
        """Moves the robot up to time t; see `RobotPlant.step`."""
        hands = (HandCommand(*hand),) * len(self._hands)
        command = StationCommand(
            np.concatenate([base, arm]), hands, StationStatus()
        )
        while self._data.time < t - 0.5 * STEP:
            desired = desired_velocities(
                command,
                self._q,
                self._v,
                self.robot,
                self._hands,
                self._motors,
                self._config.hand_speed,
            )
            self._data.ctrl[:] = near(desired, self._v, self._most)
            mujoco.mj_step(self._model, self._data)
            self._measure()

    @property
    def arm(self) -> ArmMeasurement:
        """Positions, rates and torques that the arm's sensors measure."""
        n, n_q = len(self.robot.home), self.robot.n_q
        arm = slice(n_q - n, n_q)
        return ArmMeasurement(
            self._q[arm],
            self._v[arm],
            self._data.actuator_force[arm].copy(),
            self._data.qfrc_constraint[self._dof[arm]],
        )

    @property
    def hand(self) -> np.ndarray:
        """True opening of the hand, its rate and force, (3,) [m, m/s, N]."""
        n = self.robot.n_q
        effort = self._data.actuator_force[n:]
        force = -effort.mean() if len(effort) else 0.0
        return np.array([self._q[n:].sum(), self._v[n:].sum(), force])
