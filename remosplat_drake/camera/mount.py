"""`CameraMount`: computes the pose of a robot's camera, and masks the robot."""

import numpy as np
from pydrake.math import RigidTransform
from pydrake.multibody.plant import MultibodyPlant

from remosplat_drake.camera.rgbd_image import RgbdImage
from remosplat_drake.camera.robot_mask import robot_mask
from remosplat_drake.capture.frames import Frame
from remosplat_drake.capture.undistortion import Distortion, undistort
from remosplat_drake.robot.model_file import add_robot_model, find_frame
from remosplat_drake.robot.robot_model import RobotModel


class CameraMount:
    """A camera C that is fixed to a frame F of a robot.

    Attributes:
        robot: The robot, whose spheres must cover all of it.
        X_FC: Hand-eye transform, the camera's pose (OpenCV axes) in F, shape
            (4, 4).
        margin: Distance by which the robot's spheres are inflated [m].
        body: Index of the body that carries the camera, in the robot's tree.
    """

    def __init__(
        self,
        robot: RobotModel,
        X_FC: RigidTransform,
        frame: str = "wrist_camera",
        margin: float = 0.02,
        field: str = "wrist_camera.frame",
    ):
        """Finds the frame in the robot's model.

        Args:
            robot: The robot that carries the camera.
            X_FC: The hand-eye transform.
            frame: Name of the frame F in the robot's model.
            margin: Distance by which the robot's spheres are inflated [m].
            field: Name of the scenario's field that contains the frame's name.
                Errors contain the name of this field.

        Raises:
            FieldError: The robot has no frame with this name.
        """
        plant = MultibodyPlant(time_step=0.0)
        add_robot_model(robot.description, plant)
        plant.Finalize()
        frame_F = find_frame(plant, frame, robot.description.name, field)
        self.robot = robot
        self.X_FC = X_FC.GetAsMatrix4()
        self.margin = margin
        self.body = robot.tree.index(frame_F.body().name())
        self._X_LF = frame_F.GetFixedPoseInBodyFrame().GetAsMatrix4()

    def pose(self, q: np.ndarray) -> np.ndarray:
        """Returns the camera's pose X_WC at configuration q, shape (4, 4)."""
        X_WL = self.robot.body_poses(q)[self.body]
        return X_WL @ self._X_LF @ self.X_FC

    def mask(
        self, q: np.ndarray, K: np.ndarray, depth: np.ndarray
    ) -> np.ndarray:
        """Finds the pixels that may show the robot itself.

        Args:
            q: The robot's configuration, shape (n_q,).
            K: Intrinsic matrix, shape (3, 3) [pixels].
            depth: Depth z in C, shape (h, w) [m]; 0 where it is unknown.

        Returns:
            Mask of the pixels that may show the robot, shape (h, w), see
            `robot_mask`.
        """
        spheres = self.robot.spheres_at(q)
        return robot_mask(spheres, K, self.pose(q), depth, self.margin)

    def frame(self, image: RgbdImage, q: np.ndarray) -> Frame:
        """Makes a frame of an image: adds its pose, and masks the robot.

        Args:
            image: The camera's image.
            q: The robot's configuration at the image's time, shape (n_q,).
        """
        rgb, depth, outside = image.rgb, image.depth, None
        if image.distortion not in (None, Distortion()):
            rgb, depth, outside = undistort(
                image.distortion, image.K, rgb, depth, None
            )
        hidden = self.mask(q, image.K, depth)
        return Frame(
            name=f"the frame at {image.time:.3f} s",
            K=image.K,
            X_WC=self.pose(q),
            rgb=rgb,
            depth=np.where(hidden, np.float32(0), depth),
            hidden=hidden if outside is None else hidden | outside,
            time=image.time,
        )
