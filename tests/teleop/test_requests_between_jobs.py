"""Requests that arrive while the robot brakes after a job."""

import dataclasses as dc

import numpy as np
import pytest
from pydrake.math import RigidTransform

from remosplat_drake.oracle.object_field import ObjectField
from remosplat_drake.scene.objects.scene_object import SceneObject
from remosplat_drake.scene.primitive_scene import Box
from remosplat_drake.signals.operator_command import OperatorCommand
from remosplat_drake.task.advance_task import Observation
from remosplat_drake.task.job_search import FoundJob
from remosplat_drake.task.step import Block
from remosplat_drake.task.task import FAILED, Task, TaskState
from remosplat_drake.teleop.operator_jobs import Jobs, advance_jobs

BEFORE = OperatorCommand()
TAKE = dc.replace(BEFORE, takes=1, thing="can")
EMPTY = (Block("pick the can", ((),)),)
FOUND = FoundJob(EMPTY)


@pytest.fixture
def braking(three_link) -> Jobs:
    can = SceneObject("can", Box(RigidTransform(), np.full(3, 0.03)))
    task = Task(three_link, EMPTY, (can,), {})
    state = TaskState((can,), failures=("given up",), outcome=FAILED)
    return Jobs(task, state, BEFORE, is_braking=True)


def advance(
    jobs,
    command,
    speed,
    *,
    is_stopped=False,
    found: FoundJob | None = FOUND,
) -> Jobs:
    axes = np.full(3, speed)
    now = Observation(0.0, np.zeros(3), axes, axes)
    return advance_jobs(
        lambda request, scene: found,
        jobs,
        command,
        now,
        ObjectField(()),
        is_stopped=is_stopped,
    )


def test_a_request_waits_until_the_robot_is_at_rest(braking):
    jobs = advance(braking, TAKE, 0.1)
    assert jobs.is_braking and not jobs.runs
    assert advance(jobs, TAKE, 0.0).runs


def test_hold_and_stop_cancel_a_request_that_waits(braking):
    jobs = advance(braking, TAKE, 0.1)
    held = dc.replace(TAKE, holds=1)
    after = advance(jobs, held, 0.1)
    assert not advance(after, held, 0.0).runs
    after = advance(jobs, TAKE, 0.1, is_stopped=True)
    assert not advance(after, TAKE, 0.0).runs


def test_the_robot_is_held_while_grasps_are_searched(braking):
    jobs = advance(braking, TAKE, 0.0, found=None)
    assert jobs.leads and not jobs.runs
    assert jobs.text == "hold: pick the can: searches how"
    # The request stays the same object, by which a search is recognised.
    assert advance(jobs, TAKE, 0.0, found=None).wanted is jobs.wanted
    assert advance(jobs, TAKE, 0.0).runs


def test_hold_and_stop_end_a_search(braking):
    jobs = advance(braking, TAKE, 0.0, found=None)
    held = dc.replace(TAKE, holds=1)
    for after in (
        advance(jobs, held, 0.0),
        advance(jobs, TAKE, 0.0, is_stopped=True),
    ):
        assert after.is_braking and after.wanted is None
        assert after.state.outcome == FAILED


def test_a_search_without_a_result_states_the_reason(braking):
    found = FoundJob(problem="the can is out of reach")
    jobs = advance(braking, TAKE, 0.0, found=found)
    assert jobs.text == "hold: pick the can: the can is out of reach"
    assert not advance(jobs, TAKE, 0.0).leads
