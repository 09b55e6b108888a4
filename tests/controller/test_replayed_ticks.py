"""Commands of a robot's ticks are those of a simulation and of a rollout."""

import inspect
from typing import Any

import numpy as np
import pytest
from consenting import consenting
from pydrake.common.value import Value
from pydrake.systems.analysis import Simulator
from robot_process import robot_process
from runs import PATIENT

from remosplat_drake.acceptance.hardware_processes import free_url
from remosplat_drake.app import warm_up
from remosplat_drake.app.diagram import build
from remosplat_drake.app.hardware_run import (
    prepare_for_hardware,
    run_on_hardware,
)
from remosplat_drake.app.run_result import REACHED
from remosplat_drake.app.scenario import Scenario, load_scenario
from remosplat_drake.app.world import load_world
from remosplat_drake.controller import reactive_controller
from remosplat_drake.controller.guidance.rollout import (
    Rollout,
    advance_rollout,
)
from remosplat_drake.controller.guidance.selection import Selection
from remosplat_drake.controller.reactive_controller import ReactiveController
from remosplat_drake.controller.tick.reactive_law import ReactiveLaw
from remosplat_drake.controller.tick.run_tick import run_tick
from remosplat_drake.signals.binding import COLLISION
from remosplat_drake.signals.tick_report import TickReport

Tick = tuple[dict[str, Any], TickReport]
"""What `run_tick` was given, by name, and what it returned."""


def run_recorded(name: str, scenario: Scenario, monkeypatch) -> list[Tick]:
    """All ticks of a run on the stand-in robot, until its target is reached."""
    ticks: list[Tick] = []

    def run_and_record(*arguments, **named) -> TickReport:
        given = inspect.signature(run_tick).bind(*arguments, **named)
        report = run_tick(*arguments, **named)
        ticks.append((given.arguments, report))
        return report

    url, world = scenario.hardware.lcm_url, load_world(scenario)
    with (
        robot_process(url, name),
        consenting(url),
        monkeypatch.context() as patch,
    ):
        warm_up.compile_kernels(scenario, world)
        application = build(scenario, world, hardware=True)
        patch.setattr(reactive_controller, "run_tick", run_and_record)
        done = run_on_hardware(application)
    assert done.run.outcome == REACHED
    return ticks


def simulated(
    controller: ReactiveController, period: float, tick: Tick
) -> np.ndarray:
    """What a simulation's controller commands, told the same at that time."""
    given, report = tick
    context = controller.CreateDefaultContext()
    values = {
        "configuration": report.q,
        "clearances": Value(given["clearances"]),
        "distance_field": Value[object](given["field"]),
        "aim": Value[object](report.aim),
        "selection": Value(Selection(given["guidance"])),
        "velocity_executed": given["u_previous"],
        "motion": Value[object](given["motion"]),
    }
    if given["movers"] is not None:  # No Value holds None in Drake 1.58.
        values["movers"] = Value[object](given["movers"])
    for name, value in values.items():
        controller.GetInputPort(name).FixValue(context, value)
    context.SetTime(report.time - 0.5 * period)
    simulator = Simulator(controller, context)
    simulator.AdvanceTo(report.time)
    simulator.AdvancePendingEvents()
    return controller.GetOutputPort("velocity_commanded").Eval(context)


def rolled_out(law: ReactiveLaw, tick: Tick) -> np.ndarray:
    """What a rollout from there commands first; it asks the map by itself."""
    given, report = tick
    start = Rollout(
        given["guidance"],
        report.q,
        given["u_previous"],
        movers=given["movers"],
        start=report.time,
        motion=given["motion"].arrays,
    )
    after = advance_rollout(
        law, start, given["field"], report.aim, lambda error: False, 60.0
    )
    return after.u


@pytest.mark.parametrize(
    ("name", "solver"),
    [
        pytest.param("TableReach", "clarabel", marks=pytest.mark.slow),
        ("PandaReach", "active_set"),
    ],
)
def test_one_tick_drives_robot_simulation_and_rollout(
    name, solver, lone_robot, monkeypatch
):
    """The same solver, period and inputs give the same to the last bit."""
    # Gentle gains keep the robot near its obstacles for longer.
    controller = f"{{solver: {solver}, gains: tuned}}"
    scenario = load_scenario(
        name, f"time_limit: 60\ncontroller: {controller}{PATIENT}"
    )
    prepare_for_hardware(scenario, free_url())
    ticks = run_recorded(name, scenario, monkeypatch)
    # What has been found ahead is among the inputs.
    scenario.controller.guidance.asynchronous = False
    simulation = build(scenario)
    law, moving, bound = simulation.law, 0, 0
    for tick in ticks:
        given, report = tick
        if given["periods"] > 1.0:
            continue  # A simulation is never late.
        for command in (
            simulated(simulation.controller, law.dt, tick),
            rolled_out(law, tick),
        ):
            np.testing.assert_array_equal(command, report.command)
        moving += given["u_previous"].any()
        bound += any(row[0] == COLLISION for row in report.binding.rows)
    assert moving > 100
    assert bound > 10
