"""Compiles the kernels with Numba before the first tick.

Compiled kernels are stored on disk. Loading them from there would also delay a
tick, so every run begins with `compile_kernels`.
"""

import copy

import numpy as np
from pydrake.math import RigidTransform
from pydrake.systems.analysis import Simulator

from remosplat_drake.app.diagram import build
from remosplat_drake.app.scenario import CAMERAS, Scenario
from remosplat_drake.app.scene_config import OBSTACLE
from remosplat_drake.app.target_config import TargetConfig
from remosplat_drake.app.world import World
from remosplat_drake.controller.planning.motion_planner import MotionPlanner
from remosplat_drake.controller.planning.rehearsal import rehearse
from remosplat_drake.controller.tick.reactive_law import ReactiveLaw
from remosplat_drake.controller.tick.run_tick import run_tick
from remosplat_drake.controller.verification.map_calls import is_pythons
from remosplat_drake.oracle.composite import CompositeDistanceField
from remosplat_drake.oracle.object_field import ObjectField, with_objects
from remosplat_drake.oracle.oracle_config import make_field
from remosplat_drake.oracle.unknown_space import UnknownSpaceField
from remosplat_drake.robot.robot_model import RobotModel
from remosplat_drake.robot.sphere_model import Spheres
from remosplat_drake.scene.mover import Mover, Movers
from remosplat_drake.scene.primitive_scene import Box, PrimitiveScene
from remosplat_drake.signals.distance_field import Clearances, DistanceField
from remosplat_drake.splat.gaussian_splat import GaussianSplat
from remosplat_drake.station.station_config import KinematicStation

TICKS = 4
"""Number of rehearsed ticks. Together they call all kernels of later ticks;
guidance runs its rollouts in the second tick."""

_NEAR = 1e-3  # Distance of the obstacle: less than any stopping distance [m].
_ROOM = 8  # Number of voxels of 1 m around the robot.
_ABOVE = 0.4  # Height of a mover above the hand [m].
_AWAY = np.array([0.1, 0.1, 0.1])  # Vector from the start to the target [m].


def compile_kernels(
    scenario: Scenario,
    world: World,
    *,
    live_map: bool = False,
    plans: bool = True,
) -> None:
    """Compiles the kernels of a scenario by running some ticks of its loop.

    In these ticks the robot is very close to an obstacle, so that all parts of
    verification and guidance run. Guidance runs in this process, even if the
    scenario uses a separate process for it; that process then finds its kernels
    compiled.

    Args:
        scenario: The scenario, which is not changed.
        world: The content of the scenario's files. Only the robot, its start,
            and the type of its map affect the kernels.
        live_map: Whether the map may be replaced during the run.
        plans: Whether planning is rehearsed, too. A run without real-time
            limits may omit this, and load the kernels of planning at the first
            search.

    Raises:
        RemoSplatError: The loop cannot be made.
    """
    live_map = live_map and scenario.mapping.enabled
    scenario = copy.deepcopy(scenario)
    scenario.station = KinematicStation()
    scenario.wrist_camera = None
    for camera in scenario.cameras:
        camera.latency = (
            0.0  # Their detections take effect within these few ticks.
        )
    scenario.controller.guidance.asynchronous = False
    p_WE = world.robot.end_effector_pose(world.q0)[:3, 3]
    scenario.targets = [TargetConfig(translation=(p_WE + _AWAY).tolist())]
    scenario.tasks, scenario.objects = [], []
    splat_W, truth = _obstacle(world)
    for field in _fields(scenario, world, live_map, splat_W, truth):
        beside = World(world.robot, splat_W, truth, field, world.q0)
        simulator = Simulator(build(scenario, beside).diagram)
        simulator.AdvanceTo((TICKS - 0.5) * scenario.control_period)
        _tick_among_movers(scenario, beside)
        if plans:
            _plan_once(scenario, beside)
    if scenario.movers_from == CAMERAS:
        _look(scenario, world)


def _fields(
    scenario: Scenario,
    world: World,
    live_map: bool,
    splat_W: GaussianSplat,
    truth: PrimitiveScene,
) -> list[DistanceField]:
    """Makes a small map of each type that the control loop may query.

    Kernels are compiled once for each type of map, since they contain its
    queries.
    """
    known = make_field(scenario.oracle, splat_W, truth, scenario.source)
    unseen = np.zeros((_ROOM, _ROOM, _ROOM), bool)
    p_WE = world.robot.end_effector_pose(world.q0)[:3, 3]
    around = UnknownSpaceField(unseen, p_WE - 0.5 * _ROOM, 1.0)
    both = CompositeDistanceField([known, around])
    first = known
    scene = world.scene_field or world.field
    if isinstance(scene, CompositeDistanceField):
        first = both
    elif live_map and not world.splat_W:
        first = around  # Nothing has been seen yet.
    fields = [first]
    if live_map:
        later = both if scenario.scene.unknown == OBSTACLE else known
        fields += [] if later is first else [later]
    if world.objects:
        fields = [with_objects(field, ObjectField(())) for field in fields]
    return [*fields, *[_Outside(fields[0])] * is_pythons(world.field)]


class _Outside(DistanceField):
    """A map without compiled kernels, such as a map type of another package.

    Unknown space whose frame is not W is such a map, too.
    """

    def __init__(self, field: DistanceField):
        self._field = field
        self.revision = field.revision
        self.is_lipschitz = field.is_lipschitz

    def clearances(
        self, spheres: Spheres, max_distance: float = np.inf
    ) -> Clearances:
        return self._field.clearances(spheres, max_distance)


def _plan_once(scenario: Scenario, world: World) -> None:
    """Plans a short path, if the scenario enables planning."""
    config, robot = scenario.controller.guidance, world.robot
    if not (config.enabled and config.planning.enabled):
        return
    law = ReactiveLaw.make(scenario.controller, robot, scenario.control_period)
    planner = MotionPlanner(robot, law.self_clearance, config.planning)
    rehearse(planner, world.q0, world.field.for_look_ahead)


def _look(scenario: Scenario, world: World) -> None:
    """Rehearses the detection of movers with a scenario's cameras."""
    from remosplat_drake.app.stages.camera_detection import known_scene
    from remosplat_drake.detection.rehearsal import (
        rehearse as rehearse_detection,
    )

    rehearse_detection(
        world.robot, known_scene(scenario, world), scenario.detection
    )


def _tick_among_movers(scenario: Scenario, world: World) -> None:
    """Runs a tick with a mover.

    Without this tick, kernels would be compiled when the first mover appears.
    """
    robot, q = world.robot, world.q0
    law = ReactiveLaw.make(scenario.controller, robot, scenario.control_period)
    X_WT = robot.end_effector_pose(q)
    above = X_WT[:3, 3] + np.array([0.0, 0.0, _ABOVE])
    movers = Movers(0.0, [Mover.sphere("mover", above, 0.1)])
    X_WT[:3, 3] += _AWAY
    run_tick(
        law,
        0.0,
        q,
        X_WT,
        Clearances.none(),
        world.field,
        np.zeros(robot.n_u),
        movers=movers,
    )


def _obstacle(world: World) -> tuple[GaussianSplat, PrimitiveScene]:
    """Makes a small obstacle that the hand nearly touches, as splat and box."""
    p_WC = _beside_hand(world.robot, world.q0)
    n = 8  # More than a leaf of the map's hierarchy.
    flat = world.splat_W is None or world.splat_W.is_surfel
    splat_W = GaussianSplat(
        p_GK=np.tile(p_WC, (n, 1)),
        quaternions=np.tile([1.0, 0, 0, 0], (n, 1)),
        scales=np.full((n, 2 if flat else 3), 1e-4),
        opacities=np.full(n, 0.99),
        colors=np.full((n, 3), 0.5),
    )
    box = Box(RigidTransform(p_WC), np.full(3, 1e-4))
    return splat_W, PrimitiveScene(boxes=(box,))


def _beside_hand(robot: RobotModel, q: np.ndarray) -> np.ndarray:
    """Returns a point `_NEAR` below the sphere nearest to the hand, in W."""
    spheres = robot.state(q).spheres
    p_WE = robot.end_effector_pose(q)[:3, 3]
    hand = np.linalg.norm(spheres.p_WS - p_WE, axis=1).argmin()
    below = [0.0, 0.0, spheres.radius[hand] + _NEAR]
    return spheres.p_WS[hand] - below
