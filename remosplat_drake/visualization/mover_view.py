"""`MoverView`: what moves, whither, and the room that it may need."""

import numpy as np
from pydrake.common.value import Value
from pydrake.geometry import Box, Capsule, Rgba, Shape, Sphere
from pydrake.math import RigidTransform
from pydrake.systems.framework import Context, DiagramBuilder, LeafSystem

from remosplat_drake.scene.mover import Mover, Movers
from remosplat_drake.visualization.page import ROOT, MeshcatPage
from remosplat_drake.visualization.robot_view import PUBLISH_PERIOD

MOVERS = f"{ROOT}/movers"

AHEAD = 0.3
"""How far ahead a mover is foreseen on the page [s]."""

_COLOR = Rgba(0.93, 0.45, 0.13, 1.0)
_GHOST = Rgba(0.93, 0.45, 0.13, 0.4)
_ROOM = Rgba(0.93, 0.45, 0.13, 0.12)


class MoverView(LeafSystem):
    """Draws movers, where they will be in a moment, and where they can be.

    .. pydrake_system::

        name: MoverView
        input_ports:
        - movers

    A mover is orange. Its ghost is where it will be in `AHEAD` if it goes on
    as it does, and a pale ball around that holds wherever it can be then.

    Args:
        page: The page to draw on.
    """

    def __init__(self, *, page: MeshcatPage):
        LeafSystem.__init__(self)
        self._meshcat = page.meshcat
        self._drawn: dict[str, float] = {}
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
            self._meshcat.Delete(gone)
            del self._drawn[gone]
        for path, mover in zip(names, movers, strict=True):
            self._draw(path, mover, context.get_time())

    def _draw(self, path: str, mover: Mover, time: float):
        meshcat = self._meshcat
        if path not in self._drawn:
            meshcat.SetObject(f"{path}/body", shape_of(mover), _COLOR)
            meshcat.SetObject(f"{path}/ghost", shape_of(mover), _GHOST)
            meshcat.SetProperty(f"{path}/ghost/<object>", "castShadow", False)
        room = room_of(mover, AHEAD)
        # A ball is only sent again where its size has changed to see.
        if abs(room - self._drawn.get(path, np.inf)) > 0.01:
            meshcat.SetObject(f"{path}/room", Sphere(room), _ROOM)
            meshcat.SetProperty(f"{path}/room/<object>", "castShadow", False)
            self._drawn[path] = room
        meshcat.SetTransform(f"{path}/body", mover.X_WM, time_in_recording=time)
        then = mover.after(AHEAD)
        meshcat.SetTransform(f"{path}/ghost", then, time_in_recording=time)
        center = RigidTransform(then.translation())
        meshcat.SetTransform(f"{path}/room", center, time_in_recording=time)


def shape_of(mover: Mover) -> Shape:
    """Returns a shape that looks like a mover: rounded edges become sharp.

    Args:
        mover: A sphere, a capsule along z, or a box.
    """
    x, y, z = mover.half_extents
    if x == y == z == 0.0:
        return Sphere(mover.radius)
    if x == y == 0.0:
        return Capsule(mover.radius, 2.0 * z)
    return Box(*(2.0 * (mover.half_extents + mover.radius)))


def room_of(mover: Mover, ahead: float) -> float:
    """Returns the radius of a ball that holds wherever a mover can be [m].

    Args:
        mover: The mover.
        ahead: How far ahead one looks [s].
    """
    far = float(np.linalg.norm(mover.half_extents)) + mover.radius
    soon = mover.velocity_error * ahead
    soon += 0.5 * mover.max_acceleration * ahead**2
    late = (mover.max_speed + float(np.linalg.norm(mover.v_WM))) * ahead
    return far + mover.position_error + min(soon, late)
