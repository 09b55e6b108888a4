"""`WristCameraConfig`: pose and lens of the camera that the robot carries."""

import dataclasses as dc
from collections.abc import Iterator
from typing import Annotated

import numpy as np
from annotated_types import Interval
from pydrake.geometry import (
    ClippingRange,
    ColorRenderCamera,
    DepthRange,
    DepthRenderCamera,
    MakeRenderEngineVtk,
    RenderCameraCore,
    RenderEngineVtkParams,
    SceneGraph,
)
from pydrake.math import RigidTransform, RollPitchYaw
from pydrake.multibody.plant import MultibodyPlant
from pydrake.systems.framework import DiagramBuilder, OutputPort
from pydrake.systems.sensors import CameraInfo, RgbdSensor

from remosplat_drake.base.ranges import (
    Config,
    Position,
    RollPitchYawDeg,
    check_ranges,
)
from remosplat_drake.base.system_libraries import libraries_named
from remosplat_drake.robot.model_file import find_frame
from remosplat_drake.signals import station_ports as ports

_RENDERER = "vtk"
_NEAR_PLANE = 0.01


@dc.dataclass
class WristCameraConfig(Config):
    """An RGB-D camera that is fixed to the robot.

    In a simulated station, images are rendered only when the camera's ports are
    evaluated.
    """

    # Name of the robot model's frame F that carries the camera; its axes are
    # those of the image, x right, y down, z forward (OpenCV).
    frame: str = "wrist_camera"
    # Position of the camera in the frame F [m]: the translation of the
    # hand-eye transform X_FC.
    translation: Position = dc.field(default_factory=lambda: [0.0] * 3)
    # Roll, pitch and yaw of the camera in the frame F [deg]: the rotation of
    # the hand-eye transform X_FC.
    rpy_deg: RollPitchYawDeg = dc.field(default_factory=lambda: [0.0] * 3)
    # Width of the colour and the depth image [pixels].
    width: Annotated[int, Interval(ge=1, le=8192)] = 320
    # Height of the colour and the depth image [pixels].
    height: Annotated[int, Interval(ge=1, le=8192)] = 240
    # Vertical field of view [deg].
    fov_y_deg: Annotated[float, Interval(gt=0, lt=180)] = 58.0
    # Smallest depth that is measured [m]; the depth of nearer surfaces is 0.
    min_depth: Annotated[float, Interval(gt=0, le=10)] = 0.05
    # Largest depth that is measured [m]; the depth of farther surfaces is inf.
    max_depth: Annotated[float, Interval(gt=0, le=100)] = 5.0

    def check(self) -> Iterator[tuple[str, str]]:
        """Yields an error if the range of depths is empty."""
        if not self.max_depth > self.min_depth:
            yield (
                "max_depth",
                f"must exceed min_depth {self.min_depth}, got {self.max_depth}",
            )

    def hand_eye(self) -> RigidTransform:
        """Returns the hand-eye transform X_FC, the camera's pose in F."""
        return RigidTransform(
            RollPitchYaw(np.deg2rad(self.rpy_deg)), self.translation
        )

    def intrinsics(self) -> CameraInfo:
        """Returns image size and pinhole intrinsics of both images.

        `intrinsics().intrinsic_matrix()` is K, shape (3, 3) [pixels]. Drake's
        renderer measures the principal point from the image's corner, as
        `Capture` does.
        """
        return CameraInfo(self.width, self.height, np.deg2rad(self.fov_y_deg))

    def sees(self, X_WC: np.ndarray, p_W: np.ndarray) -> bool:
        """Returns whether a point is in the image, ignoring occlusion.

        Args:
            X_WC: The camera's pose, shape (4, 4).
            p_W: The point in W, shape (3,) [m].
        """
        x, y, z = X_WC[:3, :3].T @ (p_W - X_WC[:3, 3])
        if not self.min_depth <= z <= self.max_depth:
            return False
        lens = self.intrinsics()
        u = lens.focal_x() * x / z + lens.center_x()
        v = lens.focal_y() * y / z + lens.center_y()
        return 0 <= u < self.width and 0 <= v < self.height

    def AddToStation(
        self,
        builder: DiagramBuilder,
        plant: MultibodyPlant,
        scene_graph: SceneGraph,
    ) -> dict[str, OutputPort]:
        """Adds the simulated camera to a station's diagram.

        Args:
            builder: Builder of the station.
            plant: The finalized plant with the robot.
            scene_graph: The geometry that is rendered.

        Returns:
            The camera's output ports, by their names in
            `signals.station_ports`.

        Raises:
            RemoSplatError: A setting is invalid, or the robot has no frame of
                the given name.
        """
        check_ranges(self, field="wrist_camera")
        frame_F = find_frame(
            plant, self.frame, type(self).__name__, "wrist_camera.frame"
        )
        if not scene_graph.HasRenderer(_RENDERER):
            with libraries_named("a simulated wrist camera"):
                engine = MakeRenderEngineVtk(RenderEngineVtkParams())
            scene_graph.AddRenderer(_RENDERER, engine)
        core = RenderCameraCore(
            _RENDERER,
            self.intrinsics(),
            ClippingRange(_NEAR_PLANE, self.max_depth + 1.0),
            RigidTransform(),
        )
        camera = builder.AddNamedSystem(
            "wrist_camera",
            RgbdSensor(
                plant.GetBodyFrameIdOrThrow(frame_F.body().index()),
                frame_F.GetFixedPoseInBodyFrame() @ self.hand_eye(),
                ColorRenderCamera(core, False),
                DepthRenderCamera(
                    core, DepthRange(self.min_depth, self.max_depth)
                ),
            ),
        )
        builder.Connect(
            scene_graph.get_query_output_port(),
            camera.query_object_input_port(),
        )
        return {
            ports.WRIST_CAMERA_RGB: camera.color_image_output_port(),
            ports.WRIST_CAMERA_DEPTH: camera.depth_image_32F_output_port(),
        }
