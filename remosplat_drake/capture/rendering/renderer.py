"""Renders noise-free RGB-D images of solids off-screen, with Drake."""

from collections.abc import Callable, Iterable, Sequence

import numpy as np
from pydrake.geometry import (
    ClippingRange,
    ColorRenderCamera,
    DepthRange,
    DepthRenderCamera,
    GeometryInstance,
    LightParameter,
    MakeRenderEngineVtk,
    QueryObject,
    RenderCameraCore,
    RenderEngineVtkParams,
    SceneGraph,
)
from pydrake.math import RigidTransform
from pydrake.systems.sensors import CameraInfo

from remosplat_drake.base.system_libraries import libraries_named
from remosplat_drake.capture.capture import Capture
from remosplat_drake.capture.rendering.solid_texture import brightness
from remosplat_drake.capture.rendering.solids import Solid

FIELD_OF_VIEW = 1.0
"""Default vertical field of view of rendered captures [rad]."""

NEAR, FAR = 0.05, 10.0
"""Depths of the clipping planes [m]; nearer or farther surfaces are not
rendered.
"""

_ENGINE = "vtk"
_LIGHTS_W = (
    [0.5, 0.3, -1.0],
    [0.9, -0.3, 0.1],
    [-0.8, -0.5, 0.3],
    [-0.1, 0.5, 0.8],
)


def steady_light() -> RenderEngineVtkParams:
    """Makes lights that are fixed in W, on a black background.

    With these lights, a surface has the same colour in every view, as in a
    splat of spherical-harmonics degree 0.
    """
    lights = [
        LightParameter(frame="world", direction=direction, intensity=0.6)
        for direction in _LIGHTS_W
    ]
    return RenderEngineVtkParams(lights=lights, default_clear_color=[0, 0, 0])


class SceneRenderer:
    """Renders solids off-screen (VTK), with a given pinhole camera.

    Args:
        solids: The solids of the scene.
        width: Width of each image [pixels].
        height: Height of each image [pixels].
        fov_y: Vertical field of view [rad].
        light: Lights and background; None: those of `steady_light`.

    Attributes:
        K: Intrinsic matrix, shape (3, 3) [pixels].
    """

    def __init__(
        self,
        solids: Iterable[Solid],
        width: int,
        height: int,
        fov_y: float = FIELD_OF_VIEW,
        light: RenderEngineVtkParams | None = None,
    ):
        intrinsics = CameraInfo(width, height, fov_y)
        core = RenderCameraCore(
            _ENGINE, intrinsics, ClippingRange(NEAR, FAR), RigidTransform()
        )
        self._color_camera = ColorRenderCamera(core, False)
        self._depth_camera = DepthRenderCamera(core, DepthRange(NEAR, FAR))
        # The query object is valid as long as the scene graph and its context.
        self._scene_graph = SceneGraph()
        with libraries_named("rendering images"):
            engine = MakeRenderEngineVtk(light or steady_light())
        self._scene_graph.AddRenderer(_ENGINE, engine)
        self._register(solids)
        self._context = self._scene_graph.CreateDefaultContext()
        port = self._scene_graph.get_query_output_port()
        self._query: QueryObject = port.Eval(self._context)
        self._world = self._scene_graph.world_frame_id()
        # The renderer takes the principal point from the image's corner, as
        # `Capture` does: adding half a pixel would bend planes by millimetres.
        self.K = intrinsics.intrinsic_matrix()

    def _register(self, solids: Iterable[Solid]):
        source = self._scene_graph.RegisterSource("scene")
        for i, solid in enumerate(solids):
            instance = GeometryInstance(solid.X_WG, solid.shape, f"solid_{i}")
            instance.set_perception_properties(solid.look)
            self._scene_graph.RegisterAnchoredGeometry(source, instance)

    def depth(self, X_WC: RigidTransform) -> np.ndarray:
        """Renders depths z in C, (h, w), float32 [m]; 0 for no surface."""
        image = self._query.RenderDepthImage(
            self._depth_camera, self._world, X_WC
        )
        z = image.data[..., 0]
        return np.where(np.isfinite(z), z, np.float32(0))

    def color(self, X_WC: RigidTransform) -> np.ndarray:
        """Renders the lit sRGB colours, shape (h, w, 3), uint8."""
        image = self._query.RenderColorImage(
            self._color_camera, self._world, X_WC
        )
        return image.data[..., :3].copy()


def render_views(
    solids: Iterable[Solid],
    poses: Sequence[RigidTransform],
    width: int = 640,
    height: int = 480,
    fov_y: float = FIELD_OF_VIEW,
    on_view: Callable[[int, int], object] = lambda done, views: None,
) -> Capture:
    """Renders a capture of a scene, whose surfaces get a texture.

    Args:
        solids: The solids of the scene.
        poses: Camera poses X_WC (OpenCV axes).
        width: Width of each image [pixels].
        height: Height of each image [pixels].
        fov_y: Vertical field of view [rad].
        on_view: Called after each view with the number of rendered views and
            the number of all views.
    """
    renderer = SceneRenderer(solids, width, height, fov_y)
    X_WC = np.array([pose.GetAsMatrix4() for pose in poses])
    rgb = np.empty((len(poses), height, width, 3), np.uint8)
    depth = np.empty((len(poses), height, width), np.float32)
    for i, pose in enumerate(poses):
        depth[i] = renderer.depth(pose)
        texture = brightness(renderer.K, depth[i], X_WC[i])
        color = renderer.color(pose) * texture[..., None]
        np.clip(color, 0, 255, out=color)
        rgb[i] = color
        on_view(i + 1, len(poses))
    K = np.tile(renderer.K, (len(poses), 1, 1))
    return Capture(K=K, X_WC=X_WC, rgb=rgb, depth=depth)
