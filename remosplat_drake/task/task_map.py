"""`TaskMap`: the map of a task; `StandingRule`: a check before each step."""

import dataclasses as dc
from collections.abc import Sequence

import numpy as np

from remosplat_drake.controller.tick.reactive_law import ReactiveLaw
from remosplat_drake.oracle.contact_rules import ContactRule, reliefs
from remosplat_drake.oracle.object_field import ObjectField, with_objects
from remosplat_drake.robot.payload import Payload
from remosplat_drake.robot.robot_model import RobotModel
from remosplat_drake.scene.objects.placed_object import PlacedObject
from remosplat_drake.scene.objects.scene_object import SceneObject
from remosplat_drake.signals.distance_field import DistanceField
from remosplat_drake.task.advance_task import with_held_object
from remosplat_drake.task.task import TaskState

_MARGIN = 0.004
"""A step may begin if distances are at most this much below the stopping
distance [m]. The value is less than the supervisor's tolerance."""


class TaskMap:
    """The map of a task: the scene, and the objects that stand in it.

    Args:
        robot: The robot, without a payload.
        scene: The map without the objects.
        stopping: The smallest stopping distance in use [m].

    Attributes:
        scene: The map without the objects, which a live map replaces.
    """

    def __init__(
        self, robot: RobotModel, scene: DistanceField, stopping: float
    ):
        self.stopping = stopping
        self._robot, self.scene = robot, scene
        self._latest: tuple[tuple, DistanceField] | None = None

    def field(
        self, state: TaskState, scene: DistanceField | None = None
    ) -> DistanceField:
        """Returns the map with the contact rules of a state of the task.

        Args:
            state: The progress of the task.
            scene: The map without the objects; None for `self.scene`.
        """
        scene = scene or self.scene
        key = scene, state.in_map, state.rules, state.payload
        if self._latest is None or self._latest[0] != key:
            self._latest = key, self._made(*key)
        return self._latest[1]

    def _made(
        self,
        scene: DistanceField,
        objects: Sequence[SceneObject],
        rules: Sequence[ContactRule],
        payload: Payload | None,
    ) -> DistanceField:
        links = self._robot.holding(payload).spheres.links
        names = [each.name for each in objects]
        relief = reliefs(rules, links, names, self.stopping)
        return with_objects(scene, ObjectField(objects, relief))


@dc.dataclass(frozen=True, eq=False)
class MapAround:
    """The map and the objects around a robot in a task; a `TaskSurroundings`.

    A deep copy is the object itself.

    Attributes:
        map: The map of the task.
        robot: The robot, without a payload.
        state: The progress of the task.
    """

    map: TaskMap
    robot: RobotModel
    state: TaskState

    def __deepcopy__(self, memo) -> "MapAround":
        return self

    @property
    def payload(self) -> Payload | None:
        """The carried object; None if the robot carries no object."""
        return self.state.payload

    def field(self, scene: DistanceField) -> DistanceField:
        """Returns a map with the objects and the contact rules.

        Args:
            scene: The map without the objects.
        """
        return self.map.field(self.state, scene)

    def placed(self, q: np.ndarray) -> tuple[PlacedObject, ...]:
        """Returns the objects whose poses are known.

        Args:
            q: The configuration, shape (n_q,) [rad, m].
        """
        state = with_held_object(self.state, self.robot.end_effector_poses(q))
        return tuple(
            PlacedObject(
                each.name, each.X_WO.GetAsMatrix4(), each.name != state.held
            )
            for each in state.objects
            if each.name not in state.lost
        )


class StandingRule:
    """Checks the distances of a robot at rest before a step begins.

    A step may begin if all distances, with its payload and contact rules, are
    at least the stopping distance, or at least as large as before the step. If
    the step takes or puts down an object, it suffices that the distances are
    positive, since the object stands on a surface.

    Args:
        law: The control law for the robot without a payload.
        map: The map of the task.
    """

    def __init__(self, law: ReactiveLaw, map: TaskMap):
        self._law, self._map = law, map

    def __call__(
        self, before: TaskState, after: TaskState, q: np.ndarray
    ) -> str:
        """Returns the reason why a step must not begin at q; "" if it may.

        Args:
            before: The state of the task before the step.
            after: The state of the task when the step has begun.
            q: The configuration, shape (n_q,) [rad, m].
        """
        least = self._map.stopping - _MARGIN
        if before.held != after.held:
            least = 0.0
        room, said = self._room(after, q)
        if room >= least or room >= self._room(before, q)[0]:
            return ""
        return said

    def _room(self, state: TaskState, q: np.ndarray) -> tuple[float, str]:
        """The least clearance [m], and a sentence that names its pair."""
        law, field = self._law.holding(state.payload), self._map.field(state)
        robot = law.robot
        rows = field.clearances(robot.spheres_at(q), law.collision.influence)
        if not rows.is_known:
            return -np.inf, "distances are not known"
        own = np.inf
        if law.self_clearance is not None:
            own = law.self_clearance.distances(q).min(initial=np.inf)
        if own < 0.0:
            return float(own), "the robot would touch itself"
        if not len(rows):
            return np.inf, ""
        row = int(rows.distance.argmin())
        link = robot.spheres.links[rows.sphere[row]]
        thing = field.thing_at(rows.p_WC[row]).name
        lacking = 1e3 * (self._map.stopping - rows.distance[row])
        return float(rows.distance[row]), (
            f"{robot.description.called(link)} is {lacking:.0f} mm too near to"
            f" {thing}"
        )
