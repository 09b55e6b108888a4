"""Benchmarks of ticks and of planning with objects in the map and in the hand.

The robot of the default scenario moves to its target. Each benchmark is
measured without objects, and with ten cans on the table and another can in the
hand. Paths are planned to random targets to which there is a path in both
cases.
"""

from collections.abc import Callable

import numpy as np
from pydrake.math import RigidTransform

from remosplat_drake.app.scenario import Scenario, load_scenario
from remosplat_drake.app.world import World, load_world
from remosplat_drake.controller.planning.motion_planner import MotionPlanner
from remosplat_drake.controller.planning.plan import Plan
from remosplat_drake.controller.planning.timing import TimingLimits
from remosplat_drake.controller.program.tick import Tick
from remosplat_drake.controller.tick.reactive_law import ReactiveLaw
from remosplat_drake.oracle.object_field import ObjectField, with_objects
from remosplat_drake.scene.objects.scene_object import SceneObject
from remosplat_drake.scene.primitive_scene import Cylinder
from remosplat_drake.signals.distance_field import DistanceField
from remosplat_drake.task.carrying import make_payload
from remosplat_drake.task.object_spheres import fit_object
from remosplat_drake.timing.measuring import Case, in_turn
from remosplat_drake.timing.planning_cases import checks_of, draw_targets
from remosplat_drake.timing.tick_cases import recorded_ticks, whole_tick

_CANS = 10
"""Number of cans on the table."""

_RADIUS, _HEIGHT, _MASS = 0.033, 0.12, 0.35
"""Size [m] and mass [kg] of a can."""

_ROW = 1.25
"""Coordinate x of the row of cans [m]."""

_ENDS = (-1.4, 1.4)
"""Coordinates y of the first and the last can [m]."""

_CENTER = 0.62
"""Height of the centres of the cans on the table [m]."""

_SECONDS = 4.0


def object_cases() -> list[Case]:
    """Makes benchmarks without objects, and with objects on table and hand."""
    scenario = load_scenario()
    world = load_world(scenario)
    law = ReactiveLaw.make(
        scenario.controller, world.robot, scenario.control_period
    )
    ticks = recorded_ticks(scenario, world)
    carried = _can("carried", world.robot.end_effector_pose(world.q0))
    payload = make_payload(world.robot, carried, fit_object(carried), world.q0)
    setups = {
        "no objects": (law, world.field),
        f"{_CANS} objects and one in the hand": (
            law.holding(payload),
            with_objects(world.field, ObjectField(_row())),
        ),
    }
    plans = {
        name: _plan(held, field, scenario, world)
        for name, (held, field) in setups.items()
    }
    targets = [
        X_WT
        for X_WT in draw_targets(world)
        if all(plan(X_WT).path for plan in plans.values())
    ]
    cases = []
    for name, (held, field) in setups.items():
        paths = f"first path, {len(targets)} targets, {name}"
        cases += [
            Case(
                f"objects: tick, verified, {name}",
                _ticks(held, field, ticks),
                _SECONDS,
            ),
            Case(
                f"objects: {paths}",
                in_turn(targets, plans[name]),
                _SECONDS,
                checks_of,
            ),
        ]
    return cases


def _row() -> list[SceneObject]:
    """Returns cans in a row along the table."""
    return [
        _can(f"can {k}", RigidTransform([_ROW, y, _CENTER]))
        for k, y in enumerate(np.linspace(*_ENDS, _CANS))
    ]


def _can(name: str, X_WO: RigidTransform | np.ndarray) -> SceneObject:
    solid = Cylinder(RigidTransform(X_WO), _RADIUS, 0.5 * _HEIGHT)
    return SceneObject(name, solid, _MASS)


def _ticks(
    law: ReactiveLaw, field: DistanceField, ticks: list[Tick]
) -> Callable[[], object]:
    return in_turn(ticks, lambda tick: whole_tick(law, field, tick))


def _plan(
    law: ReactiveLaw, field: DistanceField, scenario: Scenario, world: World
) -> Callable[[np.ndarray], Plan]:
    """Returns a function that plans a path to a pose of the hand."""
    config = scenario.controller.guidance.planning
    timing = TimingLimits(law.collision, config.approach_scale, law.dt)
    planner = MotionPlanner(law.robot, law.self_clearance, config, timing)
    stopping = law.collision.stopping
    return lambda X_WT: planner.plan(world.q0, X_WT, field, stopping)
