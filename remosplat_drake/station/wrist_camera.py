"""The simulated wrist camera: an `RgbdSensor` that renders when asked."""

import numpy as np
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

from remosplat_drake.errors import RemoSplatError
from remosplat_drake.ranges import check_ranges
from remosplat_drake.station import ports
from remosplat_drake.station.config import WristCameraConfig
from remosplat_drake.system_libraries import libraries_named

_RENDERER = "vtk"
_NEAR_PLANE = 0.01


def add_wrist_camera(
    builder: DiagramBuilder,
    plant: MultibodyPlant,
    scene_graph: SceneGraph,
    config: WristCameraConfig,
) -> dict[str, OutputPort]:
    """Adds the camera to a station and connects it to the scene graph.

    Args:
        builder: Builder of the station.
        plant: The finalized plant that poses the geometry.
        scene_graph: What is rendered.
        config: Where the camera is and what it can see.

    Returns:
        The camera's ports, by the station's names.

    Raises:
        RemoSplatError: A setting is unusable.
    """
    check_ranges(config, field="wrist_camera")
    if not plant.HasFrameNamed(config.frame):
        raise RemoSplatError(
            f"wrist_camera.frame: the robot has no frame {config.frame!r}"
        )
    frame_F = plant.GetFrameByName(config.frame)
    X_FC = RigidTransform(
        RollPitchYaw(np.deg2rad(config.rpy_deg)), config.translation
    )
    if not scene_graph.HasRenderer(_RENDERER):
        with libraries_named("a simulated wrist camera"):
            engine = MakeRenderEngineVtk(RenderEngineVtkParams())
        scene_graph.AddRenderer(_RENDERER, engine)
    core = RenderCameraCore(
        _RENDERER,
        CameraInfo(config.width, config.height, np.deg2rad(config.fov_y_deg)),
        ClippingRange(_NEAR_PLANE, config.max_depth + 1.0),
        RigidTransform(),
    )
    camera = builder.AddNamedSystem(
        "wrist_camera",
        RgbdSensor(
            plant.GetBodyFrameIdOrThrow(frame_F.body().index()),
            frame_F.GetFixedPoseInBodyFrame() @ X_FC,
            ColorRenderCamera(core, False),
            DepthRenderCamera(
                core, DepthRange(config.min_depth, config.max_depth)
            ),
        ),
    )
    builder.Connect(
        scene_graph.get_query_output_port(), camera.query_object_input_port()
    )
    return {
        ports.WRIST_CAMERA_RGB: camera.color_image_output_port(),
        ports.WRIST_CAMERA_DEPTH: camera.depth_image_32F_output_port(),
    }
