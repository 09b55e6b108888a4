"""Benchmarks of the parts of a control tick, along a real run."""

import dataclasses as dc
from collections.abc import Callable
from itertools import pairwise

import numpy as np
from pydrake.math import RigidTransform

from remosplat_drake.app.diagram import build
from remosplat_drake.app.scenario import Scenario, load_scenario
from remosplat_drake.app.simulation import run
from remosplat_drake.app.world import World, load_world
from remosplat_drake.controller.program.solvers import ACTIVE_SET
from remosplat_drake.controller.program.tick import Tick
from remosplat_drake.controller.tick.reactive_law import ReactiveLaw
from remosplat_drake.controller.tick.run_tick import run_tick
from remosplat_drake.scene.mover import Mover, Movers
from remosplat_drake.signals.distance_field import DistanceField
from remosplat_drake.signals.motion_status import MotionStatus
from remosplat_drake.signals.tick_report import TickReport
from remosplat_drake.timing.measuring import Case, in_turn

_PEOPLE = 5
"""Number of movers (people) around the robot in benchmarks with movers."""

_STOUT = 0.2
"""Radius of a mover [m]."""

_GAP = 0.5
"""Distance of bystanders from all positions of the robot [m]."""

_IN_THE_WAY = 0.9
"""Distance of people from the hand in benchmarks in which no command avoids
them [m]."""

_SPEED = 0.5
"""Walking speed of people [m/s]."""

_EVERY = 4
"""Number of ticks of a run from one measured tick to the next."""


def tick_cases(
    scenario_name: str | None = None, group: str = "tick"
) -> list[Case]:
    """Makes benchmarks of ticks with the robot's states in a scenario's run.

    Args:
        scenario_name: Name or file of the scenario; None for the default
            scenario.
        group: Prefix of the benchmarks' names.
    """
    scenario = load_scenario(scenario_name)
    world = load_world(scenario)
    ticks = recorded_ticks(scenario, world)
    plain, verified = (
        ReactiveLaw.make(
            dc.replace(scenario.controller, verify=verify),
            world.robot,
            scenario.control_period,
        )
        for verify in (False, True)
    )
    bodies = _parts(ticks, world, verified)
    bodies |= _whole_ticks(ticks, world, plain, verified)
    return [Case(f"{group}: {name}", body) for name, body in bodies.items()]


def _parts(
    ticks: list[Tick], world: World, law: ReactiveLaw
) -> dict[str, Callable[[], object]]:
    """Returns benchmarks of the parts of a tick."""
    robot, field, reach = world.robot, world.field, law.collision.influence
    programs = [law.program(tick) for tick in ticks]
    return {
        f"oracle query, {len(robot.spheres)} spheres": in_turn(
            ticks, lambda tick: field.clearances(tick.state.spheres, reach)
        ),
        "kinematics and all Jacobians": in_turn(
            ticks, lambda tick: robot.state(tick.state.q)
        ),
        "program build": in_turn(ticks, law.program),
        "program solve": in_turn(programs, law.solver.solve),
    }


def _whole_ticks(
    ticks: list[Tick],
    world: World,
    plain: ReactiveLaw,
    verified: ReactiveLaw,
) -> dict[str, Callable[[], object]]:
    """Returns benchmarks of whole ticks, per solver and number of movers."""
    quick = verified.with_step(verified.dt, solver=ACTIVE_SET)

    def whole(law: ReactiveLaw, movers: Movers | None = None):
        return in_turn(
            ticks, lambda tick: whole_tick(law, world.field, tick, movers)
        )

    cases = {
        "whole, no verification": whole(plain),
        "whole, verified": whole(verified),
        "whole, verified, active set": whole(quick),
    }
    places = {"around": _bystanders(ticks), "in the way": _in_the_way(ticks)}
    for place, movers in places.items():
        people = f"{_PEOPLE} movers {place}"
        cases[f"whole, verified, {people}"] = whole(verified, movers)
        cases[f"whole, verified, active set, {people}"] = whole(quick, movers)
    return cases


def whole_tick(
    law: ReactiveLaw,
    field: DistanceField,
    tick: Tick,
    movers: Movers | None = None,
) -> TickReport:
    """Queries the map and computes a command, as the controller does.

    Args:
        law: The control law.
        field: The map.
        tick: Configuration, aim and previous command.
        movers: Moving obstacles; None if there are none.
    """
    q, reach = tick.state.q, law.collision.influence
    clearances = field.clearances(law.robot.spheres_at(q), reach)
    return run_tick(
        law,
        0.0,
        q,
        tick.aim,
        clearances,
        field,
        tick.u_previous,
        movers=movers,
    )


def _bystanders(ticks: list[Tick]) -> Movers:
    """Makes people who walk around all positions of the robot in its run."""
    p_WS = np.concatenate([tick.state.spheres.p_WS for tick in ticks])
    radius = np.tile(ticks[0].state.spheres.radius, len(ticks))
    center = 0.5 * (p_WS.min(axis=0) + p_WS.max(axis=0))
    away = np.linalg.norm((p_WS - center)[:, :2], axis=1) + radius
    return _ring(center, away.max() + _GAP + _STOUT)


def _in_the_way(ticks: list[Tick]) -> Movers:
    """Makes people around the robot that no command can avoid."""
    hand = np.mean([tick.state.X_WE[:3, 3] for tick in ticks], axis=0)
    return _ring(hand, _IN_THE_WAY)


def _ring(center: np.ndarray, away: float) -> Movers:
    """Makes people who walk around a point, in a ring."""
    people = []
    for angle in np.linspace(0.0, 2.0 * np.pi, _PEOPLE, endpoint=False):
        outwards = np.array([np.cos(angle), np.sin(angle), 0.0])
        along = np.array([-np.sin(angle), np.cos(angle), 0.0])
        X_WM = RigidTransform(center + away * outwards)
        people.append(
            Mover.capsule("person", X_WM, 0.4, _STOUT, v_WM=_SPEED * along)
        )
    return Movers(0.0, people)


def recorded_ticks(scenario: Scenario, world: World) -> list[Tick]:
    """Returns evenly spaced ticks of a headless run, with their inputs.

    Args:
        scenario: The scenario.
        world: The world of the scenario.
    """
    reports: list[TickReport] = []

    def keep(time: float, status: MotionStatus, report: TickReport | None):
        if report is not None and report not in reports[-1:]:
            reports.append(report)

    run(build(scenario, world), on_progress=keep).uninterrupted()
    ticks = []
    for before, report in pairwise(reports):
        state = world.robot.state(report.q)
        ticks.append(
            Tick(
                world.robot,
                state,
                report.aim,
                report.clearances,
                before.command,
                scenario.control_period,
            )
        )
    return ticks[::_EVERY]
