"""A task on the robot, which is a process of its own behind the wire.

All take a minute or longer. That a silent hand has no width is tested in
`hardware/client/test_robot_link.py`, and that this ends a task that carries in
`task/test_advance_task.py`.
"""

import numpy as np
import pytest
from consenting import consenting
from pydrake.systems.framework import Context
from robot_process import Client, robot_process
from runs import PATIENT

from remosplat_drake.acceptance.hardware_processes import free_url
from remosplat_drake.app import warm_up
from remosplat_drake.app.diagram import build
from remosplat_drake.app.hardware_run import (
    HardwareResult,
    prepare_for_hardware,
    run_on_hardware,
)
from remosplat_drake.app.run_result import GIVEN_UP, REACHED
from remosplat_drake.app.scenario import load_scenario
from remosplat_drake.app.world import load_world
from remosplat_drake.task.task import TaskState
from remosplat_drake.task.task_system import TaskSystem


def drive(name: str, fault: str = "") -> tuple[HardwareResult, TaskState]:
    """Runs a task on the stand-in, and how far it has come.

    Args:
        name: The scenario.
        fault: What happens while the hand lifts the object; empty for nothing.
    """
    url, waiting = free_url(), [fault] if fault else []
    scenario = load_scenario(name, f"time_limit: 120{PATIENT}")
    prepare_for_hardware(scenario, url)
    world = load_world(scenario)
    warm_up.compile_kernels(scenario, world)
    with robot_process(url, name), consenting(url):
        client = Client(url)
        client.wait_for_robot()
        application = build(scenario, world, hardware=True)
        targets, states = application.targets, []
        assert isinstance(targets, TaskSystem)

        def look(root: Context) -> None:
            states.append(targets.state(targets.GetMyContextFromRoot(root)))
            if waiting and states[-1].held and states[-1].begun:
                client.inject(waiting.pop())

        result = run_on_hardware(application, between_ticks=look)
    return result, states[-1]


@pytest.mark.slow
def test_a_can_is_picked_and_placed_over_the_wire(lone_robot):
    result, state = drive("TablePick")
    assert result.run.outcome == REACHED
    assert not state.failures
    can = state.named("middle can")
    np.testing.assert_allclose(
        can.X_WO.translation(), [1.1, 0.5, 0.6755], atol=0.01
    )


@pytest.mark.slow
def test_a_can_that_falls_out_of_the_hand_ends_the_task(lone_robot):
    result, state = drive("TablePick", "hand-opens")
    reason = "the middle can has slipped out of the hand"
    assert result.run.outcome == f"{GIVEN_UP}: {reason}"
    assert state.failures == (reason,)


@pytest.mark.slow
def test_a_hand_that_falls_silent_ends_a_task_that_carries(lone_robot):
    result, state = drive("TablePick", "hand-status-stops")
    reason = "the hand's width is unknown while it holds the middle can"
    assert result.run.outcome == f"{GIVEN_UP}: {reason}"
    assert state.failures == (reason,)
