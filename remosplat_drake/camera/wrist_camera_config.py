"""`WristCameraConfig`: the camera that the robot carries, also simulated."""

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

from remosplat_drake.base.errors import RemoSplatError
from remosplat_drake.base.ranges import (
    Config,
    Position,
    RollPitchYawDeg,
    check_ranges,
)
from remosplat_drake.base.system_libraries import libraries_named
from remosplat_drake.signals import station_ports as ports

_RENDERER = "vtk"
_NEAR_PLANE = 0.01


@dc.dataclass
class WristCameraConfig(Config):
    """An RGB-D camera fixed to the robot; it renders only when asked."""

    # Frame of the robot model, with axes x right, y down, z forward.
    frame: str = "wrist_camera"
    # Hand-eye calibration: the camera in that frame [m], [deg].
    translation: Position = dc.field(default_factory=lambda: [0.0] * 3)
    rpy_deg: RollPitchYawDeg = dc.field(default_factory=lambda: [0.0] * 3)
    # Image size [pixel].
    width: Annotated[int, Interval(ge=1, le=8192)] = 320
    height: Annotated[int, Interval(ge=1, le=8192)] = 240
    # Vertical field of view [deg].
    fov_y_deg: Annotated[float, Interval(gt=0, lt=180)] = 58.0
    # Depths outside are reported as 0 (too close) and inf (too far) [m].
    min_depth: Annotated[float, Interval(gt=0, le=10)] = 0.05
    max_depth: Annotated[float, Interval(gt=0, le=100)] = 5.0

    def check(self) -> Iterator[tuple[str, str]]:
        """See `Config`."""
        if not self.max_depth > self.min_depth:
            yield (
                "max_depth",
                f"must exceed min_depth {self.min_depth}, got {self.max_depth}",
            )

    def AddToStation(
        self,
        builder: DiagramBuilder,
        plant: MultibodyPlant,
        scene_graph: SceneGraph,
    ) -> dict[str, OutputPort]:
        """Adds the simulated camera to a station; see `StationCamera`.

        Raises:
            RemoSplatError: A setting is unusable.
        """
        check_ranges(self, field="wrist_camera")
        if not plant.HasFrameNamed(self.frame):
            raise RemoSplatError(
                f"wrist_camera.frame: the robot has no frame {self.frame!r}"
            )
        frame_F = plant.GetFrameByName(self.frame)
        X_FC = RigidTransform(
            RollPitchYaw(np.deg2rad(self.rpy_deg)), self.translation
        )
        if not scene_graph.HasRenderer(_RENDERER):
            with libraries_named("a simulated wrist camera"):
                engine = MakeRenderEngineVtk(RenderEngineVtkParams())
            scene_graph.AddRenderer(_RENDERER, engine)
        core = RenderCameraCore(
            _RENDERER,
            CameraInfo(self.width, self.height, np.deg2rad(self.fov_y_deg)),
            ClippingRange(_NEAR_PLANE, self.max_depth + 1.0),
            RigidTransform(),
        )
        camera = builder.AddNamedSystem(
            "wrist_camera",
            RgbdSensor(
                plant.GetBodyFrameIdOrThrow(frame_F.body().index()),
                frame_F.GetFixedPoseInBodyFrame() @ X_FC,
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
