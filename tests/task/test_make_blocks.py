"""From the steps of a scenario to those of a task."""

import dataclasses as dc

import numpy as np
import pytest
from pydrake.math import RigidTransform

from remosplat_drake.base.errors import FieldError, RemoSplatError
from remosplat_drake.base.pose_config import PoseConfig
from remosplat_drake.robot.hand_links import hand_links
from remosplat_drake.task import step_configs as cfg
from remosplat_drake.task.make_blocks import (
    carried_objects,
    make_blocks,
)
from remosplat_drake.task.step import ATTACH, BASE_TO, RELEASE
from remosplat_drake.task.workshop import Workshop

GRASP = cfg.GraspConfig([0, 0, 0.05], width=0.06)
PICK = cfg.Pick(object="can", support="board", grasps=[GRASP, GRASP])
PLACE = cfg.Place(support="board", places=[PoseConfig([0.5, 0, 0.4])])


@pytest.fixture(scope="module")
def shop(frankie):
    names = ("can", "board")
    widths = {0: 0.08}
    return Workshop(frankie, names, {"can": 0.008}, widths, False, "file:entry")


def test_a_pick_has_a_way_for_each_grasp(shop, frankie):
    pick, place = make_blocks([PICK, PLACE], shop)
    assert pick.text == "pick the can" and len(pick.ways) == 2
    texts = [step.text for step in pick.ways[0]]
    assert texts == [
        "reaches for the can",
        "approaches the can",
        "grasps the can",
        "takes the can",
        "lifts the can",
    ]
    reach, approach, grasp, take, lift = pick.ways[0]
    assert reach.width == 0.08 and grasp.width == take.grip == 0.06
    assert reach.rules == () and take.action == ATTACH
    # The hand may touch the can, and the can what it stands on.
    (touching,) = approach.rules
    assert touching.links == hand_links(frankie) and touching.stopping is None
    (standing,) = lift.rules
    assert (standing.object, standing.links) == ("board", {"can"})
    assert standing.stopping == pytest.approx(-0.009)
    assert place.ways[0][2].action == RELEASE


def test_the_way_of_a_grasp_is_along_its_z_axis(shop):
    (pick,) = make_blocks([PICK], shop)
    before, at = (step.goal.X[:3, 3] for step in pick.ways[0][:2])
    assert at - before == pytest.approx([0, 0, 0.1])


def test_single_steps(shop):
    steps = [
        cfg.Open(),
        cfg.ReachTo([0, 0, 0.2], object="can"),
        cfg.Approach(distance=0.05),
        cfg.Close(width=0.06),
        cfg.Attach(object="can", support="board"),
        cfg.Lift(),
        cfg.MoveTo([0.5, 0.2, 0.6]),
        cfg.Release(),
        cfg.Retreat(distance=0.2),
    ]
    blocks = make_blocks(steps, shop)
    assert [len(block.ways) for block in blocks] == [1] * 9
    texts = [block.ways[0][0].text for block in blocks]
    assert texts[4:8] == [
        "takes the can",
        "lifts the can",
        "carries the can",
        "releases the can",
    ]
    assert blocks[2].ways[0][0].goal.X[:3, 3] == pytest.approx([0, 0, 0.05])
    assert blocks[8].ways[0][0].goal.X[:3, 3] == pytest.approx([0, 0, -0.2])
    assert carried_objects(steps) == ("can",)


@pytest.fixture(scope="module")
def two_hands(two_pandas):
    widths = {0: 0.08, 1: 0.07}
    names = ("can", "board")
    overhang = {"can": 0.008}
    return Workshop(two_pandas, names, overhang, widths, False, "file:entry")


LEFT_PICK = cfg.Pick(object="can", effector="left", grasps=[GRASP])


def test_a_hand_takes_over_from_another(two_hands, two_pandas):
    over = cfg.TakeOver(object="can", effector="right", grasps=[GRASP] * 2)
    place = cfg.Place(effector="right", places=[PoseConfig([0.5, 0, 0.4])])
    _, block, _ = make_blocks([LEFT_PICK, over, place], two_hands)
    assert len(block.ways) == 2
    steps = block.ways[0]
    texts = [(step.text, step.effector) for step in steps]
    assert texts == [
        ("reaches for the can", 1),
        ("approaches the can", 1),
        ("grasps the can", 1),
        ("takes the can", 1),
        ("lets the can go", 0),
        ("retreats from the can", 0),
    ]
    (touching,) = steps[1].rules
    assert touching.links == hand_links(two_pandas, 1)
    # Each hand opens as far as it goes.
    assert (steps[0].width, steps[4].width) == (0.07, 0.08)
    assert carried_objects([over]) == ("can",)


@pytest.mark.parametrize(
    ("steps", "message"),
    [
        (
            [cfg.TakeOver(object="can", effector="right", grasps=[GRASP])],
            r"tasks\[0\]\.object: no other hand holds the can at this step",
        ),
        (
            [
                LEFT_PICK,
                cfg.TakeOver(object="can", effector="left", grasps=[GRASP]),
            ],
            r"tasks\[1\]\.object: no other hand holds the can at this step",
        ),
        (
            [LEFT_PICK, cfg.TakeOver(object="can", effector="right")],
            r"tasks\[1\]\.grasps: give at least one",
        ),
        (
            [LEFT_PICK, cfg.MoveTo(effector="right")],
            r"tasks\[1\]\.effector: the hand left holds the can, not right",
        ),
        (
            [LEFT_PICK, cfg.Release(effector="right")],
            r"tasks\[1\]\.effector: the hand left holds the can, not right",
        ),
        (
            [LEFT_PICK, cfg.Open(effector="right", width=0.075)],
            r"tasks\[1\]\.width: the hand opens to 0\.07 m at most",
        ),
        (
            [LEFT_PICK, cfg.Lift(touch=[cfg.Touch("can", stopping=0.01)])],
            r"tasks\[1\]\.touch\[0\]\.stopping: leave it out",
        ),
    ],
)
def test_bad_hand_overs_end_in_one_line(two_hands, steps, message):
    with pytest.raises(FieldError, match=message) as error:
        make_blocks(steps, two_hands)
    assert "\n" not in str(error.value)


def test_a_base_drives_to_a_pose(shop):
    (block,) = make_blocks([cfg.DriveTo(base_pose=[1, 2, np.pi / 2])], shop)
    ((step,),) = block.ways
    assert step.goal is not None
    assert step.drives and step.goal.kind == BASE_TO
    wanted = [[0, -1, 0, 1], [1, 0, 0, 2], [0, 0, 1, 0], [0, 0, 0, 1]]
    np.testing.assert_allclose(step.goal.X, wanted, atol=1e-12)
    with pytest.raises(FieldError, match="base_pose"):
        cfg.DriveTo(base_pose=[1.0, 2.0])


def test_without_paths_a_base_drives_nowhere(shop):
    message = r"tasks\[0\]: needs planned paths: set controller\.guidance"
    with pytest.raises(FieldError, match=message):
        make_blocks([cfg.DriveTo()], dc.replace(shop, plans=False))


def test_a_robot_without_a_base_drives_nowhere(three_link):
    shop = Workshop(three_link, (), {}, {}, False, "file")
    message = r"tasks\[0\]: needs a mobile base, and the robot has none"
    with pytest.raises(FieldError, match=message):
        make_blocks([cfg.DriveTo()], shop)


def test_what_may_be_touched_is_named(shop, frankie):
    touch = [
        cfg.Touch("board", ["can"], 0.01),
        cfg.Touch("can"),
    ]
    (block,) = make_blocks([cfg.Lift(touch=touch)], shop)
    near, hand = block.ways[0][0].rules
    assert (near.links, near.stopping) == ({"can"}, 0.01)
    assert hand.links == hand_links(frankie) and hand.stopping is None


def test_a_carried_object_is_not_pressed_into_what_it_may_touch(shop):
    touch = cfg.Touch("board", ["can", "panda_hand"])
    (block,) = make_blocks([cfg.Lift(touch=[touch])], shop)
    can, hand = block.ways[0][0].rules
    assert can.links == {"can"}
    assert can.stopping == pytest.approx(-0.009)
    assert (hand.links, hand.stopping) == ({"panda_hand"}, None)


@pytest.mark.parametrize(
    ("steps", "message"),
    [
        ([cfg.Pick(object="cup")], r"tasks\[0\]\.object: unknown object 'cup'"),
        ([cfg.Pick(object="can")], r"tasks\[0\]\.grasps: give at least one"),
        (
            [cfg.Pick(object="can", grasps=[cfg.GraspConfig(width=0.1)])],
            r"tasks\[0\]\.grasps\[0\]\.width: the hand opens to 0\.08 m at",
        ),
        ([cfg.Open(width=0.2)], r"tasks\[0\]\.width: the hand opens to 0\.08"),
        ([PLACE], r"tasks\[0\]: no object is carried"),
        ([PICK, PICK], r"tasks\[1\]\.object: the can is still carried"),
        ([PICK, PLACE, PLACE], r"tasks\[2\]: no object is carried"),
        ([PICK, cfg.Place()], r"tasks\[1\]\.places: give at least one"),
        (
            [cfg.Attach(object="can", support="bord")],
            r"tasks\[0\]\.support: unknown object 'bord'",
        ),
        (
            [cfg.Lift(touch=[cfg.Touch("can", ["thumb"])])],
            r"tasks\[0\]\.touch\[0\]\.links: unknown link 'thumb'",
        ),
        (
            [cfg.Lift(touch=[cfg.Touch("cup")])],
            r"tasks\[0\]\.touch\[0\]\.object: unknown object 'cup'",
        ),
        (
            [cfg.Lift(effector="left")],
            r"tasks\[0\]\.effector: unknown end effector 'left'",
        ),
    ],
)
def test_bad_steps_end_in_one_line(shop, steps, message):
    with pytest.raises(FieldError, match=message) as error:
        make_blocks(steps, shop)
    assert "\n" not in str(error.value)


def test_a_robot_without_a_hand_grasps_nothing(three_link):
    shop = Workshop(three_link, ("can",), {"can": 0.0}, {}, False, "file")
    with pytest.raises(FieldError, match="the robot has no hand"):
        make_blocks([cfg.Open()], shop)


def test_a_hand_presses_where_something_stops_its_fingers(shop):
    for is_stopped, width in ((False, 0.06), (True, 0.05)):
        pick, _ = make_blocks(
            [PICK, PLACE], dc.replace(shop, is_stopped=is_stopped)
        )
        grasps, takes = pick.ways[0][2:4]
        assert grasps.width == pytest.approx(width)
        assert takes.grip == 0.06


def test_a_direction_is_one():
    with pytest.raises(FieldError, match="expected a direction"):
        cfg.Approach(along=[0.0, 0.0, 0.0])
    assert np.allclose(cfg.Retreat().along, [0, 0, -1])


def test_a_place_without_places_is_sought_on_the_support(shop):
    asked = []

    def places(*question):
        asked.append(question)
        return [RigidTransform([0.5, 0.1, 0.4])]

    place = cfg.Place(support="board", near=[0.5, 0.2, 0.0])
    finding = dc.replace(shop, places=places)
    _, block = make_blocks([PICK, place], finding)
    assert asked == [("can", "board", [0.5, 0.2, 0.0], 0)]
    assert block.ways[0][1].goal.X[:3, 3] == pytest.approx([0.5, 0.1, 0.4])

    def full(*_):
        raise RemoSplatError("the board is full")

    with pytest.raises(
        FieldError, match=r"tasks\[1\]\.support: the board is f"
    ):
        make_blocks([PICK, place], dc.replace(shop, places=full))
    with pytest.raises(FieldError, match=r"give at least one pose, or a s"):
        make_blocks([PICK, cfg.Place()], shop)
