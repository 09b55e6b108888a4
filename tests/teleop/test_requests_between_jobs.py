"""Requests that arrive while the robot brakes after a job."""

import dataclasses as dc

import numpy as np
import pytest
from pydrake.math import RigidTransform

from remosplat_drake.scene.objects.scene_object import SceneObject
from remosplat_drake.scene.primitive_scene import Box
from remosplat_drake.signals.operator_command import OperatorCommand
from remosplat_drake.task.advance_task import Observation
from remosplat_drake.task.step import Block
from remosplat_drake.task.task import FAILED, Task, TaskState
from remosplat_drake.teleop.operator_jobs import Jobs, advance_jobs

BEFORE = OperatorCommand()
TAKE = dc.replace(BEFORE, takes=1, thing="can")
EMPTY = (Block("pick the can", ((),)),)


class Maker:
    """Makes jobs without steps."""

    def take(self, *_):
        return EMPTY


@pytest.fixture
def braking(three_link) -> Jobs:
    can = SceneObject("can", Box(RigidTransform(), np.full(3, 0.03)))
    task = Task(three_link, EMPTY, (can,), {})
    state = TaskState((can,), failures=("given up",), outcome=FAILED)
    return Jobs(task, state, BEFORE, is_braking=True)


def advance(jobs, command, speed, *, is_stopped=False) -> Jobs:
    axes = np.full(3, speed)
    now = Observation(0.0, np.zeros(3), axes, axes)
    return advance_jobs(Maker(), jobs, command, now, is_stopped=is_stopped)


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
