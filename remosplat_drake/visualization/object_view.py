"""`ObjectView`: draws the objects of a task, in the scene and in the hand."""

from collections.abc import Sequence

import numpy as np
from pydrake.common.value import Value
from pydrake.geometry import Rgba
from pydrake.math import RigidTransform
from pydrake.systems.framework import Context, DiagramBuilder, LeafSystem

from remosplat_drake.robot.payload import Payload
from remosplat_drake.robot.robot_model import RobotModel
from remosplat_drake.scene.objects.drake_shapes import drake_shape
from remosplat_drake.scene.objects.scene_object import SceneObject
from remosplat_drake.visualization.page import MeshcatPage
from remosplat_drake.visualization.robot_view import PUBLISH_PERIOD
from remosplat_drake.visualization.scene_look import ROOT

OBJECTS = f"{ROOT}/objects"


class ObjectView(LeafSystem):
    """Draws the objects of a task.

    .. pydrake_system::

        name: ObjectView
        input_ports:
        - configuration
        - report
        - objects

    `objects` takes the `SceneObject`s with their poses. An object that the
    robot carries, according to the `TickReport`, is drawn in the hand.

    Args:
        page: The page to draw on.
        robot: The robot that carries the objects.

    Attributes:
        COLOR: Colour of the objects; `web/task.js` has the same.
    """

    COLOR = Rgba(0.55, 0.35, 0.75, 0.6)

    def __init__(self, *, page: MeshcatPage, robot: RobotModel):
        super().__init__()
        self._scene, self._meshcat = page.scene, page.meshcat
        self._robot = robot
        self._drawn: dict[str, float] = {}
        self._configuration_input = self.DeclareVectorInputPort(
            "configuration", robot.n_q
        )
        self._report_input = self.DeclareAbstractInputPort(
            "report", Value[object]()
        )
        self._objects_input = self.DeclareAbstractInputPort(
            "objects", Value[object]()
        )
        self.DeclarePeriodicPublishEvent(PUBLISH_PERIOD, 0.0, self._publish)
        self.DeclareForcedPublishEvent(self._publish)

    @staticmethod
    def AddToBuilder(
        builder: DiagramBuilder, *, page: MeshcatPage, robot: RobotModel
    ) -> "ObjectView":
        """Adds a view to a diagram; the caller connects its ports."""
        view = ObjectView(page=page, robot=robot)
        return builder.AddNamedSystem("object_view", view)

    def _publish(self, context: Context):
        q = self._configuration_input.Eval(context)
        payload = self._report_input.Eval(context).payload
        objects: tuple[SceneObject, ...] = self._objects_input.Eval(context)
        for thing in at_present(objects, payload, self._robot, q):
            path = f"{OBJECTS}/{thing.name}"
            # The shape of an object changes if it slips out of a hand.
            if self._drawn.get(thing.name) != thing.reach:
                self._meshcat.SetObject(
                    path, drake_shape(thing.solid), self.COLOR
                )
                self._drawn[thing.name] = thing.reach
            self._scene.move(path, thing.X_WO, context.get_time())


def at_present(
    objects: Sequence[SceneObject],
    payload: Payload | None,
    robot: RobotModel,
    q: np.ndarray,
) -> tuple[SceneObject, ...]:
    """Returns the objects, with a carried object at its pose in the hand.

    Args:
        objects: The objects. The pose of a carried object is ignored.
        payload: The carried object; None if the robot carries none.
        robot: The robot that carries it.
        q: The configuration, shape (n_q,) [rad, m].
    """
    if payload is None:
        return tuple(objects)
    X_WL = robot.body_poses(q)[robot.tree.index(payload.link)]
    X_WO = RigidTransform(X_WL @ payload.X_LO)
    return tuple(
        each.at(X_WO) if each.name == payload.name else each for each in objects
    )
