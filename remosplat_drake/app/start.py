"""Finds problems of a run's start and targets, before the robot moves."""

from collections.abc import Iterator

import numpy as np

from remosplat_drake.app.scenario import Scenario
from remosplat_drake.app.target_config import make_target
from remosplat_drake.app.world import World
from remosplat_drake.controller.planning.out_of_reach import out_of_reach
from remosplat_drake.controller.tick.reactive_law import ReactiveLaw
from remosplat_drake.controller.tick.run_tick import run_tick
from remosplat_drake.motion_status.names import name_thing
from remosplat_drake.safety.gates import (
    NO_WAY_OUT,
    REFUSAL,
    START_BEYOND_LIMITS,
    START_TOO_NEAR,
    TARGET_OUT_OF_REACH,
    Gate,
)
from remosplat_drake.signals.aim import Aim
from remosplat_drake.signals.distance_field import Clearances

NOTABLE = 1e-3
"""A distance at the start is reported if it is smaller than the stopping
distance by more than this length [m]."""

_FORESEEN = 2.0
"""If distances are too small at the start, the control law must increase them
within this simulated time [s]."""

_GAIN = 1e-4
"""If distances are too small at the start, the control law must reduce the sum
of the shortages within `_FORESEEN` by at least this [m], or by half of the sum
if that is less."""


def start_gates(scenario: Scenario, world: World) -> tuple[Gate, ...]:
    """Finds problems of a scenario's start and targets.

    Args:
        scenario: A checked scenario.
        world: The content of the scenario's files.
    """
    law = ReactiveLaw.make(
        scenario.controller, world.robot, scenario.control_period
    )
    gates = [*_beyond_limits(world), *_too_near(scenario, world, law)]
    if gates and not leads_out(law, world):
        problem = (
            f"{gates[0].problem}, and the controller cannot move the robot "
            "out of there; choose another start"
        )
        gates = [Gate(NO_WAY_OUT, problem, in_simulation=REFUSAL)]
    return (*gates, *_out_of_reach(scenario, world))


def lacking(law: ReactiveLaw, world: World, q: np.ndarray) -> np.ndarray:
    """Computes by how much each distance falls below its stopping distance.

    Args:
        law: The control law, with the stopping distances.
        world: The robot and its map.
        q: Configuration, shape (n_q,) [rad, m].

    Returns:
        The shortages [m, rad], 0 if a distance suffices, shape (k + n + n_q,):
        for the k pairs of the robot's shapes, for its n spheres and the map,
        and for its joints and their limits.
    """
    own, robot, least = law.self_clearance, world.robot, law.collision.stopping
    scene = _clearances(world, q, least).per_sphere(len(robot.spheres))
    itself = np.zeros(0)
    if own is not None:
        itself = own.stopping - own.distances(q, own.stopping)
    short = np.concatenate([itself, least - scene, robot.excess(q)])
    return np.maximum(short, 0.0)


def leads_out(law: ReactiveLaw, world: World) -> bool:
    """Returns whether the law can increase distances that are too small.

    The function simulates the robot until the distances have increased
    slightly. It does not detect whether the robot gets stuck later.

    Args:
        law: The control law.
        world: The robot, its map and its start.
    """
    robot, q, u = world.robot, world.q0, np.zeros(world.robot.n_u)
    X_WE = robot.end_effector_pose(q)
    at_start = lacking(law, world, q)
    for tick in range(round(_FORESEEN / law.dt)):
        near = world.field.clearances(
            robot.spheres_at(q), law.collision.influence
        )
        time = tick * law.dt
        u = run_tick(law, time, q, X_WE, near, world.field, u).command
        q = robot.advance(q, u, law.dt)
        parted = at_start - lacking(law, world, q)
        if parted.sum() >= min(_GAIN, 0.5 * at_start.sum()):
            return True
    return False


def _beyond_limits(world: World) -> Iterator[Gate]:
    problem = world.robot.beyond_limits(world.q0)
    if problem:
        yield Gate(START_BEYOND_LIMITS, f"robot.arm: {problem}")


def _too_near(
    scenario: Scenario, world: World, law: ReactiveLaw
) -> Iterator[Gate]:
    """Finds distances between links, and from the scene, that are too small."""
    q, called = world.q0, world.robot.description.called
    own = law.self_clearance
    if own is not None and len(own.pairs):
        distance = own.distances(q, own.stopping)
        i = int(distance.argmin())
        if distance[i] < own.stopping - NOTABLE:
            gap = float(distance[i] - own.pairs.allowance[i])
            one, other = map(called, own.pairs.links(i))
            yield Gate(
                START_TOO_NEAR,
                f"robot.arm: {_relation(one, other, gap)}; links must"
                f" keep {1e3 * own.stopping:.0f} mm from each other",
            )
    least = law.collision.stopping
    near = _clearances(world, q, least)
    if near.minimum() < least - NOTABLE:
        i = int(near.distance.argmin())
        thing = name_thing(
            world.field, near.p_WC[i], scenario.scene.floor_height
        )
        link = called(world.robot.spheres.links[near.sphere[i]])
        field = "robot.base_pose" if world.robot.n_base else "robot.arm"
        yield Gate(
            START_TOO_NEAR,
            f"{field}: {_relation(link, thing.name, near.minimum())}; the robot"
            f" must keep {1e3 * least:.0f} mm from the scene",
        )


def _clearances(world: World, q: np.ndarray, within: float) -> Clearances:
    """Measures clearances of the spheres that a command can move."""
    robot = world.robot
    found = world.field.clearances(robot.spheres_at(q), within)
    moves = np.abs(robot.jacobian_bound[found.sphere]).max(axis=1) > 0
    return found.select(moves)


def _relation(one: str, other: str, gap: float) -> str:
    """Describes the distance or the overlap of two objects."""
    if gap < 0:
        return f"{one} and {other} overlap by {-1e3 * gap:.0f} mm"
    return f"{one} and {other} are {1e3 * gap:.0f} mm apart"


def _out_of_reach(scenario: Scenario, world: World) -> Iterator[Gate]:
    """Finds targets out of reach; a mobile base moves the arm horizontally."""
    if not isinstance(scenario.targets, list):
        return
    robot = world.robot
    effectors = {"": 0, **{name: i for i, name in enumerate(robot.effectors)}}
    for i, config in enumerate(scenario.targets):
        if config.effector not in effectors:
            continue  # The run reports this itself.
        field, effector = f"targets[{i}]", effectors[config.effector]
        target = make_target(config, scenario.source, field)
        aim = Aim((None,) * effector + (target,))
        problem = out_of_reach(robot, aim, world.q0)
        if problem:
            yield Gate(TARGET_OUT_OF_REACH, f"{field}.translation: {problem}")
