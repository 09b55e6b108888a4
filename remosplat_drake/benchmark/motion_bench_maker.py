"""Loads MotionBenchMaker's problems: scenes, starts and goals of an arm.

A family of problems is a folder of pairs of files, `sceneNNNN.yaml` and
`requestNNNN.yaml` (Chamzas et al., "MotionBenchMaker", RA-L 2022). The scene is
placed around the arm's mount. The request contains a goal configuration. The
task here is to reach the pose of the end effector at that configuration, with
any configuration.

In many problems the hand encloses an object at the goal, to grasp it. In one
suite, the scene does not contain this object. In a second suite, only the hand
may touch it. In a third suite, the robot then carries it to the pose of the
hand at the start.
"""

import dataclasses as dc
import hashlib
from functools import lru_cache
from pathlib import Path

import numpy as np
from pydrake.math import RigidTransform

from remosplat_drake.base.errors import FieldError, FileError
from remosplat_drake.base.foreign_yaml import ForeignValue
from remosplat_drake.base.reading import reads_file
from remosplat_drake.benchmark.reaching_task import ReachingTask, solid_task
from remosplat_drake.benchmark.scene_case import SceneCase
from remosplat_drake.generation.scene_families import draw_start
from remosplat_drake.oracle.signed_distance import SignedDistanceField
from remosplat_drake.robot.robot_description import load_robot_description
from remosplat_drake.robot.robot_model import RobotModel, load_robot
from remosplat_drake.scene.objects.scene_object import SceneObject
from remosplat_drake.scene.objects.solid_distances import SolidDistances
from remosplat_drake.scene.planning_scene import read_planning_scene
from remosplat_drake.scene.primitive_scene import Box, Cylinder, PrimitiveScene

SUITE = "MotionBenchMaker"
"""Name of the suite whose scenes do not contain the object to be grasped. In
titles, the name of the robot follows."""

GRASP_SUITE = f"{SUITE} with the object"
"""Name of the suite whose scenes contain the object to be grasped."""

CARRY_SUITE = f"{SUITE} with the object, carried back"
"""Name of the suite in which the robot carries the object to the start's
pose."""

SUPPORT = "support"
"""Name of the solid under an object that the robot carries."""

ROBOT = "panda"
"""Default robot of the problems."""

GRASP_DISTANCE = 0.021
"""An object counts as grasped if its distance from the hand's spheres is at
most this [m]."""

GRASP_SIZE = 0.3
"""A hand grasps an object only if no side of the object is longer than this
[m]."""

GRASP_SPHERES = ("paper", "covering")
"""Sphere sets for finding the grasped object. The first of these sets that the
robot has is used."""

START_CLEARANCE, START_DRAWS = 0.05, 200
"""Least clearance of a robot at a displaced base pose [m], and largest number
of random base poses that are tried."""

FLOOR_HEIGHT = 0.03
"""Links that are close to the floor ignore the scene below this height [m], as
in scenarios."""


@dc.dataclass(frozen=True)
class MotionProblem(SceneCase):
    """One problem: a scene, a start and a goal, for one robot.

    The attribute `file` is the request's file; the scene's file is in the same
    folder.

    Attributes:
        robot: Name or file of the robot. An arm on a fixed base stands at the
            problem's pose. A mobile robot starts at a displaced pose, which is
            the same in every run.
        with_object: Whether the scene contains the object to be grasped.
        carried: Whether the robot then carries the object to the start's pose.
    """

    robot: str = ROBOT
    with_object: bool = False
    carried: bool = False

    def grasping(self, carried: bool = False) -> "MotionProblem":
        """Returns the problem in the scene that contains the grasped object.

        Args:
            carried: Whether the robot then carries the object to the start's
                pose.
        """
        name = CARRY_SUITE if carried else GRASP_SUITE
        suite = self.suite.replace(SUITE, name, 1)
        return dc.replace(self, suite=suite, with_object=True, carried=carried)

    def truth(self) -> PrimitiveScene:
        """Reads the scene without the object to be grasped, in W.

        Raises:
            RemoSplatError: A file cannot be used, or does not fit the robot.
        """
        solids = self.task().solids
        assert solids is not None
        return solids

    def task(self) -> ReachingTask:
        """Reads the problem.

        Raises:
            RemoSplatError: A file cannot be used, or does not fit the robot.
        """
        return _read_problem(
            self.file, self.name, self.robot, self.with_object, self.carried
        )


def motion_problems(
    folder: Path, count: int, robot: str = ROBOT
) -> list[MotionProblem]:
    """Returns the first problems of each family in a folder.

    Args:
        folder: Folder of families, or a family itself.
        count: At most this many problems of each family are returned.
        robot: Name or file of the robot.

    Raises:
        RemoSplatError: There is no such folder or robot, or the folder does not
            contain unpacked problems.
    """
    description = load_robot_description(robot)
    if not folder.is_dir():
        raise FileError(folder, "no such folder")
    families = [folder, *sorted(p for p in folder.iterdir() if p.is_dir())]
    problems = [
        MotionProblem(
            f"{_family(path)}_{number}",
            _family(path),
            f"{SUITE}, {description.name}",
            str(path / f"request{number}.yaml"),
            robot=robot,
        )
        for path in families
        for number in _numbers(path)[:count]
    ]
    if not problems:
        archives = sorted(p.name for p in folder.glob("*.tar*"))
        hint = (
            f"; unpack its archive {archives[0]} with `tar xf`"
            if archives
            else ""
        )
        raise FileError(folder, f"contains no requestNNNN.yaml{hint}")
    return problems


def _family(folder: Path) -> str:
    """Returns a family's name, without the robot in its folder's name."""
    return folder.resolve().name.removesuffix(f"_{ROBOT}")


def _numbers(folder: Path) -> list[str]:
    """Returns the numbers of the problems in a folder, as written.

    A number is also included if one of its two files is missing. The benchmark
    then reports this problem as unusable.
    """
    return sorted(
        {
            path.stem.removeprefix(kind)
            for kind in ("request", "scene")
            for path in folder.glob(f"{kind}*.yaml")
        }
    )


@lru_cache(maxsize=8)
def _load_robot(name: str, spheres: str) -> RobotModel:
    return load_robot(name, spheres, FLOOR_HEIGHT)


@lru_cache(maxsize=16)
def _read_problem(
    file: str,
    name: str,
    robot_name: str,
    with_object: bool = False,
    carried: bool = False,
) -> ReachingTask:
    sets = load_robot_description(robot_name).spheres
    known = next((s for s in GRASP_SPHERES if s in sets), next(iter(sets)))
    robot = _load_robot(robot_name, known)
    joints = robot.description.arm.joints
    start, goal = read_request(Path(file), tuple(joints))
    request = Path(file)
    number = request.stem.removeprefix("request")
    scene_file = request.with_name(f"scene{number}.yaml")
    objects = read_planning_scene(scene_file)
    base = np.zeros(robot.n_q - len(joints))
    q_goal = np.concatenate([base, goal])
    X_WM = RigidTransform(
        robot.body_poses(q_goal)[robot.tree.index(robot.description.arm.mount)]
    )
    placed = {key: _placed(X_WM, scene) for key, scene in objects.items()}
    grasped = grasped_object(robot, q_goal, placed)
    kept = [scene for key, scene in placed.items() if key != grasped]
    scene = PrimitiveScene(
        boxes=tuple(box for part in kept for box in part.boxes),
        cylinders=tuple(c for part in kept for c in part.cylinders),
        X_WE_target=RigidTransform(robot.end_effector_pose(q_goal)),
        X_WB_start=(0.0, 0.0, 0.0),
        name=name,
    )
    if robot.n_base:
        scene = dc.replace(
            scene, X_WB_start=_displaced(robot, scene, start, file)
        )
    things = _objects(grasped, placed) if with_object else ()
    named, support = "".join(f"+{thing.name}" for thing in things), None
    if carried:
        scene, support = _with_support(scene, things, scene_file)
        named += ", carried"
    task = solid_task(scene)
    return dc.replace(
        task,
        content_hash=task.content_hash + named,
        arm_start=tuple(start.tolist()),
        start_field="start_state.joint_state.position",
        arm_goal=None if robot.n_base else tuple(goal.tolist()),
        grasped=things,
        support=support,
    )


@reads_file
def read_request(
    path: Path, joints: tuple[str, ...]
) -> tuple[np.ndarray, np.ndarray]:
    """Reads the start and the goal of an arm from a motion planning request.

    Args:
        path: The YAML file.
        joints: Names of the arm's joints. Other joints in the file, such as
            those of fingers, are ignored.

    Returns:
        Joint positions at the start and at the goal, shape (n,) each [rad].

    Raises:
        FileError: The file is missing or not YAML.
        FieldError: A field or a joint is missing or unusable.
    """
    request = ForeignValue.read(path)
    state = request.get("start_state").get("joint_state")
    names = [name.text() for name in state.get("name").items()]
    positions = state.get("position")
    values = positions.numbers(len(names)).tolist()
    start = dict(zip(names, values, strict=True))
    goals = request.get("goal_constraints")
    if not goals.items():
        goals.fail("expected a goal, got none")
    wanted = goals.items()[0].get("joint_constraints")
    goal = {
        entry.get("joint_name").text(): entry.get("position").number()
        for entry in wanted.items()
    }
    for joint in joints:
        for place, given in ((positions, start), (wanted, goal)):
            if joint not in given:
                place.fail(f"has no position of joint {joint}")
    return (
        np.array([start[joint] for joint in joints]),
        np.array([goal[joint] for joint in joints]),
    )


def grasped_object(
    robot: RobotModel, q: np.ndarray, objects: dict[str, PrimitiveScene]
) -> str | None:
    """Finds the object that the hand encloses.

    It is the nearest object that is small enough, and is within
    `GRASP_DISTANCE` of a sphere that moves with the arm's last joint.

    Args:
        robot: The robot, with its spheres.
        q: Configuration at the goal, shape (n_q,).
        objects: Objects in W by name.

    Returns:
        The object's name; None if no object is so near.
    """
    hand = robot.spheres_at(q).select(robot.leading_spheres)
    distance = {
        name: SignedDistanceField(scene).clearances(hand).minimum()
        for name, scene in objects.items()
        if 0 < _size(scene) <= GRASP_SIZE
    }
    name = min(distance, key=lambda name: distance[name], default=None)
    return name if name and distance[name] <= GRASP_DISTANCE else None


def _objects(
    name: str | None, placed: dict[str, PrimitiveScene]
) -> tuple[SceneObject, ...]:
    """Returns the solids of the object to be grasped; empty without one."""
    solids = placed[name].primitives if name else ()
    return tuple(
        SceneObject(f"{name} {i + 1}", solid) for i, solid in enumerate(solids)
    )


def _with_support(
    scene: PrimitiveScene, things: tuple[SceneObject, ...], file: Path
) -> tuple[PrimitiveScene, SceneObject]:
    """Returns a scene that names the object's support, and this support."""
    solids = scene.primitives
    if len(things) != 1 or not solids:
        problem = (
            "at the goal, the hand does not enclose a single solid that "
            "stands on another solid"
        )
        raise FieldError(str(file), "world.collision_objects", problem)
    (thing,) = things
    distances = SolidDistances(thing.solid, solids).at(thing.X_WO)
    nearest = solids[int(np.argmin(distances))]
    named = [
        dc.replace(x, name=SUPPORT if x is nearest else x.name) for x in solids
    ]
    scene = dc.replace(
        scene,
        boxes=tuple(x for x in named if isinstance(x, Box)),
        cylinders=tuple(x for x in named if isinstance(x, Cylinder)),
    )
    (support,) = (x for x in scene.primitives if x.name == SUPPORT)
    return scene, SceneObject(SUPPORT, support)


def _size(scene: PrimitiveScene) -> float:
    """Returns the largest side length of a scene's solids [m]."""
    boxes = [2 * float(box.half_extents.max()) for box in scene.boxes]
    cylinders = [2 * max(c.radius, c.half_height) for c in scene.cylinders]
    return max([*boxes, *cylinders], default=0.0)


def _placed(X_WS: RigidTransform, scene: PrimitiveScene) -> PrimitiveScene:
    """Returns a scene that is moved from its frame S into W."""

    def moved(primitive: Box | Cylinder) -> Box | Cylinder:
        return dc.replace(primitive, X_WP=X_WS @ primitive.X_WP)

    return dc.replace(
        scene,
        boxes=tuple(moved(box) for box in scene.boxes),
        cylinders=tuple(moved(c) for c in scene.cylinders),
    )


def _displaced(
    robot: RobotModel, scene: PrimitiveScene, arm: np.ndarray, file: str
) -> tuple[float, float, float]:
    """Draws a collision-free start pose, with the scene's name as the seed."""
    digest = hashlib.sha256(scene.name.encode()).digest()
    rng = np.random.default_rng(list(digest[:8]))
    field = SignedDistanceField(scene)
    for _ in range(START_DRAWS):
        start = draw_start(rng)
        spheres = robot.spheres_at(np.array([*start, *arm]))
        if field.clearances(spheres).minimum() >= START_CLEARANCE:
            return start
    raise FieldError(
        file,
        "start_state",
        f"no pose of {robot.description.name} near the arm's original pose"
        f" keeps {1e3 * START_CLEARANCE:g} mm from the scene",
    )
