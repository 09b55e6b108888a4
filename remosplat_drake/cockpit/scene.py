"""`CockpitScene`: the scene that all viewers of the cockpit share."""

import numpy as np
import trimesh
import viser

from remosplat_drake.cockpit.messages import CockpitJob, MapPicture, PageContent
from remosplat_drake.cockpit.robot_shapes import Shapes, wxyz_position
from remosplat_drake.robot.self_collision.shapes import convex_core
from remosplat_drake.scene.objects.drake_shapes import drake_shape
from remosplat_drake.scene.objects.scene_object import SceneObject
from remosplat_drake.scene.primitive_scene import PrimitiveScene
from remosplat_drake.splat.gaussian_splat import GaussianSplat
from remosplat_drake.visualization.splat_view import opaque
from remosplat_drake.visualization.unseen_space import (
    frontier_mesh,
    merged,
    smoothed,
)

MOST_GAUSSIANS = 1_000_000
"""At most this many Gaussians are drawn. If the map has more Gaussians, the
largest are chosen."""

_AMBER, _VEIL, _SOLID = (255, 150, 30), (120, 90, 200), (150, 170, 175)
_OBJECT = (140, 89, 191)
"""Colour of objects, equal to that on the page of a run."""
_THIN = 1e-3
"""Standard deviation of a surfel along its normal, for the renderer [m]."""
_JPEG = 70
_SPLAT, _UNSEEN = "/map/splat", "/map/unseen"


class CockpitScene:
    """Draws the map, the robot and its targets for all clients.

    Args:
        server: The page's server.
        job: The settings of the cockpit.
        shapes: The meshes of the robot's links.
    """

    def __init__(
        self, server: viser.ViserServer, job: CockpitJob, shapes: Shapes
    ):
        self._server = server
        self._robot = job.robot
        self._veil: viser.MeshHandle | None = None
        self._objects: dict[str, tuple[viser.FrameHandle, float]] = {}
        self._frustum: viser.CameraFrustumHandle | None = None
        scene = server.scene
        scene.set_up_direction("+z")
        scene.configure_environment_map("city", environment_intensity=0.5)
        self._floor = scene.add_grid(
            "/floor", infinite_grid=True, cell_size=0.25, fade_distance=12.0
        )
        if job.truth is not None:
            _draw_solids(scene, job.truth)
        self._links = _draw_robot(scene, shapes)
        self._held = scene.add_icosphere(
            "/held", 0.03, color=_AMBER, visible=False
        )
        self._glow = _draw_glow(scene, shapes)
        self._targets = [
            scene.add_frame(f"/target/{k}", axes_length=0.12, axes_radius=0.005)
            for k in range(len(job.robot.effectors))
        ]

    def show_map(self, picture: MapPicture) -> None:
        """Draws another version of the map.

        Args:
            picture: The map.
        """
        scene = self._server.scene
        splat = picture.splat_W
        has_splat = splat is not None and len(splat) > 0
        if splat is not None and has_splat:
            draw_splat(scene, _SPLAT, splat)
        else:
            scene.remove_by_name(_SPLAT)
        # The grid is hidden if there is a splat, since it would be visible
        # through the splat's floor.
        self._floor.visible = not has_splat
        shown = picture.shows_unseen
        if self._veil is not None:
            shown = self._veil.visible
            self._veil.remove()
            self._veil = None
        if picture.coverage is not None:
            vertices, faces = _veil_mesh(picture)
            if len(faces):
                self._veil = scene.add_mesh_simple(
                    _UNSEEN,
                    vertices,
                    faces,
                    color=_VEIL,
                    opacity=0.18,
                    side="front",
                    cast_shadow=False,
                    receive_shadow=False,
                    visible=shown,
                )

    @property
    def shows_unseen(self) -> bool | None:
        """Whether unseen space is marked; None if the map has no boundary."""
        return None if self._veil is None else self._veil.visible

    @shows_unseen.setter
    def shows_unseen(self, shown: bool) -> None:
        if self._veil is not None:
            self._veil.visible = shown

    def show(self, content: PageContent) -> None:
        """Draws the robot and its targets at one moment.

        Args:
            content: The page's content at that moment.
        """
        X_WL = self._robot.body_poses(content.q)
        with self._server.atomic():
            for name, frame in self._links.items():
                X = X_WL[self._robot.tree.index(name)]
                frame.wxyz, frame.position = wxyz_position(X)
            X_WTs = [content.X_WT] if content.X_WTs is None else content.X_WTs
            for frame, X_WT in zip(self._targets, X_WTs, strict=False):
                frame.wxyz, frame.position = wxyz_position(X_WT)
            for thing in content.objects:
                node, reach = self._objects.get(thing.name, (None, 0.0))
                # The shape of an object changes if it slips out of a hand.
                if node is None or reach != thing.reach:
                    node = _draw_object(self._server.scene, thing)
                    self._objects[thing.name] = node, thing.reach
                X_WO = thing.X_WO.GetAsMatrix4()
                node.wxyz, node.position = wxyz_position(X_WO)
        for name, glow in self._glow.items():
            if glow.visible != (name == content.held_link):
                glow.visible = name == content.held_link
        has_place = content.p_WHeld is not None
        if content.p_WHeld is not None:
            self._held.position = content.p_WHeld
        if self._held.visible != has_place:
            self._held.visible = has_place

    def show_camera(
        self, X_WC: np.ndarray, K: np.ndarray, rgb: np.ndarray
    ) -> None:
        """Draws the wrist camera and its image.

        Args:
            X_WC: Pose of the camera (OpenCV axes), shape (4, 4).
            K: The camera's intrinsic matrix, shape (3, 3) [pixels].
            rgb: The camera's image, shape (h, w, 3), uint8.
        """
        height, width = rgb.shape[:2]
        wxyz, position = wxyz_position(X_WC)
        if self._frustum is None:
            self._frustum = self._server.scene.add_camera_frustum(
                "/camera",
                fov=2.0 * float(np.arctan2(0.5 * height, K[1, 1])),
                aspect=width / height,
                scale=0.08,
                thickness=0.002,
                color=(60, 60, 70),
                image=rgb,
                format="jpeg",
                jpeg_quality=_JPEG,
                wxyz=wxyz,
                position=position,
            )
            return
        with self._server.atomic():
            self._frustum.image = rgb
            self._frustum.wxyz, self._frustum.position = wxyz, position


def draw_splat(
    scene: viser.SceneApi, name: str, splat: GaussianSplat
) -> viser.GaussianSplatHandle:
    """Draws Gaussians, and surfels as Gaussians of a small thickness.

    Args:
        scene: The viser scene in which the Gaussians are drawn.
        name: Name of the node.
        splat: The splat, in the node's frame.
    """
    shown = opaque(splat, MOST_GAUSSIANS)
    scales = shown.scales
    if shown.is_surfel:
        thin = np.full((len(shown), 1), _THIN, np.float32)
        scales = np.hstack([scales, thin])
    R = shown.R_GK * scales[:, None, :]
    return scene.add_gaussian_splats(
        name,
        centers=shown.p_GK,
        covariances=R @ R.transpose(0, 2, 1),
        rgbs=np.clip(shown.colors, 0.0, 1.0),
        opacities=shown.opacities[:, None],
    )


def _draw_robot(
    scene: viser.SceneApi, shapes: Shapes
) -> dict[str, viser.FrameHandle]:
    """Draws the links; returns their frames, keyed by name."""
    frames = {}
    for link, meshes in shapes.coloured.items():
        frames[link] = scene.add_frame(f"/robot/{link}", show_axes=False)
        glb = trimesh.Scene(meshes).export(file_type="glb")
        scene.add_glb(f"/robot/{link}/mesh", glb)
    return frames


def _draw_glow(
    scene: viser.SceneApi, shapes: Shapes
) -> dict[str, viser.MeshHandle]:
    """Draws the highlights of held links, which are hidden at first."""
    glow = {}
    for link, mesh in shapes.joined.items():
        glow[link] = scene.add_mesh_simple(
            f"/robot/{link}/glow",
            mesh.vertices,
            mesh.faces,
            color=_AMBER,
            opacity=0.6,
            cast_shadow=False,
            visible=False,
        )
    return glow


def _draw_object(
    scene: viser.SceneApi, thing: SceneObject
) -> viser.FrameHandle:
    """Draws an object's shape; returns its frame."""
    core = convex_core(drake_shape(thing.solid))
    assert core is not None
    mesh = trimesh.convex.convex_hull(core.vertices)
    frame = scene.add_frame(f"/objects/{thing.name}", show_axes=False)
    scene.add_mesh_simple(
        f"/objects/{thing.name}/mesh",
        mesh.vertices,
        mesh.faces,
        color=_OBJECT,
        opacity=0.6,
        flat_shading=True,
        cast_shadow=False,
    )
    return frame


def _draw_solids(scene: viser.SceneApi, truth: PrimitiveScene) -> None:
    """Draws the solids of a scene that has no splat."""
    for i, box in enumerate(truth.boxes):
        wxyz, position = wxyz_position(box.X_WP.GetAsMatrix4())
        scene.add_box(
            f"/truth/box_{i}",
            color=_SOLID,
            dimensions=2.0 * box.half_extents,
            wxyz=wxyz,
            position=position,
        )
    for i, cylinder in enumerate(truth.cylinders):
        wxyz, position = wxyz_position(cylinder.X_WP.GetAsMatrix4())
        scene.add_cylinder(
            f"/truth/cylinder_{i}",
            radius=cylinder.radius,
            height=2.0 * cylinder.half_height,
            color=_SOLID,
            wxyz=wxyz,
            position=position,
        )


def _veil_mesh(picture: MapPicture) -> tuple[np.ndarray, np.ndarray]:
    """Makes the mesh of the boundary of unseen space."""
    coverage = picture.coverage
    assert coverage is not None
    corners, faces, count = [], [], 0
    for layer in range(coverage.state.shape[2]):
        vertices, triangles = frontier_mesh(coverage, layer)
        if len(triangles):
            corners.append(smoothed(vertices, coverage, layer))
            faces.append(triangles + count)
            count += len(vertices)
    if not corners:
        return np.zeros((0, 3)), np.zeros((0, 3), np.int32)
    vertices, faces = merged(np.concatenate(corners), np.concatenate(faces))
    X_WG = picture.X_WG
    return vertices @ X_WG[:3, :3].T + X_WG[:3, 3], faces
