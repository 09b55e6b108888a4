"""Links that face each other are near at more points than one."""

import numpy as np
import pytest

from remosplat_drake.robot.robot_description import shipped_robots
from remosplat_drake.robot.robot_model import load_robot
from remosplat_drake.robot.self_collision.pairs import self_collision_pairs

DEEP = -0.02

PLATES = """
<robot name="plates">
  <link name="foot"/>
  <link name="lower"><collision><geometry><box size="0.2 0.2 0.02"/>
    </geometry></collision></link>
  <link name="between"/>
  <link name="upper"><collision><geometry><box size="0.1 0.1 0.02"/>
    </geometry></collision></link>
  <joint name="lift" type="prismatic"><parent link="foot"/>
    <child link="lower"/><axis xyz="0 0 1"/>
    <limit lower="-1" upper="1" effort="1" velocity="1"/></joint>
  <joint name="pitch" type="revolute"><parent link="lower"/>
    <child link="between"/><origin xyz="0 0 0.05"/><axis xyz="0 1 0"/>
    <limit lower="-2" upper="2" effort="1" velocity="1"/></joint>
  <joint name="roll" type="revolute"><parent link="between"/>
    <child link="upper"/><axis xyz="1 0 0"/>
    <limit lower="-2" upper="2" effort="1" velocity="1"/></joint>
</robot>
"""
DESCRIPTION = """
name: plates
model: plates.urdf
arm: {joints: [lift, pitch, roll], mount: foot}
end_effector_frame: upper
velocity_limits: [1, 1, 1]
acceleration_limits: [10, 10, 10]
home: [0, 0, 0]
spheres: {covering: spheres.yaml}
"""


@pytest.fixture
def plates(tmp_path):
    """A small plate that tilts 0.03 m above a larger one."""
    write_plates(tmp_path, PLATES)
    return load_robot(tmp_path / "plates.yaml")


def write_plates(folder, urdf, home="[0, 0, 0]"):
    (folder / "plates.urdf").write_text(urdf)
    (folder / "plates.yaml").write_text(
        DESCRIPTION.replace("home: [0, 0, 0]", f"home: {home}")
    )
    (folder / "spheres.yaml").write_text(
        "spheres: {lower: [[0, 0, 0, 0.15]], upper: [[0, 0, 0, 0.08]]}"
    )


def near(robot, q, within=0.2):
    pairs = self_collision_pairs(robot, 0.0)
    return pairs.near(robot.body_poses(np.array(q, float)), within)


def test_plates_are_near_at_all_corners(plates):
    found = near(plates, [0, 0, 0])
    np.testing.assert_allclose(found.distance, 0.03, atol=1e-12)
    np.testing.assert_allclose(found.normal_W, [[0, 0, 1]] * len(found))
    np.testing.assert_allclose(found.p_WB[:, 2] - found.p_WA[:, 2], 0.03)
    corners = {tuple(p) for p in np.round(found.p_WB[:, :2], 9).tolist()}
    assert corners >= {(x, y) for x in (-0.05, 0.05) for y in (-0.05, 0.05)}


@pytest.mark.parametrize("pitch", [-0.03, -1e-4, 1e-4, 0.03])
def test_the_corner_that_is_not_nearest_is_known_too(plates, pitch):
    """Its distance is its own: 0.1 m sin(pitch) more than the nearest."""
    found = near(plates, [0, pitch, 0])
    assert found.distance[0] == pytest.approx(found.distance.min())
    side = np.sign(pitch) * found.p_WB[:, 0]
    near_side, far_side = side > 0.04, side < -0.04
    assert near_side.any()
    assert far_side.any()
    drop = 0.01 * np.cos(pitch) + 0.05 * np.sin(abs(pitch))
    np.testing.assert_allclose(
        found.distance[near_side], 0.04 - drop, rtol=0.02
    )
    drop = 0.01 * np.cos(pitch) - 0.05 * np.sin(abs(pitch))
    np.testing.assert_allclose(found.distance[far_side], 0.04 - drop, rtol=0.02)


def test_what_is_tilted_more_is_near_at_one_side(plates):
    found = near(plates, [0, 0.15, 0])
    assert (found.p_WB[:, 0] > 0.04).all()


def test_far_links_are_near_at_one_place(plates):
    # Farther than the share of `within` at which links are turned.
    assert len(near(plates, [0, 0, 0], 0.05)) == 1
    assert len(near(plates, [0, 0, 0], 0.03)) == 0


TWO_SHAPES = PLATES.replace(
    """<link name="upper">""",
    """<link name="upper"><collision><origin xyz="0 0 0.025"/><geometry>
    <box size="0.1 0.1 0.02"/></geometry></collision>""",
)
"""The upper link is two plates, the second one 25 mm above the first."""


def test_all_shapes_that_are_too_near_are_noted(tmp_path):
    write_plates(tmp_path, TWO_SHAPES)
    robot = load_robot(tmp_path / "plates.yaml")
    pairs = self_collision_pairs(robot, 0.0)
    X_WL = robot.body_poses(np.zeros(3))
    nearest = pairs.near(X_WL, 0.2)
    assert len(set(nearest.pair)) == 1
    # 30 and 55 mm above the lower plate.
    for crowded, gaps in ((0.05, {0.03}), (0.06, {0.03, 0.055})):
        found = pairs.near(X_WL, 0.2, crowded)
        assert {round(d, 6) for d in found.distance} == gaps
        of_each = [found.p_WB[found.pair == k] for k in set(found.pair)]
        assert len(of_each) == len(gaps)
        for p_WB in of_each:
            # Each by all of its corners.
            corners = {tuple(p) for p in np.round(p_WB[:, :2], 9).tolist()}
            assert len(corners) >= 4


@pytest.mark.parametrize("name", shipped_robots())
def test_the_nearest_is_among_them_for_each_pair_of_links(name):
    robot = load_robot(name)
    pairs = self_collision_pairs(robot, 0.01)
    rng = np.random.default_rng(2)
    arm = np.isfinite(robot.position_lower)
    lower = np.where(arm, robot.position_lower, 0.0)
    upper = np.where(arm, robot.position_upper, 0.0)
    seen = 0
    for q in rng.uniform(lower, upper, (100, robot.n_q)):
        exact = {}
        for k, distance in enumerate(pairs.distances(q)):
            links = pairs.links(k)
            exact[links] = min(exact.get(links, np.inf), distance)
        found = pairs.near(robot.body_poses(q), 0.1)
        least = {}
        for k, distance in zip(found.pair, found.distance, strict=True):
            links = pairs.links(k)
            least[links] = min(least.get(links, np.inf), distance)
        # Of links that overlap deeply, one overlap of their shapes will do.
        assert {k: max(d, DEEP) for k, d in least.items()} == pytest.approx(
            {k: max(d, DEEP) for k, d in exact.items() if d < 0.1}, abs=1e-9
        )
        seen += len(found)
        gap = np.vecdot(found.p_WB - found.p_WA, found.normal_W)
        # The points of a ball are its centre.
        radius = pairs.shapes.radius
        for ends in (pairs.pairs.first, pairs.pairs.second):
            gap = gap - radius[ends[found.pair]]
        np.testing.assert_allclose(gap, found.distance, atol=1e-9)
    assert seen > 200


def test_what_is_small_is_as_deep_as_what_it_is_in(tmp_path):
    """A ball in the middle of a plate is no nearer to the outside than that."""
    ball = '<origin xyz="0 0 -0.05"/><geometry><sphere radius="0.002"/>'
    plate = '<geometry><box size="0.1 0.1 0.02"/>'
    write_plates(tmp_path, PLATES.replace(plate, ball), home="[0, 1.5, 0]")
    robot = load_robot(tmp_path / "plates.yaml")
    pairs = self_collision_pairs(robot, 0.0)
    for enough in (-0.005, np.inf):
        found = pairs.distances(np.zeros(3), enough)
        np.testing.assert_allclose(found, -0.012, atol=1e-9)
