"""`DetectionCameraConfig`: a depth camera that detects moving objects."""

import dataclasses as dc
from collections.abc import Callable, Iterator
from typing import Annotated

import numpy as np
from annotated_types import Interval, Len
from pydrake.math import RigidTransform, RollPitchYaw, RotationMatrix

from remosplat_drake.base.ranges import Config, Position, RollPitchYawDeg
from remosplat_drake.camera.mount import CameraMount
from remosplat_drake.camera.wrist_camera_config import WristCameraConfig
from remosplat_drake.robot.robot_model import RobotModel


@dc.dataclass
class DetectionCameraConfig(Config):
    """A depth camera, fixed in the world or on the robot."""

    # Name of the camera; `remosplat camera-sim --camera NAME` simulates it.
    name: Annotated[str, Len(1, 40)] = "room"
    # LCM channel of the images (lcmt_image_array). If empty, it is the camera's
    # name in capitals with the suffix _CAMERA.
    channel: Annotated[str, Len(0, 63)] = ""
    # Name of the robot model's frame that carries the camera. If empty, the
    # camera is fixed in W.
    frame: str = ""
    # Position of the camera in `frame`, or in W if `frame` is empty [m].
    translation: Position = dc.field(default_factory=lambda: [0.0] * 3)
    # Roll, pitch and yaw [deg] of the camera's axes: x right in the image, y
    # down, z forward (OpenCV). If absent, `look_at` determines them; without
    # `look_at`, they are 0.
    rpy_deg: RollPitchYawDeg | None = None
    # Point in W at which a fixed, upright camera looks [m]; it replaces
    # `rpy_deg`.
    look_at: Position | None = None
    # Width of the images [pixels].
    width: Annotated[int, Interval(ge=16, le=4096)] = 640
    # Height of the images [pixels].
    height: Annotated[int, Interval(ge=16, le=4096)] = 480
    # Vertical field of view [deg].
    fov_y_deg: Annotated[float, Interval(gt=0, lt=180)] = 58.0
    # Least depth that the camera measures [m].
    min_depth: Annotated[float, Interval(gt=0, le=10)] = 0.28
    # Greatest depth that the camera measures [m].
    max_depth: Annotated[float, Interval(gt=0, le=100)] = 4.0
    # Images per second, in simulation.
    rate: Annotated[float, Interval(gt=0, le=200)] = 30.0
    # Time from an image to its detections, in simulation [s].
    latency: Annotated[float, Interval(ge=0, le=1)] = 0.04

    def check(self) -> Iterator[tuple[str, str]]:
        """Checks that the camera has one direction, and a range.

        Yields:
            The name of a field and its problem.
        """
        if not self.max_depth > self.min_depth:
            problem = f"must exceed min_depth {self.min_depth}"
            yield "max_depth", f"{problem}, got {self.max_depth}"
        if self.look_at is None:
            return
        if self.rpy_deg is not None:
            yield "rpy_deg", "give `rpy_deg` or `look_at`, not both"
        if self.frame:
            yield "look_at", "is only for cameras in W: use `rpy_deg`"
        if np.linalg.norm(np.subtract(self.look_at, self.translation)) < 1e-3:
            yield "look_at", "must differ from the camera's position"

    @property
    def channel_name(self) -> str:
        """LCM channel of the camera's images."""
        return self.channel or f"{self.name.upper().replace(' ', '_')}_CAMERA"

    @property
    def lens(self) -> WristCameraConfig:
        """Size, field of view and range of the camera's images."""
        return WristCameraConfig(
            width=self.width,
            height=self.height,
            fov_y_deg=self.fov_y_deg,
            min_depth=self.min_depth,
            max_depth=self.max_depth,
        )

    @property
    def K(self) -> np.ndarray:
        """Intrinsic matrix of the images, shape (3, 3) [pixels]."""
        return self.lens.intrinsics().intrinsic_matrix()

    @property
    def X_FC(self) -> RigidTransform:
        """Pose of the camera in its frame, or in W if it is fixed."""
        if self.look_at is not None:
            return _looking(np.array(self.translation), np.array(self.look_at))
        angles = np.deg2rad(self.rpy_deg or [0.0] * 3)
        return RigidTransform(RollPitchYaw(angles), self.translation)

    def pose(self, robot: RobotModel) -> Callable[[np.ndarray], np.ndarray]:
        """Returns a function of the configuration q that gives the pose X_WC.

        Args:
            robot: The robot, which may carry the camera.

        Raises:
            RemoSplatError: The robot has no frame with the configured name.
        """
        if self.frame:
            field = f"cameras: {self.name}: frame"
            mount = CameraMount(robot, self.X_FC, self.frame, field=field)
            return mount.pose
        X_WC = self.X_FC.GetAsMatrix4()
        return lambda q: X_WC


def _looking(p_WC: np.ndarray, p_WT: np.ndarray) -> RigidTransform:
    """Returns the upright pose of a camera at C that points at T."""
    ahead = (p_WT - p_WC) / np.linalg.norm(p_WT - p_WC)
    right = np.cross(ahead, [0.0, 0.0, 1.0])
    if np.linalg.norm(right) < 1e-6:
        right = np.array([0.0, -1.0, 0.0])  # Straight down: x of W is up.
    right /= np.linalg.norm(right)
    axes = np.column_stack([right, np.cross(ahead, right), ahead])
    return RigidTransform(RotationMatrix(axes), p_WC)
