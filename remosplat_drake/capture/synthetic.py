"""RGB-D captures of primitive scenes, rendered with Drake.

The depth is exact, so what a splat trained on such a capture gets wrong is
the reconstruction's doing: the primitives are its ground truth.
"""

import colorsys

import numpy as np
import pydrake.geometry as drake_geometry
from pydrake.geometry import (
    ClippingRange,
    ColorRenderCamera,
    DepthRange,
    DepthRenderCamera,
    GeometryInstance,
    LightParameter,
    MakeRenderEngineVtk,
    PerceptionProperties,
    QueryObject,
    RenderCameraCore,
    RenderEngineVtkParams,
    Rgba,
    SceneGraph,
)
from pydrake.math import RigidTransform, RotationMatrix
from pydrake.systems.sensors import CameraInfo

from remosplat_drake.capture.capture import Capture, back_project
from remosplat_drake.errors import RemoSplatError
from remosplat_drake.oracle.signed_distance import SignedDistanceField
from remosplat_drake.robot.sphere_model import Spheres
from remosplat_drake.scene.primitive_scene import (
    Box,
    Cylinder,
    PrimitiveScene,
)

_RENDERER = "vtk"
_NEAR, _FAR = 0.05, 10.0
_CANDIDATES = 12
_LIGHTS_W = (
    [0.5, 0.3, -1.0],
    [0.9, -0.3, 0.1],
    [-0.8, -0.5, 0.3],
    [-0.1, 0.5, 0.8],
)
"""Directions in which light falls. Lights fixed in W give a surface the same
colour in every view, as a splat of degree 0 needs it."""


def render_capture(
    scene: PrimitiveScene,
    poses: list[RigidTransform],
    width: int = 640,
    height: int = 480,
    fov_y: float = 1.0,
) -> Capture:
    """Renders a scene from camera poses X_WC (OpenCV axes).

    Args:
        scene: The scene; each primitive gets a colour of its own.
        poses: The camera poses.
        width: Of each image [pixels].
        height: Of each image [pixels].
        fov_y: Vertical field of view [rad].
    """
    intrinsics = CameraInfo(width, height, fov_y)
    core = RenderCameraCore(
        _RENDERER, intrinsics, ClippingRange(_NEAR, _FAR), RigidTransform()
    )
    color_camera = ColorRenderCamera(core, False)
    depth_camera = DepthRenderCamera(core, DepthRange(_NEAR, _FAR))
    # The query object lives only as long as the scene graph and its context.
    scene_graph = _make_scene_graph(scene)
    context = scene_graph.CreateDefaultContext()
    query: QueryObject = scene_graph.get_query_output_port().Eval(context)
    world = scene_graph.world_frame_id()
    # The renderer takes the principal point from the image's corner, as
    # `Capture` does: adding half a pixel would bend planes by millimetres.
    K = intrinsics.intrinsic_matrix()
    X_WC = np.array([pose.GetAsMatrix4() for pose in poses])
    rgb = np.empty((len(poses), height, width, 3), np.uint8)
    depth = np.empty((len(poses), height, width), np.float32)
    for i, pose in enumerate(poses):
        z = query.RenderDepthImage(depth_camera, world, pose).data[..., 0]
        depth[i] = np.where(np.isfinite(z), z, 0)
        color = query.RenderColorImage(color_camera, world, pose).data[..., :3]
        texture = _solid_texture(back_project(K, depth[i], X_WC[i]))
        rgb[i] = np.clip(color * texture[..., None], 0, 255)
    K = np.tile(K, (len(poses), 1, 1))
    return Capture(K=K, X_WC=X_WC, rgb=rgb, depth=depth)


def survey_poses(
    scene: PrimitiveScene,
    n: int = 120,
    seed: int = 0,
    clearance: float = 0.12,
) -> list[RigidTransform]:
    """Camera poses X_WC that see a scene around its target from all sides.

    A quarter looks on from afar. The others each face a surface point near
    the target, below table tops and inside shelves too, and keep away from
    each other (Mitchell's best-candidate sampling).

    Args:
        scene: A scene with a target.
        n: Number of poses.
        seed: Of the random choice.
        clearance: No camera is nearer than this to a solid [m].

    Raises:
        RemoSplatError: The scene has no target.
    """
    if scene.X_WE_target is None:
        raise RemoSplatError(f"{scene.name} has no target to look at")
    focus = scene.X_WE_target.translation()
    field = SignedDistanceField(scene)
    rng = np.random.default_rng(seed)
    poses: list[RigidTransform] = []
    while len(poses) < n:
        draw = _draw_far if len(poses) < n // 4 else _draw_near
        views = [draw(focus, field, rng) for _ in range(_CANDIDATES)]
        p_WC = np.array([view[0] for view in views])
        free = field.clearances(Spheres.at(p_WC)).per_sphere(_CANDIDATES)
        placed = np.array([pose.translation() for pose in poses])
        apart = np.linalg.norm(p_WC[:, None] - placed.reshape(1, -1, 3), axis=2)
        score = np.where(free > clearance, apart.min(axis=1, initial=9), -1)
        if score.max() > 0:
            poses.append(look_at(*views[int(score.argmax())]))
    return poses


def _draw_far(
    focus: np.ndarray, field: SignedDistanceField, rng: np.random.Generator
) -> tuple[np.ndarray, np.ndarray]:
    """A camera centre around the scene, and the point it looks at."""
    azimuth = rng.uniform(-np.pi, np.pi)
    side = np.array([np.cos(azimuth), np.sin(azimuth)])
    xy = focus[:2] + rng.uniform(1.3, 2.0) * side
    return np.array([*xy, rng.uniform(0.4, 2.0)]), focus + rng.normal(0, 0.3, 3)


def _draw_near(
    focus: np.ndarray, field: SignedDistanceField, rng: np.random.Generator
) -> tuple[np.ndarray, np.ndarray]:
    """A camera centre some way off a surface point, and that point."""
    start = focus + rng.uniform(-1, 1, 3) * [0.8, 0.9, 0.7]
    surface = field.clearances(Spheres.at(start))
    back = rng.uniform(0.35, 0.7) * surface.direction_W[0]
    p_WT = surface.p_WC[0]
    return p_WT - back + rng.normal(0, 0.2, 3), p_WT


def look_at(p_WC: np.ndarray, p_WT: np.ndarray) -> RigidTransform:
    """The upright camera pose X_WC at p_WC that looks at the point T."""
    z_W = (p_WT - p_WC) / np.linalg.norm(p_WT - p_WC)
    x_W = np.cross(z_W, [0, 0, 1])
    if np.linalg.norm(x_W) < 1e-6:
        x_W = np.array([1.0, 0, 0])
    x_W = x_W / np.linalg.norm(x_W)
    R_WC = np.column_stack([x_W, np.cross(z_W, x_W), z_W])
    return RigidTransform(RotationMatrix(R_WC), p_WC)


def _make_scene_graph(scene: PrimitiveScene) -> SceneGraph:
    lights = [
        LightParameter(frame="world", direction=direction, intensity=0.6)
        for direction in _LIGHTS_W
    ]
    params = RenderEngineVtkParams(lights=lights, default_clear_color=[0, 0, 0])
    scene_graph = SceneGraph()
    scene_graph.AddRenderer(_RENDERER, MakeRenderEngineVtk(params))
    source = scene_graph.RegisterSource(scene.name)
    for i, primitive in enumerate(scene.primitives):
        shape = (
            drake_geometry.Box(*(2 * primitive.half_extents))
            if isinstance(primitive, Box)
            else drake_geometry.Cylinder(
                primitive.radius, 2 * primitive.half_height
            )
        )
        instance = GeometryInstance(primitive.X_WP, shape, f"primitive_{i}")
        instance.set_perception_properties(_properties(primitive, i))
        scene_graph.RegisterAnchoredGeometry(source, instance)
    return scene_graph


def _shape(primitive: Box | Cylinder) -> drake_geometry.Shape:
    if isinstance(primitive, Box):
        return drake_geometry.Box(*(2 * primitive.half_extents))
    return drake_geometry.Cylinder(primitive.radius, 2 * primitive.half_height)


def _properties(primitive: Box | Cylinder, index: int) -> PerceptionProperties:
    """Boxes like wood, cylinders in hues a golden ratio apart."""
    turn = (0.618034 * index) % 1.0
    hsv = (
        (0.07 + 0.04 * turn, 0.2 + 0.3 * turn, 0.9)
        if isinstance(primitive, Box)
        else (turn, 0.55, 0.85)
    )
    properties = PerceptionProperties()
    diffuse = Rgba(*colorsys.hsv_to_rgb(*hsv), 1.0)
    properties.AddProperty("phong", "diffuse", diffuse)
    return properties


def _solid_texture(p_W: np.ndarray) -> np.ndarray:
    """A brightness that varies through space, (h, w, 3) -> (h, w).

    Being a function of the world point it looks alike from everywhere, and
    gives bare primitives something to align.
    """
    waves = np.random.default_rng(0).normal(size=(8, 3))
    waves *= np.geomspace(8, 90, len(waves))[:, None] / np.linalg.norm(
        waves, axis=1, keepdims=True
    )
    ripple = np.sin(np.nan_to_num(p_W) @ waves.T).mean(axis=-1)
    return 0.85 + 0.4 * ripple
