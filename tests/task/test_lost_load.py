"""An object that has slipped out of a hand is an obstacle from then on."""

import numpy as np
import pytest
from carried import HALF_HEIGHT, RADIUS, board, can_at, can_in_hand
from pydrake.math import RigidTransform

from remosplat_drake.base.errors import RemoSplatError
from remosplat_drake.oracle.object_field import ObjectField
from remosplat_drake.robot.hand_links import hand_links
from remosplat_drake.robot.sphere_model import Spheres
from remosplat_drake.task.job_maker import JobMaker
from remosplat_drake.task.lost_load import lost_load
from remosplat_drake.task.outline import outline
from remosplat_drake.task.task import Task, TaskState


@pytest.fixture
def lost(frankie) -> TaskState:
    """The state after a robot that held a can upright has lost it."""
    q = frankie.q_home
    objects = can_at(RigidTransform([2.0, 0.0, 0.4])), board(0.3)
    X_WE = frankie.end_effector_pose(q)
    upright = np.eye(4)
    upright[:3, 3] = X_WE[:3, 3]
    state = TaskState(
        objects,
        payload=can_in_hand(frankie, q),
        grip=0.06,
        X_OE=np.linalg.solve(upright, X_WE),
    )
    return lost_load(frankie, state, q)


def test_the_space_from_the_hand_to_the_floor_is_an_obstacle(frankie, lost):
    assert lost.held == "" and lost.lost == {"can"}
    p_WE = frankie.end_effector_pose(frankie.q_home)[:3, 3]
    can = lost.named("can")
    assert can in lost.in_map
    beside = p_WE + np.array([RADIUS + 0.1, 0.0, 0.0])
    for height in (0.0, 0.5 * p_WE[2], p_WE[2] + HALF_HEIGHT):
        spheres = Spheres.at(np.array([[*beside[:2], height]]))
        distance = ObjectField([can]).clearances(spheres).minimum()
        # The hull of a cylinder has finitely many planes.
        assert distance == pytest.approx(0.1, abs=0.002)
    above = Spheres.at(p_WE + np.array([0.0, 0.0, HALF_HEIGHT + 0.1]))
    distance = ObjectField([can]).clearances(above).minimum()
    assert distance == pytest.approx(0.1, abs=0.002)


def test_the_hand_may_leave_it_and_nothing_else_changes(frankie, lost):
    (rule,) = lost.rules
    assert rule.links == hand_links(frankie) and rule.stopping is None
    assert lost.named("board").X_WO.translation()[2] == pytest.approx(0.28)


def test_it_is_listed_as_lost(frankie, lost):
    task = Task(frankie, (), lost.objects, {})
    can, _ = outline(task, lost).objects
    assert can.text == "lost: its place is unknown" and not can.is_carried


def test_it_cannot_be_taken_again(lost):
    maker = object.__new__(JobMaker)  # The check needs no robot.
    with pytest.raises(RemoSplatError, match="the place of the can is unknown"):
        maker.take("can", lost, np.zeros(1), 0)
