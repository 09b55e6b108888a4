"""The shipped tasks, judged by the true shapes at every tick."""

import numpy as np
import pytest
from runs import load_application
from true_shapes import load_clearances, robot_clearances, watched

from remosplat_drake.task.carrying import hand_links
from remosplat_drake.task.task import DONE, FAILED

USUAL = 0.021
"""The stopping distance [m]."""

MAP_ERROR = 0.003
"""By how much the splat over-estimates distances, measured [m]."""


@pytest.fixture(scope="module")
def table_pick():
    application = load_application("TablePick")
    return application, watched(application)


def test_the_can_is_put_where_it_shall_stand(table_pick):
    _, moments = table_pick
    state = moments[-1].state
    assert state.outcome == DONE and state.failures == ()
    X_WO = state.named("middle can").X_WO
    assert X_WO.translation() == pytest.approx([1.1, 0.5, 0.6355], abs=0.006)
    upright = X_WO.rotation().matrix()[2, 2]
    assert upright > np.cos(np.radians(1.5))


def test_the_hand_alone_touches_the_can_alone(table_pick):
    application, moments = table_pick
    robot = application.world.robot
    hand, least = hand_links(robot), {}
    for moment in moments[::4]:
        for pair, distance in robot_clearances(moment, robot).items():
            if moment.state.held != pair[1]:
                least[pair] = min(least.get(pair, np.inf), distance)
    for (link, name), distance in least.items():
        if name == "middle can" and link in hand:
            continue
        assert distance > 0.0, (link, name)
        if name != "middle can":
            assert distance > USUAL - MAP_ERROR, (link, name)


def test_the_can_keeps_its_distances_on_its_way(table_pick):
    application, moments = table_pick
    robot = application.world.robot
    held = [moment for moment in moments if moment.state.held]
    least = load_clearances(held, robot)
    # What it stands on it touches; the tall can it may pass more closely.
    assert -0.002 < least["table"] < 0.002
    assert 0.012 - 1e-6 < least["left can"] < USUAL
    solids = application.world.truth_field
    others = min(
        solids.clearances(
            robot.holding(m.state.payload).spheres_at(m.q)
        ).minimum()
        for m in held[::5]
    )
    assert others > USUAL - MAP_ERROR


@pytest.mark.slow
def test_a_place_that_is_taken_is_left_for_another():
    application = load_application(
        "TablePick",
        """
tasks:
- !Pick
  object: middle can
  support: table
  touch: [{object: left can, links: [middle can], stopping: 0.012}]
  grasps:
  - translation: [0, 0, 0.06]
    rotation: [[0, 1, 0], [0.9, 0, 0.4358899], [0.4358899, 0, -0.9]]
    width: 0.0596
  lift: [0, -0.04, 0.15]
- !Place
  support: table
  patience: 2.0
  places:
  - {translation: [1.04, -0.24, 0.6355]}
  - {translation: [1.1, 0.0, 0.6355]}
""",
    )
    state = watched(application)[-1].state
    assert state.outcome == DONE and len(state.failures) == 1
    assert "carries the middle can: not done within 2 s" in state.failures[0]
    p_WO = state.named("middle can").X_WO.translation()
    assert p_WO == pytest.approx([1.1, 0.0, 0.6355], abs=0.006)


def test_a_task_without_a_way_ends_with_its_reason():
    application = load_application(
        "TablePick",
        "{time_limit: 10, tasks: [!ReachTo {patience: 1.0,"
        " translation: [1.5, 0, 0.53]}]}",
    )
    state = watched(application)[-1].state
    assert state.outcome == FAILED
    assert "reaches: not done within 1 s" in state.failures[0]
