"""The pairs of links that are watched, and those left out by name."""

import numpy as np
import pytest

from remosplat_drake.base.errors import FieldError, FileError
from remosplat_drake.robot.robot_description import shipped_robots
from remosplat_drake.robot.robot_model import load_robot
from remosplat_drake.robot.self_collision.link_pairs import (
    ADJACENT,
    ALLOWED,
    ALWAYS,
    pairs_between,
)
from remosplat_drake.robot.self_collision.pairs import self_collision_pairs
from remosplat_drake.robot.srdf import read_disabled_collisions
from tests.robot.conftest import THREE_LINK

PAIR = ("upper_arm", "wrist")
SRDF = """<?xml version="1.0"?>
<robot name="x">
  <group name="arm"/>
  <disable_collisions link1="wrist" link2="upper_arm" reason="Never"/>
  <disable_collisions link1="elsewhere" link2="wrist"/>
</robot>
"""


def found(robot):
    return self_collision_pairs(robot, 0.01).found


def test_links_two_joints_apart_are_watched(make_arm):
    pairs = found(make_arm())
    assert pairs.watched == (PAIR,)
    assert pairs.left_out == {
        ("upper_arm", "forearm"): ADJACENT,
        ("forearm", "wrist"): ADJACENT,
    }


def test_a_pair_that_never_touches_is_known_and_watched(make_arm):
    # At the elbow's limit 0.4 sin(2.5) - 0.03 = 0.209 m are left.
    pairs = found(make_arm(0.2))
    assert pairs.never == pairs.watched == (PAIR,)


def test_a_pair_that_touches_sometimes_is_watched(make_arm):
    # Beyond 2.366 rad, as in 5 % of the elbow's range.
    pairs = found(make_arm(0.25))
    assert pairs.watched == (PAIR,)
    assert not pairs.never
    assert pairs.contacts[PAIR] == pytest.approx(0.054, abs=0.02)


def test_a_pair_that_always_overlaps_is_left_out(make_arm):
    pairs = found(make_arm(0.42))
    assert pairs.left_out[PAIR] == ALWAYS
    assert not pairs.watched


def test_the_samples_are_always_the_same(make_arm):
    one, other = found(make_arm(0.25)), found(make_arm(0.25))
    assert one is not other
    assert one.contacts == other.contacts


@pytest.mark.parametrize("order", ["[wrist, upper_arm]", "[upper_arm, wrist]"])
def test_the_description_allows_collisions(make_arm, order):
    robot = make_arm(0.25, f"allowed_collisions: [{order}]\n")
    assert found(robot).left_out[PAIR] == ALLOWED
    pairs = self_collision_pairs(robot, 0.01)
    assert len(pairs) == 0
    assert not len(pairs.near(robot.body_poses(robot.q_home), 1.0))
    assert pairs.distances(robot.q_home).shape == (0,)


def test_an_srdf_file_allows_collisions(make_arm, tmp_path):
    (tmp_path / "x.srdf").write_text(SRDF)
    assert found(make_arm(0.25, "srdf: x.srdf\n")).left_out[PAIR] == ALLOWED


@pytest.mark.parametrize(
    ("line", "problem"),
    [
        ("[[wrist, elbow]]", r"\[0\].*unknown link 'elbow'.*upper_arm"),
        ("[[wrist]]", r"\[0\].*expected 2 entries, got 1"),
        ("[[wrist, 3]]", r"\[0\]\[1\].*expected text, got '3'"),
    ],
)
def test_who_allows_what_is_none_is_told_so_in_one_line(
    make_arm, line, problem
):
    with pytest.raises(FieldError, match=problem) as error:
        make_arm(0.03, f"allowed_collisions: {line}\n")
    assert "arm.yaml" in str(error.value)
    assert "allowed_collisions" in str(error.value)
    assert "\n" not in str(error.value)


@pytest.mark.parametrize(
    ("text", "problem"),
    [
        ("<robot><disable", "is not an SRDF file"),
        ("<model/>", "its root is <model>, not <robot>"),
        (
            '<robot><disable_collisions link1="a"/></robot>',
            "<disable_collisions> number 1 has no link2",
        ),
    ],
)
def test_a_broken_srdf_file_is_named(make_arm, tmp_path, text, problem):
    path = tmp_path / "x.srdf"
    path.write_text(text)
    with pytest.raises(FileError, match=problem) as error:
        read_disabled_collisions(path)
    assert str(path) in str(error.value)
    assert "\n" not in str(error.value)
    with pytest.raises(FileError):
        found(make_arm(0.03, "srdf: x.srdf\n"))


def test_an_srdf_file_that_is_missing_is_named(make_arm):
    with pytest.raises(FileError, match=r"y\.srdf"):
        found(make_arm(0.03, "srdf: y.srdf\n"))


@pytest.mark.parametrize("name", shipped_robots())
def test_nothing_on_a_shipped_robot_is_left_out_by_its_shapes(name):
    pairs = found(load_robot(name))
    assert set(pairs.left_out.values()) == {ADJACENT}
    assert np.mean([p in pairs.never for p in pairs.watched]) < 0.6


def test_pairs_on_the_way_are_two_joints_apart():
    arm = load_robot(THREE_LINK)
    links = ("mount", "wrist")
    found = pairs_between(arm, links, arm.tree.names)
    assert found == [("mount", "forearm"), ("upper_arm", "wrist")]
    assert pairs_between(arm, links, {*links, "forearm"}) == found[:1]


def test_the_way_between_two_arms_leads_through_what_carries_them():
    robot = load_robot("two_pandas")
    links = ("left_link1", "right_link1")
    assert not pairs_between(robot, links, robot.tree.names)
    found = pairs_between(
        robot, ("left_link2", "right_link1"), robot.tree.names
    )
    # All others on the way are at most a joint apart.
    assert set(found) == {
        ("left_link1", "right_link1"),
        ("bench", "left_link2"),
        ("left_link0", "left_link2"),
        ("right_link0", "left_link2"),
    }
