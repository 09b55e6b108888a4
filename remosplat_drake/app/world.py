"""`World`: the content of a scenario's files, checked and placed in W."""

import dataclasses as dc
from collections.abc import Callable, Sequence
from functools import partial
from pathlib import Path

import numpy as np

from remosplat_drake.app.object_config import make_objects
from remosplat_drake.app.object_map import with_solids, without_objects
from remosplat_drake.app.scenario import Scenario
from remosplat_drake.app.scenario_robot import load_scenario_robot
from remosplat_drake.app.scene_config import OBSTACLE
from remosplat_drake.app.seen_space import (
    SeenSpace,
    load_seen_space,
    seen_file,
)
from remosplat_drake.app.target_config import make_target
from remosplat_drake.base import resources
from remosplat_drake.base.errors import (
    FieldError,
    FileError,
    RemoSplatError,
)
from remosplat_drake.base.pose_config import make_transform
from remosplat_drake.base.ranges import check_ranges
from remosplat_drake.oracle.composite import CompositeDistanceField
from remosplat_drake.oracle.found_object import FoundObject
from remosplat_drake.oracle.object_field import ObjectField, with_objects
from remosplat_drake.oracle.oracle_config import (
    GroundTruth,
    OracleConfig,
    OracleMaker,
    make_field,
)
from remosplat_drake.oracle.signed_distance import SignedDistanceField
from remosplat_drake.reconstruction.report.quality_report import report_path
from remosplat_drake.robot.robot_description import unknown_effector
from remosplat_drake.robot.robot_model import RobotModel
from remosplat_drake.scene.directives import read_directives
from remosplat_drake.scene.objects.region_growing import LEAST_SPLATS
from remosplat_drake.scene.objects.scene_object import SceneObject
from remosplat_drake.scene.primitive_scene import PrimitiveScene
from remosplat_drake.scene.rmmi import read_scene
from remosplat_drake.signals.distance_field import DistanceField
from remosplat_drake.signals.target import Target
from remosplat_drake.splat.formats import read_splat
from remosplat_drake.splat.gaussian_splat import GaussianSplat

_DEEPEST = 0.03
"""At its start, the robot may be at most this deep inside the scene [m]. A map
contains only surfaces, so deeper inside an object the direction out of the
object is uncertain."""


@dc.dataclass(frozen=True, eq=False)
class World:
    """The content of a scenario's files, loaded and placed in W.

    Attributes:
        robot: The robot, with its limits and kinematics.
        splat_W: The scene's splat in W, without the cropped part; None without
            a splat.
        cropped_W: The part of the splat that was cropped away, in W.
        scene_splat_W: The splat without the objects; None without a splat.
        truth: The scene's true geometry in W; None if it is unknown.
        field: The map that the oracle queries.
        scene_field: The map without the objects.
        objects: The objects at their initial poses.
        q0: Start configuration, shape (n_q,) [rad, m].
        seen: The seen space of the splat's capture; None if that is unknown.
    """

    robot: RobotModel
    splat_W: GaussianSplat | None
    truth: PrimitiveScene | None
    field: DistanceField
    q0: np.ndarray
    cropped_W: GaussianSplat = dc.field(default_factory=GaussianSplat.empty)
    seen: SeenSpace | None = None
    scene_field: DistanceField | None = None
    scene_splat_W: GaussianSplat | None = None
    objects: tuple[SceneObject, ...] = ()

    @property
    def fixed_truth(self) -> PrimitiveScene | None:
        """The true geometry without the objects; None if it is unknown.

        Objects are excluded, since the robot may touch and move them.
        """
        if self.truth is None:
            return None
        return without_objects(self.truth, self.objects)

    @property
    def truth_field(self) -> DistanceField | None:
        """Distance field of `fixed_truth`; None if it is unknown."""
        scene = self.fixed_truth
        return None if scene is None else SignedDistanceField(scene)


def load_world(scenario: Scenario, *, blank: bool = False) -> World:
    """Reads a scenario's files, and checks the robot's start.

    Args:
        scenario: The scenario.
        blank: Whether a scenario without a splat is permitted, for example
            since a live map will be made.

    Raises:
        RemoSplatError: A file or a field is unusable, or the robot would
            start deep inside the scene or far beyond its limits.
    """
    where = scenario.source
    check_ranges(scenario, where)
    robot = load_scenario_robot(scenario)
    splat_W, cropped_W = load_splat(scenario)
    found = make_objects(scenario.objects, scenario.folder, where, splat_W)
    objects = tuple(each.thing for each in found)
    truth = with_solids(_true_scene(scenario, "truth"), objects)
    if splat_W is None and blank:
        splat_W = GaussianSplat.empty()
    scene_splat_W = splat_W
    if objects and splat_W is not None and len(splat_W):
        scene_splat_W = _without_splats(scenario, found, splat_W)
    fixed = truth
    if objects and truth is not None:
        fixed = without_objects(truth, objects)
    q0 = _start(scenario, robot, truth)
    seen = load_seen_space(scenario, robot.spheres_at(q0))
    scene_field = scene_field_maker(scenario, seen)(scene_splat_W, fixed)
    field = scene_field
    if objects:
        field = with_objects(scene_field, ObjectField(objects))
    world = World(
        robot,
        splat_W,
        truth,
        field,
        q0,
        cropped_W,
        seen,
        scene_field,
        scene_splat_W,
        objects,
    )
    _check_start(world, where)
    return world


def scene_field_maker(
    scenario: Scenario, seen: SeenSpace | None
) -> Callable[..., DistanceField]:
    """Returns a function that makes the map of a scene without its objects.

    The function can be pickled. Its arguments are the splat in W and,
    optionally, the true scene; each may be None.

    Args:
        scenario: The scenario.
        seen: The seen space of the splat's capture; None if it is unknown.
    """
    unseen = None
    if seen is not None and scenario.scene.unknown == OBSTACLE:
        unseen = seen.field
    return partial(_make_field, scenario.oracle, scenario.source, unseen)


def _make_field(
    oracle: OracleConfig | OracleMaker,
    where: str,
    unseen: DistanceField | None,
    splat_W: GaussianSplat | None,
    truth: PrimitiveScene | None = None,
) -> DistanceField:
    field = make_field(oracle, splat_W, truth, where)
    return field if unseen is None else CompositeDistanceField([field, unseen])


def _without_splats(
    scenario: Scenario,
    found: Sequence[FoundObject],
    splat_W: GaussianSplat,
) -> GaussianSplat:
    """Removes the objects from the splat."""
    is_other = np.ones(len(splat_W), bool)
    is_asked = not isinstance(scenario.oracle, GroundTruth)
    for i, (config, each) in enumerate(
        zip(scenario.objects, found, strict=True)
    ):
        too_few = np.count_nonzero(each.own) < LEAST_SPLATS
        if is_asked and config.in_splat and too_few:
            raise FieldError(
                scenario.source,
                f"objects[{i}].X_WO",
                f"the splat shows no {each.thing.name} there; correct the "
                "object's X_WO, or set in_splat: false if the object is "
                "not in the splat",
            )
        is_other &= ~each.own
    return splat_W.select(is_other)


def true_scenes(scenario: Scenario, world: World) -> tuple[PrimitiveScene, ...]:
    """Returns the true scene, and the alternative true scene if it exists.

    Args:
        scenario: The scenario.
        world: The content of the scenario's files.

    Returns:
        One scene or two; none if the true geometry is unknown.

    Raises:
        RemoSplatError: A file is unusable.
    """
    if world.truth is None:
        return ()
    if not scenario.scene.truth_later:
        return (world.truth,)
    later = _true_scene(scenario, "truth_later")
    assert later is not None
    return world.truth, later


def _true_scene(scenario: Scenario, field: str) -> PrimitiveScene | None:
    """Reads a file of true geometry, and adds the objects of directives."""
    truth = None
    if getattr(scenario.scene, field):
        truth = read_scene(_scene_file(scenario, field))
    try:
        objects = read_directives(scenario.scene.directives, scenario.folder)
    except RemoSplatError as error:
        raise FieldError(
            scenario.source, "scene.directives", str(error)
        ) from error
    if truth is None or not len(objects):
        return objects if len(objects) else truth
    return dc.replace(
        truth,
        boxes=(*truth.boxes, *objects.boxes),
        cylinders=(*truth.cylinders, *objects.cylinders),
    )


def scenario_targets(
    scenario: Scenario, truth: PrimitiveScene | None, effectors: Sequence[str]
) -> dict[str, list[Target]]:
    """Returns the targets of a scenario, or else the target of its true scene.

    The result is empty if the scenario has tasks, or its own system that
    outputs targets during the run.

    Args:
        scenario: The scenario.
        truth: The true scene, which may contain a target; None if it is
            unknown.
        effectors: Names of the robot's end effectors.

    Returns:
        The sequence of targets of each end effector, keyed by the effector's
        name.

    Raises:
        FieldError: A target is unusable.
    """
    found: dict[str, list[Target]] = {name: [] for name in effectors}
    if scenario.tasks or not isinstance(scenario.targets, list):
        return found
    if not scenario.targets and truth is not None and truth.X_WE_target:
        found[effectors[0]].append(Target.of(truth.X_WE_target))
    for i, config in enumerate(scenario.targets):
        field = f"targets[{i}]"
        name = config.effector or effectors[0]
        if name not in found:
            raise FieldError(
                scenario.source,
                f"{field}.effector",
                unknown_effector(name, effectors),
            )
        found[name].append(make_target(config, scenario.source, field))
    return found


def load_splat(
    scenario: Scenario,
) -> tuple[GaussianSplat | None, GaussianSplat]:
    """Reads a scenario's splat, and separates the part outside scene.crop.

    Args:
        scenario: The scenario.

    Returns:
        The remaining part, None without a splat, and the cropped part, in W.

    Raises:
        RemoSplatError: The file is unusable, or the whole splat is cropped
            away.
    """
    scene = scenario.scene
    if not scene.splat:
        return None, GaussianSplat.empty()
    path = _scene_file(scenario, "splat")
    X_WG = make_transform(scene.X_WG, scenario.source, "scene.X_WG")
    _check_scale(scenario, path)
    splat_G = read_splat(path, harmonics=False)
    splat_W = splat_G.transformed(X_WG, scene.scale)
    if scene.crop is None:
        return splat_W, GaussianSplat.empty()
    inside = splat_W.inside(
        np.array(scene.crop.lower), np.array(scene.crop.upper)
    )
    if not inside.any():
        raise FieldError(scenario.source, "scene.crop", "leaves no splats")
    return splat_W.select(inside), splat_W.select(~inside)


def _check_scale(scenario: Scenario, splat: Path) -> None:
    """Checks that a splat with measurements in metres is not scaled."""
    scale = scenario.scene.scale
    if scale == 1:
        return
    for path in (seen_file(scenario), report_path(splat)):
        if path is not None and path.is_file():
            raise FieldError(
                scenario.source,
                "scene.scale",
                f"must be 1, got {scale:g}: {path.name} requires a splat in "
                "metres; convert the splat by `remosplat convert --scale "
                f"{scale:g}`",
            )


def _scene_file(scenario: Scenario, field: str) -> Path:
    uri = getattr(scenario.scene, field)
    try:
        return resources.resolve(uri, scenario.folder)
    except FileError as error:
        raise FieldError(
            scenario.source, f"scene.{field}", str(error)
        ) from error


def _start(
    scenario: Scenario, robot: RobotModel, truth: PrimitiveScene | None
) -> np.ndarray:
    base = scenario.robot.base_pose
    if base is not None and not robot.n_base:
        raise FieldError(
            scenario.source,
            "robot.base_pose",
            f"{robot.description.name} is fixed to the world and has no base;"
            " `scene.X_WG` moves the scene's splat instead",
        )
    if base is None and truth is not None and truth.X_WB_start is not None:
        base = list(truth.X_WB_start)
    arm = scenario.robot.arm
    if arm is None:
        arm = list(robot.home)
    if len(arm) != len(robot.home):
        raise FieldError(
            scenario.source,
            "robot.arm",
            f"expected {len(robot.home)} numbers, got {len(arm)}",
        )
    q0 = np.array([*((base or [0.0] * 3) if robot.n_base else []), *arm])
    return robot.rounded_into_limits(q0)


def _check_start(world: World, where: str) -> None:
    robot, q0 = world.robot, world.q0
    if not (robot.excess(q0) <= robot.most_beyond).all():
        raise FieldError(where, "robot.arm", robot.beyond_limits(q0))
    clearances = world.field.clearances(robot.spheres_at(q0))
    if not clearances.is_known:
        raise FieldError(
            where, "oracle", "measures no distance at the robot's start"
        )
    if clearances.minimum() < -_DEEPEST:
        row = int(clearances.distance.argmin())
        link = robot.spheres.links[clearances.sphere[row]]
        raise FieldError(
            where,
            "robot.base_pose",
            f"the robot would start inside the scene: {link} by "
            f"{-1e3 * clearances.minimum():.0f} mm",
        )
