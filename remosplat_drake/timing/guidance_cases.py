"""Benchmarks of guidance: rollouts, and control loops with guidance.

The scene is generated like those of the benchmarks, and its surfaces are
covered by 60,000 surfels. In this scene, the controller gets stuck without
guidance, so guidance selects candidates.
"""

import dataclasses as dc
from collections.abc import Iterator
from itertools import islice

import numpy as np

from remosplat_drake.app.scenario import Scenario, load_scenario
from remosplat_drake.app.scenario_robot import load_scenario_robot
from remosplat_drake.controller.guidance.rollout import (
    RUNNING,
    Rollout,
    advance_rollout,
)
from remosplat_drake.controller.guidance.selection import start_selection
from remosplat_drake.controller.guidance.selection_round import (
    advance_selection,
)
from remosplat_drake.controller.guidance.selection_rule import (
    SelectionRule,
    make_selection_rule,
)
from remosplat_drake.controller.tick.reactive_law import ReactiveLaw
from remosplat_drake.controller.tick.run_tick import run_tick
from remosplat_drake.generation.primitive_surfels import surfel_splat
from remosplat_drake.generation.scene_generators import generate
from remosplat_drake.oracle.sphere_to_ellipsoid import SphereToEllipsoidField
from remosplat_drake.robot.robot_model import RobotModel
from remosplat_drake.signals.aim import Aim
from remosplat_drake.signals.distance_field import DistanceField
from remosplat_drake.task.arrival import has_arrived
from remosplat_drake.timing.measuring import Case

STUCK = ("table", 6)
"""Family and seed of a generated scene in which the robot needs guidance."""

_TIME_LIMIT = 12.0
_SECONDS = 4.0  # Duration of a measurement: several closed loops.
_WARM_UP = 20  # Calls until rollouts come near the scene.


@dc.dataclass(frozen=True, eq=False)
class _Task:
    """A robot in front of a scene, with its aim and its control law."""

    scenario: Scenario
    robot: RobotModel
    field: DistanceField
    law: ReactiveLaw
    rule: SelectionRule
    q0: np.ndarray
    aim: Aim


def guidance_cases() -> list[Case]:
    """Makes benchmarks of rollout steps, and of periods of control loops."""
    task = _make_task()
    budget = task.scenario.controller.guidance.budget
    for _ in islice(_rollouts(task, budget), _WARM_UP):
        pass
    rate = 1 / task.scenario.control_period
    return [
        Case(
            f"guidance: {budget} steps of a rollout",
            _endless(_rollouts(task, budget)),
        ),
        Case(
            f"guidance: whole tick at {rate:g} Hz, no look-ahead",
            _endless(_periods(task, 0)),
            _SECONDS,
        ),
        Case(
            f"guidance: whole tick at {rate:g} Hz, {budget} steps",
            _endless(_periods(task, budget)),
            _SECONDS,
        ),
    ]


def _make_task() -> _Task:
    scenario = load_scenario(None)
    scene = generate(*STUCK)
    robot = load_scenario_robot(scenario)
    assert scene.X_WE_target is not None and scene.X_WB_start is not None
    law = ReactiveLaw.make(scenario.controller, robot, scenario.control_period)
    rule = make_selection_rule(
        law,
        scenario.controller.guidance,
        lambda error: has_arrived(error, scenario.arrival),
    )
    return _Task(
        scenario,
        robot,
        SphereToEllipsoidField(surfel_splat(scene)),
        law,
        rule,
        np.array([*scene.X_WB_start, *robot.home]),
        Aim.of(scene.X_WE_target),
    )


def _endless(steps: Iterator[None]):
    return lambda: next(steps)


def _rollouts(task: _Task, steps: int) -> Iterator[None]:
    """Repeats the rollouts of all candidates from the start."""
    rule = task.rule
    while True:
        for guidance in rule.candidates(task.q0, task.aim, task.field)[0]:
            rollout = Rollout(guidance, task.q0, np.zeros(task.robot.n_u))
            while rollout.status == RUNNING:
                rollout = advance_rollout(
                    rule.law,
                    rollout,
                    task.field,
                    task.aim,
                    rule.arrived,
                    rule.horizon,
                    steps,
                )
                yield


def _periods(task: _Task, budget: int) -> Iterator[None]:
    """Runs control loops; a period has guidance, query, tick and motion."""
    robot, field, law, rule = task.robot, task.field, task.law, task.rule
    dt = law.dt
    while True:
        q, u, time = task.q0, np.zeros(robot.n_u), 0.0
        selection = start_selection(rule)
        arrived = False
        while time < _TIME_LIMIT and not arrived:
            guidance = selection.guidance
            selection = advance_selection(
                rule,
                selection,
                time=time,
                q=q,
                u=u,
                aim=task.aim,
                field=field,
                budget=budget,
            )
            clearances = field.clearances(
                robot.spheres_at(q), law.collision.influence
            )
            u = run_tick(
                law, time, q, task.aim, clearances, field, u, guidance
            ).command
            q = robot.advance(q, u, dt)
            X_WEs = robot.end_effector_poses(q)
            arrived = task.aim.is_reached(X_WEs, rule.arrived)
            time += dt
            yield
