"""`JobMaker`: makes jobs with objects, also while the robot runs."""

import dataclasses as dc
from collections.abc import Mapping, Sequence
from functools import cached_property

import numpy as np
from pydrake.math import RigidTransform

from remosplat_drake.base.errors import FieldError, RemoSplatError
from remosplat_drake.base.pose_config import PoseConfig
from remosplat_drake.controller.planning.goal_configurations import (
    goal_configurations,
)
from remosplat_drake.controller.planning.motion_planner import MotionPlanner
from remosplat_drake.controller.tick.reactive_law import ReactiveLaw
from remosplat_drake.grasping.gripper import ParallelGripper
from remosplat_drake.oracle.object_field import ObjectField, with_objects
from remosplat_drake.robot.fitting.link_spheres import LinkSpheres
from remosplat_drake.robot.payload import Payload
from remosplat_drake.robot.reach import end_effector_reach, shoulder
from remosplat_drake.robot.sphere_model import Spheres
from remosplat_drake.scene.objects.scene_object import SceneObject, find_object
from remosplat_drake.signals.aim import Aim
from remosplat_drake.signals.distance_field import DistanceField
from remosplat_drake.signals.scene_map import SceneMap
from remosplat_drake.signals.target import Target
from remosplat_drake.task import step_configs as cfg
from remosplat_drake.task.carrying import hull_pieces
from remosplat_drake.task.free_places import Surroundings, free_places
from remosplat_drake.task.grasp_search import find_grasps
from remosplat_drake.task.make_blocks import make_blocks
from remosplat_drake.task.object_finder import NewObject, ObjectFinder
from remosplat_drake.task.object_spheres import fit_object, overhang
from remosplat_drake.task.step import Block
from remosplat_drake.task.task import TaskState
from remosplat_drake.task.workshop import Workshop

_SEEDS = 30
"""Number of configurations from which the search for each pose starts."""

_ROOM = 0.008
"""At poses that the search finds, the robot's clearance exceeds the stopping
distance by at least this [m]. The controller would approach a pose at the
stopping distance only slowly."""

_BRANCH = 0.7
"""Along a line of some centimetres, a joint may change by at most this [rad,
m]. After a larger change, the arm would be folded in another way."""

_CONTACT = 0.01
"""An object stands on another object if the middle of its bottom is less than
this away from that object [m]."""


class JobMaker:
    """Makes the blocks that take an object, put it down, or let it go.

    Args:
        law: The control law for the robot without a payload.
        planner: The planner, for the robot without a payload. It searches for
            configurations.
        scene: The map without the objects.
        stopping: Distance that the robot keeps from the map [m].
        q0: The configuration at the start, shape (n_q,) [rad, m].
        max_widths: Greatest openings of the hands by end effector [m].
        is_stopped: Whether an object between the fingers stops them.
        plans: Whether the controller plans paths.
        where: File and name of the scenario, for errors.
        finder: Finds the objects that an operator points at.
        written: The steps in the scenario. If they contain a `!Pick` of an
            object, its grasps and contacts replace the search for grasps.

    Attributes:
        spheres: Spheres around the objects that the robot may carry, keyed by
            name.
        scene: The map without the objects, which may be replaced.
    """

    def __init__(
        self,
        *,
        law: ReactiveLaw,
        planner: MotionPlanner,
        scene: DistanceField,
        stopping: float,
        q0: np.ndarray,
        max_widths: Mapping[int, float],
        is_stopped: bool,
        plans: bool,
        where: str,
        finder: ObjectFinder,
        written: Sequence[cfg.AnyStep] = (),
    ):
        self.spheres: dict[str, LinkSpheres] = {}
        self._robot, self._law, self._planner = law.robot, law, planner
        self.scene, self._stopping, self._q0 = scene, stopping, q0
        self._max_widths, self._is_stopped = max_widths, is_stopped
        self._plans, self._where = plans, where
        self._finder = finder
        self._picks = [x for x in written if isinstance(x, cfg.Pick)]

    def fit(self, thing: SceneObject) -> None:
        """Fits spheres around an object that may be carried.

        Args:
            thing: The object.
        """
        if thing.name not in self.spheres:
            self.spheres[thing.name] = fit_object(thing)

    def workshop(self, objects: Sequence[SceneObject]) -> Workshop:
        """Returns the properties of robot and objects, to make steps.

        Args:
            objects: The objects at their present poses.
        """
        robot = self._robot

        def places(
            name: str,
            support: str,
            near: Sequence[float] | None,
            effector: int,
        ) -> list[RigidTransform]:
            p_WA, reach = None, np.inf
            if not robot.n_base:
                p_WA = shoulder(robot, self._q0, effector)
                reach = end_effector_reach(robot, effector)
            return free_places(
                find_object(objects, name),
                self.spheres[name],
                find_object(objects, support),
                Surroundings(
                    self._without(objects, name, support),
                    self._stopping,
                    p_WA,
                    reach,
                ),
                None if near is None else np.array(near),
            )

        return Workshop(
            robot,
            tuple(each.name for each in objects),
            {
                each.name: overhang(each, self.spheres[each.name])
                for each in objects
                if each.name in self.spheres
            },
            self._max_widths,
            self._is_stopped,
            self._where,
            self._plans,
            places,
        )

    def find(
        self,
        near: np.ndarray,
        scene: SceneMap | None,
        state: TaskState,
    ) -> NewObject:
        """Finds an object in the map; see `ObjectFinder.find`."""
        return self._finder.find(near, scene, state)

    def take(
        self, name: str, state: TaskState, q: np.ndarray, effector: int
    ) -> tuple[Block, ...]:
        """Makes the job that takes an object from its place.

        Args:
            name: The object's name.
            state: The state of the task.
            q: The configuration, shape (n_q,) [rad, m].
            effector: Index of the end effector that takes it.

        Raises:
            RemoSplatError: The hand is not empty, or there is no grasp; the
                text states the reason.
        """
        thing = state.named(name)
        _check_known(name, state)
        if state.held:
            raise RemoSplatError(
                f"the hand already holds the {state.held}; put it down first"
            )
        called = self._robot.effectors[effector]
        pick = self._written(name, effector)
        if pick is None and thing.mass is None:
            raise RemoSplatError(
                f"the mass of the {name} is unknown; state it in the scenario"
            )
        self.fit(thing)
        if pick is None:
            grasps = self._grasps(thing, state, q, effector)
            pick = cfg.Pick(effector=called, object=name, grasps=grasps)
        pick = dc.replace(pick, support=support_of(thing, state.objects))
        return self._blocks([pick], state)

    def place(
        self,
        support: str,
        state: TaskState,
        q: np.ndarray,
        rotation: np.ndarray,
        near: np.ndarray | None = None,
    ) -> tuple[Block, ...]:
        """Makes the job that puts the carried object down.

        Args:
            support: Name of the object on which it shall stand.
            state: The state of the task.
            q: The configuration, shape (n_q,) [rad, m].
            rotation: Rotation R_WO with which it stands level, shape (3, 3).
            near: Point in W near which it shall stand, shape (3,) [m]; None
                means below the hand.

        Raises:
            RemoSplatError: The hand is empty, or no free place is within
                reach; the text states the reason.
        """
        name, payload = state.held, state.payload
        if payload is None or state.X_OE is None:
            raise RemoSplatError("the hand is empty: take an object first")
        if support == name:
            raise RemoSplatError(f"the {name} cannot be put on itself")
        state.named(support)
        _check_known(support, state)
        X_WE = self._robot.end_effector_poses(q)[state.holder]
        X_WO = X_WE @ np.linalg.inv(state.X_OE)
        X_WO[:3, :3] = rotation
        level = dc.replace(state, objects=state.moved(name, X_WO))
        p_W = X_WO[:3, 3] if near is None else near
        config = cfg.Place(
            effector=self._robot.effectors[state.holder], support=support
        )
        found = self.workshop(level.objects).places(
            name, support, p_W.tolist(), state.holder
        )
        beside = self._without(state.objects, name, support)
        over = np.eye(4)
        over[2, 3] = config.lower
        for X_WP in found:
            X_WE = X_WP.GetAsMatrix4() @ state.X_OE
            ways = (over @ X_WE, beside), (X_WE, beside)
            if self._reaches(ways, q, state.holder, payload):
                config.places.append(PoseConfig(**_pose(X_WP.GetAsMatrix4())))
        if not config.places:
            raise RemoSplatError(
                f"the robot cannot reach any of {len(found)} free places on "
                f"the {support} without coming too near to itself or the scene"
            )
        return self._blocks([config], state)

    def release(self, state: TaskState) -> tuple[Block, ...]:
        """Makes the jobs that release the carried object at its present place.

        Args:
            state: The state of the task, with a carried object.

        Raises:
            RemoSplatError: The hand is empty.
        """
        called = self._robot.effectors[state.holder]
        touch = [cfg.Touch(object=state.held)]
        return self._blocks(
            [
                cfg.Release(effector=called),
                cfg.Retreat(effector=called, touch=touch),
            ],
            state,
        )

    def _blocks(
        self, configs: Sequence[cfg.AnyStep], state: TaskState
    ) -> tuple[Block, ...]:
        shop = self.workshop(state.objects)
        try:
            return make_blocks(configs, shop, *state.load)
        except FieldError as error:  # There is no field that a person wrote.
            raise RemoSplatError(error.problem) from error

    def _written(self, name: str, effector: int) -> cfg.Pick | None:
        """The scenario's step that takes an object; None if there is none."""
        names = self._robot.effectors
        for pick in self._picks:
            own = pick.effector or names[0]
            if pick.object == name and own == names[effector]:
                return pick
        return None

    @cached_property
    def _gripper(self) -> ParallelGripper:
        return ParallelGripper.of(self._robot)

    def _grasps(
        self,
        thing: SceneObject,
        state: TaskState,
        q: np.ndarray,
        effector: int,
    ) -> list[cfg.GraspConfig]:
        if self._robot.description.hand is None or effector:
            raise RemoSplatError(
                "grasps are searched for a robot's only hand; add a !Pick of"
                f" the {thing.name} with grasps to the scenario's tasks"
            )
        beside = self._without(state.objects, thing.name)
        among = self._without(state.objects)
        X_WO, back = thing.X_WO.GetAsMatrix4(), np.eye(4)
        back[2, 3] = -cfg.Pick().approach

        def reaches(X_OE: np.ndarray) -> bool:
            X_WE = X_WO @ X_OE
            return self._reaches(
                ((X_WE @ back, among), (X_WE, beside)), q, effector
            )

        p_WE = self._robot.end_effector_poses(q)[effector, :3, 3]
        found = find_grasps(
            thing,
            self._gripper,
            beside,
            self._stopping + _ROOM,
            p_WE,
            reaches,
        )
        return [
            cfg.GraspConfig(
                **_pose(each.grasp.X_OE),
                width=each.grasp.width,
                force=each.force,
            )
            for each in found
        ]

    def _without(
        self, objects: Sequence[SceneObject], *names: str
    ) -> DistanceField:
        """The map with all objects except some."""
        others = [each for each in objects if each.name not in names]
        return with_objects(self.scene, ObjectField(others))

    def _reaches(
        self,
        ways: Sequence[tuple[np.ndarray, DistanceField]],
        q: np.ndarray,
        effector: int,
        payload: Payload | None = None,
    ) -> bool:
        """Whether the robot reaches poses that short straight lines connect.

        Args:
            ways: The poses X_WE, shape (4, 4), each with the map there.
            q: The present configuration, shape (n_q,).
            effector: Index of the end effector.
            payload: The carried object; None for none.
        """
        law = self._law.holding(payload)
        planner = dc.replace(
            self._planner, robot=law.robot, self_clearance=law.self_clearance
        )
        targets = [Target(X) for X in self._robot.end_effector_poses(q)]
        for k, (X_WE, field) in enumerate(ways):
            space = planner.free_space(q, field, self._stopping + _ROOM)
            targets[effector] = Target(X_WE)
            goals = goal_configurations(
                space,
                Aim(tuple(targets)),
                np.clip(q, space.lower, space.upper),
                seeds=_SEEDS,
                most=1,
                rng=np.random.default_rng(0),
            )
            if not len(goals.q):
                return False
            if k and np.abs(goals.q[0] - q).max() > _BRANCH:
                return False
            q = goals.q[0]
        return True


def support_of(thing: SceneObject, objects: Sequence[SceneObject]) -> str:
    """Returns the name of the object on which another object stands.

    Args:
        thing: The object that stands.
        objects: All objects.

    Returns:
        The name; empty if `thing` does not stand on an object.
    """
    vertices = np.concatenate(hull_pieces(thing.solid))
    bottom = thing.X_WO.multiply(vertices.T)[2].min()
    foot = Spheres.at(np.array([[*thing.X_WO.translation()[:2], bottom]]))
    distances = {
        each.name: ObjectField([each]).clearances(foot).minimum()
        for each in objects
        if each.name != thing.name
    }
    nearest = min(distances, key=distances.__getitem__, default="")
    return nearest if distances.get(nearest, np.inf) < _CONTACT else ""


def _check_known(name: str, state: TaskState) -> None:
    """Raises an error if an object's place is not known."""
    if name in state.lost:
        raise RemoSplatError(
            f"the place of the {name} is unknown since it has slipped out of"
            " the hand"
        )


def _pose(X: np.ndarray) -> dict[str, list]:
    return {"translation": X[:3, 3].tolist(), "rotation": X[:3, :3].tolist()}
