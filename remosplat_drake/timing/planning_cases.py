"""Benchmarks of planning to many targets in the shipped, trained splats.

A target is a pose of the hand in front of a random disc, at which the hand
points. Targets to which there is a path are measured separately from those that
no configuration reaches with the required distances. For comparison, paths to
the same targets are also planned with distances to the true geometry.
"""

import dataclasses as dc
import math
from collections.abc import Callable
from typing import Any

import numpy as np

from remosplat_drake.app.scenario import load_scenario
from remosplat_drake.app.world import World, load_world
from remosplat_drake.controller.planning.goal_configurations import (
    GoalConfigurations,
    goal_configurations,
)
from remosplat_drake.controller.planning.motion_planner import MotionPlanner
from remosplat_drake.controller.planning.plan import Plan
from remosplat_drake.controller.planning.timing import TimingLimits
from remosplat_drake.controller.tick.reactive_law import ReactiveLaw
from remosplat_drake.timing.measuring import Case, in_turn

SCENARIOS = ("TableReach", "BookshelfReach")
"""Scenarios in whose splats paths are planned."""

_TARGETS = 60
"""Number of targets that are drawn in each scenario."""

_HEIGHTS = (0.15, 1.6)
"""Least and greatest height of the disc to which the hand points [m]."""

_AWAY = (0.08, 0.2)
"""Least and greatest distance between the hand and the disc [m]."""

_SECONDS = 10.0


def planning_cases() -> list[Case]:
    """Makes benchmarks for each of `SCENARIOS`."""
    return [case for name in SCENARIOS for case in _cases(name)]


def _cases(name: str) -> list[Case]:
    """Makes benchmarks of paths, of goals, and of targets out of reach."""
    scenario = load_scenario(name)
    world = load_world(scenario)
    law = ReactiveLaw.make(
        scenario.controller, world.robot, scenario.control_period
    )
    config = scenario.controller.guidance.planning
    timing = TimingLimits(law.collision, config.approach_scale, law.dt)
    planner = MotionPlanner(world.robot, law.self_clearance, config, timing)
    stopping = law.collision.stopping
    q, field, solids = world.q0, world.field, world.truth_field
    assert solids is not None

    def plan(X_WT: np.ndarray) -> Plan:
        return planner.plan(q, X_WT, field, stopping)

    def plan_in_solids(X_WT: np.ndarray) -> Plan:
        return planner.plan(q, X_WT, solids, stopping)

    def find_goals(X_WT: np.ndarray) -> GoalConfigurations:
        return goal_configurations(
            planner.free_space(q, field, stopping),
            X_WT,
            q,
            seeds=config.seeds,
            most=config.goals,
            rng=np.random.default_rng(1),
        )

    targets = draw_targets(world)
    plans = [plan(X_WT) for X_WT in targets]
    pairs = list(zip(targets, plans, strict=True))
    found = [X_WT for X_WT, there in pairs if there.path]
    none = [X_WT for X_WT, there in pairs if not there.goals]
    both = [X_WT for X_WT in found if plan_in_solids(X_WT).path]
    return [
        _search(f"first path, {name}", plan, found),
        _search(f"first path in both maps, {name}, discs", plan, both),
        _search(
            f"first path in both maps, {name}, solids", plan_in_solids, both
        ),
        _case(f"goals of these, {name}", find_goals, found),
        _search(f"no goal, {name}", plan, none),
    ]


def _case(name: str, run: Callable[[np.ndarray], Any], targets: list) -> Case:
    return Case(
        f"planning: {name}, {len(targets)} targets",
        in_turn(targets, run),
        _SECONDS,
    )


def _search(
    name: str, plan: Callable[[np.ndarray], Plan], targets: list
) -> Case:
    return dc.replace(_case(name, plan, targets), checks=checks_of)


def checks_of(plan: Plan) -> int:
    """Returns the number of checks that a search made."""
    return plan.checks


def draw_targets(world: World, count: int = _TARGETS, seed: int = 1):
    """Draws poses of the hand in front of discs of a world's splat.

    Args:
        world: The world, with a splat of discs.
        count: Number of targets.
        seed: Seed of the random numbers.

    Returns:
        The poses X_WT, shape (count, 4, 4).
    """
    rng = np.random.default_rng(seed)
    splat_W = world.splat_W
    assert splat_W is not None
    eye = np.array([*world.q0[:2], 1.0])
    height = splat_W.p_GK[:, 2]
    within = np.flatnonzero((height > _HEIGHTS[0]) & (height < _HEIGHTS[1]))
    X_WT = np.tile(np.eye(4), (count, 1, 1))
    for X, disc in zip(X_WT, rng.choice(within, count), strict=True):
        p, n = splat_W.p_GK[disc], splat_W.R_GK[disc, :, 2]
        n = n * math.copysign(1.0, n @ (eye - p))
        x = np.cross(n, rng.standard_normal(3))
        x /= np.linalg.norm(x)
        X[:3, :3] = np.stack([x, np.cross(-n, x), -n], axis=1)
        X[:3, 3] = p + rng.uniform(*_AWAY) * n
    return X_WT
