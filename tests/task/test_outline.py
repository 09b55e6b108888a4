"""A task as people read it, from step to step."""

import dataclasses as dc

import numpy as np
import pytest
from carried import around_can, board, can_at, can_in_hand
from pydrake.math import RigidTransform

from remosplat_drake.oracle.contact_rules import ContactRule
from remosplat_drake.robot.hand_links import hand_links
from remosplat_drake.signals import task_outline as lines
from remosplat_drake.task.outline import outline
from remosplat_drake.task.step import Block, Step
from remosplat_drake.task.task import DONE, FAILED, Task, TaskState

REACH, TAKE = Step("reaches for the can"), Step("takes the can")
LEAVE = Step("leaves the can")
PICK = Block("pick the can", ((REACH, TAKE), (TAKE,)))
HOME = Block("drives", ((Step("drives"),),))


@pytest.fixture
def task(frankie):
    things = (can_at(RigidTransform([0.6, 0, 0.4])), board(0.3))
    return Task(frankie, (PICK, HOME), things, {"can": around_can()})


def told(task, **changes):
    state = dc.replace(TaskState(task.objects, since=-np.inf), **changes)
    return outline(task, state)


def marks(shown):
    return [(line.text, line.state) for line in shown.lines]


def test_the_present_job_has_its_steps(task):
    shown = told(task, step=1)
    assert marks(shown) == [
        ("pick the can", lines.PRESENT),
        ("reaches for the can", lines.DONE),
        ("takes the can", lines.PRESENT),
        ("drives", lines.AHEAD),
    ]
    assert [line.is_step for line in shown.lines] == [False, True, True, False]


def test_a_job_of_one_step_is_one_line(task):
    assert marks(told(task, block=1)) == [
        ("pick the can", lines.DONE),
        ("drives", lines.PRESENT),
    ]


def test_another_way_and_the_way_out_are_shown(task):
    assert marks(told(task, way=1))[1:-1] == [("takes the can", lines.PRESENT)]
    assert marks(told(task, step=1, undoing=(LEAVE,)))[1:-1] == [
        ("leaves the can", lines.PRESENT)
    ]


def test_the_end_is_shown(task):
    ended = told(task, block=1, outcome=DONE)
    assert {state for _, state in marks(ended)} == {lines.DONE}
    failed = told(task, outcome=FAILED, failures=("the can has slipped",))
    assert marks(failed)[:2] == [
        ("pick the can", lines.FAILED),
        ("reaches for the can", lines.FAILED),
    ]
    assert failed.failures == ("the can has slipped",)


def test_objects_say_what_may_touch_them(task, frankie):
    rules = (
        ContactRule("can", hand_links(frankie)),
        ContactRule("board", frozenset({"can"}), -0.01),
    )
    can, shelf = told(task, rules=rules).objects
    assert (can.name, can.text) == ("can", "the hand may touch it")
    assert can.may_be_touched and not can.is_carried
    assert shelf.text == "can may touch it"
    _, near = told(
        task, rules=(ContactRule("board", frozenset({"can"}), 0.012),)
    ).objects
    assert near.text == "can may come as near as 12 mm"
    assert not near.may_be_touched
    (can, shelf) = told(
        task, payload=can_in_hand(frankie, frankie.q_home)
    ).objects
    assert (can.text, can.is_carried) == ("carried", True)
    assert shelf.text == "nothing may touch it" and not shelf.may_be_touched
