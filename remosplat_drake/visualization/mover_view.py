"""`MoverView`: draws moving obstacles (movers), predictions, and cameras."""

import numpy as np
from pydrake.common.value import Value
from pydrake.geometry import Rgba, Sphere
from pydrake.math import RigidTransform
from pydrake.systems.framework import Context, DiagramBuilder, LeafSystem

from remosplat_drake.scene.mover import Mover, Movers
from remosplat_drake.scene.mover_camera import MoverCamera
from remosplat_drake.scene.mover_shape import shape_of
from remosplat_drake.visualization.page import MeshcatPage
from remosplat_drake.visualization.robot_view import PUBLISH_PERIOD
from remosplat_drake.visualization.scene_look import ROOT

MOVERS = f"{ROOT}/movers"

AHEAD = 0.3
"""Time ahead for which the page shows the predicted position of a mover [s]."""

CAMERAS = f"{ROOT}/mover_cameras"

_LENGTH = 0.25
"""Depth up to which the pyramid of a camera's view is drawn [m]."""

_GRAIN = 0.02
"""The ball around a mover's possible positions is sent to browsers again only
if its radius has changed by more than this [m]."""

_SEES = Rgba(0.15, 0.45, 0.85, 1.0)
_BLIND = Rgba(0.85, 0.1, 0.1, 1.0)
_COLOR = Rgba(0.93, 0.45, 0.13, 1.0)
_GHOST = Rgba(0.93, 0.45, 0.13, 0.4)
_ROOM = Rgba(0.93, 0.45, 0.13, 0.12)


class MoverView(LeafSystem):
    """Draws moving obstacles (movers), their predicted and possible positions.

    .. pydrake_system::

        name: MoverView
        input_ports:
        - movers

    A mover is orange. A ghost shows its position after the time `AHEAD` if its
    velocity does not change. A pale ball around the ghost contains all of its
    possible positions at that time. A camera that detects movers is a blue
    pyramid, which is red while the camera sends no usable image.

    Args:
        page: The page to draw on.
    """

    def __init__(self, *, page: MeshcatPage):
        LeafSystem.__init__(self)
        self._scene, self._meshcat = page.scene, page.meshcat
        self._drawn: dict[str, np.ndarray] = {}
        self._cameras: dict[str, tuple] = {}
        self._movers_input = self.DeclareAbstractInputPort(
            "movers", Value[object]()
        )
        self.DeclarePeriodicPublishEvent(PUBLISH_PERIOD, 0.0, self._publish)
        self.DeclareForcedPublishEvent(self._publish)

    @staticmethod
    def AddToBuilder(
        builder: DiagramBuilder, *, page: MeshcatPage
    ) -> "MoverView":
        """Adds a view to a diagram; the caller connects its port."""
        return builder.AddNamedSystem("mover_view", MoverView(page=page))

    def _publish(self, context: Context):
        movers: Movers = self._movers_input.Eval(context)
        names = [f"{MOVERS}/{i}_{m.name}" for i, m in enumerate(movers)]
        for gone in set(self._drawn) - set(names):
            self._scene.delete(gone)
            del self._drawn[gone]
        for path, mover in zip(names, movers, strict=True):
            self._draw(path, mover, context.get_time())
        for camera in movers.cameras:
            self._draw_camera(camera)

    def _draw(self, path: str, mover: Mover, time: float):
        meshcat = self._meshcat
        room = room_of(mover, AHEAD)
        size = np.array([*mover.half_extents, mover.radius, room])
        drawn = self._drawn.get(path, np.full(5, np.inf))
        changed = np.abs(size - drawn) > _GRAIN
        if changed[:4].any():
            meshcat.SetObject(f"{path}/body", shape_of(mover), _COLOR)
            meshcat.SetObject(f"{path}/ghost", shape_of(mover), _GHOST)
            meshcat.SetProperty(f"{path}/ghost/<object>", "castShadow", False)
        if changed.any():
            meshcat.SetObject(f"{path}/room", Sphere(room), _ROOM)
            meshcat.SetProperty(f"{path}/room/<object>", "castShadow", False)
            self._drawn[path] = size
        self._scene.move(f"{path}/body", mover.X_WM, time)
        then = mover.after(AHEAD)
        self._scene.move(f"{path}/ghost", then, time)
        center = RigidTransform(then.translation())
        self._scene.move(f"{path}/room", center, time)

    def _draw_camera(self, camera: MoverCamera):
        pose = camera.X_WC.GetAsMatrix4().round(3).tobytes()
        drawn = (pose, bool(camera.problem))
        if self._cameras.get(camera.name) == drawn:
            return
        self._cameras[camera.name] = drawn
        start, end = pyramid(camera, _LENGTH)
        color = _BLIND if camera.problem else _SEES
        path = f"{CAMERAS}/{camera.name}"
        self._meshcat.SetLineSegments(path, start, end, 2.0, color)


def pyramid(
    camera: MoverCamera, length: float
) -> tuple[np.ndarray, np.ndarray]:
    """Returns the edges of the pyramid of a camera's view, in W.

    Args:
        camera: The camera.
        length: Depth up to which the pyramid is drawn [m].

    Returns:
        Starts and ends of eight segments, shape (3, 8) each [m].
    """
    (left, top), (right, bottom) = camera.least_tangent, camera.greatest_tangent
    corners = [(left, top), (right, top), (right, bottom), (left, bottom)]
    corners_C = length * np.array([(x, y, 1.0) for x, y in corners]).T
    corners_W = camera.X_WC.multiply(corners_C)
    tip = np.tile(camera.X_WC.translation()[:, None], 4)
    next_W = np.roll(corners_W, -1, axis=1)
    return np.hstack([tip, corners_W]), np.hstack([corners_W, next_W])


def room_of(mover: Mover, ahead: float) -> float:
    """Returns the radius of a ball that contains a mover at a later time [m].

    The ball is centred at the mover's predicted position.

    Args:
        mover: The mover.
        ahead: Time from now to the predicted position [s].
    """
    far = float(np.linalg.norm(mover.half_extents)) + mover.radius
    soon = mover.velocity_error * ahead
    soon += 0.5 * mover.max_acceleration * ahead**2
    late = (mover.max_speed + float(np.linalg.norm(mover.v_WM))) * ahead
    return far + mover.position_error + min(soon, late)
