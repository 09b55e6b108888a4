"""A task from tick to tick, with a robot that is where a test puts it."""

import dataclasses as dc

import numpy as np
import pytest
from carried import around_can, board, can_at
from pydrake.math import RigidTransform, RollPitchYaw

from remosplat_drake.oracle.contact_rules import ContactRule
from remosplat_drake.robot.hand_links import hand_links
from remosplat_drake.signals.hand_reading import HandReading
from remosplat_drake.task.advance_task import Observation, advance_task
from remosplat_drake.task.step import (
    AT,
    ATTACH,
    BASE_TO,
    BY_WORLD,
    OBJECT_TO,
    ON_OBJECT,
    RELEASE,
    Block,
    Goal,
    Step,
)
from remosplat_drake.task.step_aim import aim_of
from remosplat_drake.task.task import DONE, FAILED, RUNNING, Task, TaskState

DT = 0.1
X_WO = RigidTransform([0.6, 0.0, 0.4])


def shifted(x=0.0, y=0.0, z=0.0):
    return RigidTransform([x, y, z]).GetAsMatrix4()


LEFT, RIGHT = 0, 1


class Stage:
    """A robot that is always where its task wants it, unless it is held."""

    def __init__(self, robot, *blocks, permission=lambda before, after, q: ""):
        self.task = Task(
            robot,
            tuple(blocks),
            (can_at(X_WO), board(0.3)),
            {"can": around_can()},
            permission,
        )
        self.state = TaskState(self.task.objects, since=-np.inf)
        self.time, self.q = 0.0, robot.q_home

    def tick(self, u=0.0, width=None, rate=0.0, right=None, v=0.0):
        n_u = self.task.robot.n_u
        hands = {} if width is None else {0: HandReading(width, rate, 0.0)}
        if right is not None:
            hands[RIGHT] = HandReading(right, rate, 0.0)
        u, v = np.full(n_u, u), np.full(n_u, v)
        now = Observation(self.time, self.q.copy(), v, u, hands)
        self.state = advance_task(self.task, self.state, now)
        self.time += DT
        return self.state

    @property
    def X_WE(self):
        return self.task.robot.end_effector_pose(self.q)

    @property
    def step(self):
        return self.state.present(self.task)


def at_home(robot, x=0.0):
    X_WE = robot.end_effector_pose(robot.q_home)
    return Goal(AT, shifted(x) @ X_WE)


def only(*steps):
    return Block("job", (steps,))


def test_a_step_begins_at_rest_and_ends_where_it_goes(frankie):
    stage = Stage(frankie, only(Step("reaches", goal=at_home(frankie))))
    assert not stage.tick(u=0.1).begun
    assert stage.tick().begun
    assert stage.tick().outcome == DONE
    assert stage.tick() is stage.state


def test_a_step_waits_for_a_robot_that_lags_behind_its_command(frankie):
    stage = Stage(frankie, only(Step("reaches", goal=at_home(frankie))))
    assert not stage.tick(v=-0.1).begun
    assert not stage.tick(v=np.nan).begun
    assert stage.tick(v=0.01).begun


def test_an_end_effector_elsewhere_has_not_arrived(frankie):
    goal = at_home(frankie, x=0.01)
    far = Step("reaches", goal=goal, position=0.005, patience=0.35)
    stage = Stage(frankie, only(far))
    stage.tick()
    for _ in range(3):
        assert stage.tick().outcome == RUNNING
    stage.tick()
    assert stage.tick().outcome == FAILED
    reason = "reaches: not finished within 0.35 s, 10 mm and 0 deg away"
    assert stage.state.failures == (reason,)


def test_the_next_step_waits_for_a_standstill(frankie):
    reach = Step("reaches", goal=at_home(frankie))
    rules = (ContactRule("can", frozenset({"panda_hand"})),)
    stage = Stage(frankie, only(reach, dc.replace(reach, rules=rules)))
    stage.tick()
    stage.tick(u=0.2)
    # The rules are still those of the step before.
    assert stage.tick(u=0.1).rules == () and not stage.state.begun
    assert stage.tick().rules == rules


def test_a_hand_is_done_when_it_is_as_wide_or_cannot_go_on(frankie):
    stage = Stage(frankie, only(Step("opens", width=0.08)))
    stage.tick(width=0.02)
    assert stage.state.told == {0: (0.08, 20.0)}
    assert stage.tick(width=0.05, rate=0.1).outcome == RUNNING
    assert stage.tick(width=0.0799, rate=0.1).outcome == DONE
    stage = Stage(frankie, only(Step("closes", width=0.0)))
    stage.tick(width=0.08)
    assert stage.tick(width=0.06, rate=0.0).outcome == RUNNING
    for _ in range(6):
        stage.tick(width=0.06, rate=0.0)
    assert stage.state.outcome == DONE


def carry(*more):
    """Takes a can that is where the hand is."""
    take = Step("takes the can", action=ATTACH, object="can")
    return only(take, *more)


def stage_with_can_in_hand(robot, *more):
    stage = Stage(robot, carry(*more))
    objects = stage.state.moved("can", stage.X_WE)
    stage.state = dc.replace(stage.state, objects=objects)
    return stage


def test_what_is_taken_leaves_the_map_and_comes_back_where_it_is(frankie):
    release = Step("releases", action=RELEASE, object="can")
    stage = stage_with_can_in_hand(frankie, release)
    stage.tick()
    assert stage.state.held == "can"
    assert [each.name for each in stage.state.in_map] == ["board"]
    stage.q = frankie.q_home + 0.05
    stage.tick()
    stage.tick()
    assert stage.state.held == ""
    there = stage.state.named("can").X_WO.GetAsMatrix4()
    assert there == pytest.approx(stage.X_WE)


def test_an_object_is_brought_to_a_pose(frankie):
    X_WG = RigidTransform(RollPitchYaw(0, 0, 0.3), [0.7, 0.2, 0.5])
    put = Step("carries", goal=Goal(OBJECT_TO, X_WG.GetAsMatrix4()))
    stage = stage_with_can_in_hand(frankie, put)
    # The hand holds it 2 cm above its middle.
    moved = stage.X_WE @ shifted(z=0.02)
    objects = stage.state.moved("can", moved)
    stage.state = dc.replace(stage.state, objects=objects)
    for _ in range(3):
        stage.tick()
    X_WE = X_WG.GetAsMatrix4() @ shifted(z=-0.02)
    np.testing.assert_allclose(stage.state.X_WT, X_WE, atol=1e-12)


def test_goals_are_relative_to_what_is_there_when_they_begin(frankie):
    near = Step("reaches", goal=Goal(ON_OBJECT, shifted(z=0.1), "can"))
    up = Step("lifts", goal=Goal(BY_WORLD, shifted(z=0.2)))
    stage = Stage(frankie, only(near), only(up))
    stage.tick()
    wanted = X_WO.GetAsMatrix4() @ shifted(z=0.1)
    np.testing.assert_allclose(stage.state.X_WT, wanted, atol=1e-12)
    stage.state = dc.replace(stage.state, block=1, begun=False, since=-1.0)
    stage.tick()
    lifted = shifted(z=0.2) @ stage.X_WE
    np.testing.assert_allclose(stage.state.X_WT, lifted, atol=1e-12)


def driving(robot, x, yaw):
    X_WB = RigidTransform(RollPitchYaw(0, 0, yaw), [x, 0, 0])
    goal = Goal(BASE_TO, X_WB.GetAsMatrix4())
    stage = Stage(robot, only(Step("drives", goal=goal, patience=1.0)))
    stage.q[2] = 2.0 * np.pi  # Turned once, which is no difference.
    stage.tick()
    return stage


def test_a_base_drives_with_the_arm_as_it_is(frankie):
    stage = driving(frankie, 1.0, 0.5)
    aim = aim_of(stage.task, stage.state, stage.q)
    assert aim.q == pytest.approx([1.0, 0.0, 0.5, *frankie.home])
    X_BE = frankie.end_effector_pose([0, 0, 0, *frankie.home])
    X_WT = RigidTransform(RollPitchYaw(0, 0, 0.5), [1.0, 0, 0])
    wanted = X_WT.GetAsMatrix4() @ X_BE
    np.testing.assert_allclose(aim.first.X_WT, wanted, atol=1e-9)
    stage.q[:3] = 1.004, 0.0, 0.51 - 2.0 * np.pi
    assert stage.tick().outcome == DONE


def test_a_base_elsewhere_has_not_arrived(frankie):
    stage = driving(frankie, 1.0, 0.5)
    stage.q[:3] = 1.004, 0.0, 0.53
    while stage.tick().outcome == RUNNING:
        pass
    reason = "drives: not finished within 1 s, 4 mm and 2 deg away"
    assert stage.state.failures == (reason,)


def test_a_base_has_not_arrived_before_the_arm_is_as_it_was(frankie):
    stage = driving(frankie, 1.0, 0.5)
    stage.q[:3] = 1.0, 0.0, 0.5
    stage.q[3] += 0.05
    assert stage.tick().outcome == RUNNING
    stage.q[3] -= 0.05
    assert stage.tick().outcome == DONE


def test_a_can_elsewhere_is_not_taken(frankie):
    stage = Stage(frankie, carry())
    stage.tick()
    assert stage.state.outcome == FAILED
    assert "the can is" in stage.state.failures[0]
    assert "away from the hand" in stage.state.failures[0]


def test_a_hand_that_has_closed_on_nothing_takes_nothing(frankie):
    take = Step("takes the can", action=ATTACH, object="can", grip=0.06)
    stage = Stage(frankie, only(take))
    objects = stage.state.moved("can", stage.X_WE)
    stage.state = dc.replace(stage.state, objects=objects)
    stage.tick(width=0.01)
    reason = "takes the can: the hand has closed without an object"
    assert stage.state.failures == (reason,) and stage.state.held == ""


def test_what_slips_out_of_the_hand_is_noticed(frankie):
    take = Step("takes the can", action=ATTACH, object="can", grip=0.06)
    stage = Stage(frankie, only(take, Step("lifts", goal=at_home(frankie, 1))))
    objects = stage.state.moved("can", stage.X_WE)
    stage.state = dc.replace(stage.state, objects=objects)
    for _ in range(3):
        stage.tick(width=0.058)
    assert stage.state.held == "can"
    # Pads give way: 4 mm less than when it took the can are not lost.
    stage.tick(width=0.054)
    assert stage.state.held == "can"
    stage.tick(width=0.05)
    assert stage.state.outcome == FAILED
    assert stage.state.failures[-1] == "the can has slipped out of the hand"


@pytest.mark.parametrize(
    ("width", "reason"),
    [
        (0.08, "the can has slipped out of the hand"),
        (np.nan, "the hand's width is unknown while it holds the can"),
    ],
)
def test_a_hand_that_opens_or_falls_silent_ends_the_task(
    frankie, width, reason
):
    take = Step("takes the can", action=ATTACH, object="can", grip=0.06)
    stage = Stage(frankie, only(take, Step("lifts", goal=at_home(frankie, 1))))
    objects = stage.state.moved("can", stage.X_WE)
    stage.state = dc.replace(stage.state, objects=objects)
    stage.tick(width=0.06)
    assert stage.state.held == "can"
    stage.tick(width=width)
    assert stage.state.outcome == FAILED
    assert stage.state.failures == (reason,)


def giving(two_pandas, *more, grip=None):
    """The left hand has taken the can, and the right one is at it, too."""
    take = Step("takes the can", action=ATTACH, object="can", grip=grip)
    over = dc.replace(take, text="takes it over", effector=RIGHT)
    stage = Stage(two_pandas, only(take, over, *more))
    objects = stage.state.moved("can", stage.X_WE)
    stage.state = dc.replace(stage.state, objects=objects)
    stage.tick(width=0.06, right=0.08)
    return stage


def test_a_can_goes_from_hand_to_hand(two_pandas):
    back = Step("retreats", goal=Goal(BY_WORLD, np.eye(4)))
    rest = Step("stays", effector=RIGHT)
    opens = Step("lets it go", width=0.08)
    stage = giving(two_pandas, opens, back, rest)
    left, right = hand_links(two_pandas), hand_links(two_pandas, RIGHT)
    assert stage.state.payload.holders == left
    assert stage.state.payload.link == "left_hand"
    # Both arms turn to the middle, where the hands are at one place.
    turn = np.arcsin(0.3 / stage.X_WE[0, 3])
    stage.q[[0, 7]] = -turn, turn
    X_WO = stage.X_WE
    stage.tick(width=0.06, right=0.06)
    stage.tick(width=0.06, right=0.06)
    assert stage.step.text == "takes it over" and stage.state.begun
    payload = stage.state.payload
    # The can is where the left hand has brought it, and the right one's now.
    assert (stage.state.load, payload.link) == (("can", RIGHT), "right_hand")
    body = two_pandas.tree.index("right_hand")
    X_WL = two_pandas.body_poses(stage.q)[body]
    np.testing.assert_allclose(X_WL @ payload.X_LO, X_WO, atol=1e-9)
    # The left hand may touch it until it has retreated.
    holders = {}
    while stage.tick(width=0.08, right=0.06).outcome == RUNNING:
        holders.setdefault(stage.step.text, stage.state.payload.holders)
    assert stage.state.outcome == DONE
    assert holders["lets it go"] == holders["retreats"] == left | right
    assert stage.state.payload.holders == right
    assert stage.state.told == {LEFT: (0.08, 20.0)}


def test_a_hand_far_away_takes_nothing_over(two_pandas):
    stage = giving(two_pandas)
    while stage.tick(width=0.06, right=0.06).outcome == RUNNING:
        pass
    (reason,) = stage.state.failures
    assert reason.startswith("takes it over: the can is")
    assert stage.state.load == ("can", LEFT)


def test_the_width_of_the_hand_that_holds_is_watched(two_pandas):
    stage = giving(two_pandas, grip=0.06)
    assert stage.tick(width=0.06, right=0.0).outcome == RUNNING
    stage.tick(width=0.05, right=0.06)
    assert stage.state.failures[-1] == "the can has slipped out of the hand"


def test_what_is_carried_may_be_touched_while_a_step_says_so(two_pandas):
    right = hand_links(two_pandas, RIGHT)
    rules = (ContactRule("can", right),)
    near = Step("closes", effector=RIGHT, width=0.06, rules=rules)
    away = Step("opens", effector=RIGHT, width=0.08)
    take = Step("takes the can", action=ATTACH, object="can")
    stage = Stage(two_pandas, only(take, near, away))
    objects = stage.state.moved("can", stage.X_WE)
    stage.state = dc.replace(stage.state, objects=objects)
    holders = {}
    while stage.tick(width=0.06, right=0.06).outcome == RUNNING:
        holders[stage.step.text] = stage.state.payload.holders
        if stage.step is away and stage.state.begun:
            break
    assert holders["closes"] == hand_links(two_pandas) | right
    assert holders["opens"] == hand_links(two_pandas)


def test_a_hand_reaches_for_what_another_one_carries(two_pandas):
    goal = Goal(ON_OBJECT, shifted(z=0.1), "can")
    reach = Step("reaches", effector=RIGHT, goal=goal)
    take = Step("takes the can", action=ATTACH, object="can")
    stage = Stage(two_pandas, only(take, reach))
    objects = stage.state.moved("can", stage.X_WE)
    stage.state = dc.replace(stage.state, objects=objects)
    stage.tick()
    stage.q[0] += 0.2
    stage.tick()
    stage.tick()
    wanted = stage.X_WE @ shifted(z=0.1)
    np.testing.assert_allclose(stage.state.X_WT, wanted, atol=1e-9)


def test_a_refusal_is_a_failure_and_changes_nothing(frankie):
    stage = stage_with_can_in_hand(frankie)
    refusing = dc.replace(
        stage.task, permission=lambda before, after, q: "too near"
    )
    stage.task = refusing
    stage.tick()
    assert stage.state.held == ""
    assert stage.state.failures == ("takes the can: too near",)


def test_another_way_is_tried_after_the_way_out(frankie):
    out = Step("leaves", goal=at_home(frankie))
    far = Step(
        "approaches", goal=at_home(frankie, 1.0), patience=0.1, undo=(out,)
    )
    near = Step("reaches", goal=at_home(frankie))
    stage = Stage(frankie, Block("job", ((far,), (near,))))
    texts = []
    while stage.tick().outcome == RUNNING:
        texts.append(stage.step.text)
    assert list(dict.fromkeys(texts)) == ["approaches", "leaves", "reaches"]
    assert stage.state.outcome == DONE
    assert len(stage.state.failures) == 1


def test_no_other_way_is_tried_with_something_in_the_hand(frankie):
    far = Step("lifts", goal=at_home(frankie, 1.0), patience=0.1)
    stage = stage_with_can_in_hand(frankie, far)
    blocks = stage.task.blocks
    ways = Block("job", (*blocks[0].ways, *blocks[0].ways))
    stage.task = dc.replace(stage.task, blocks=(ways,))
    while stage.tick().outcome == RUNNING:
        pass
    assert stage.state.outcome == FAILED
    assert stage.state.held == "can"


def test_a_lost_configuration_changes_nothing(frankie):
    stage = Stage(frankie, only(Step("reaches", goal=at_home(frankie))))
    stage.q = np.full(frankie.n_q, np.nan)
    before = stage.state
    assert stage.tick() is before
