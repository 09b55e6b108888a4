"""Our own families: what stands where, and that everything varies."""

import numpy as np
import pytest

from remosplat_drake.generation.scene_generators import generate
from remosplat_drake.oracle.signed_distance import SignedDistanceField
from remosplat_drake.robot.sphere_model import Spheres

FRESH = ("table2", "bookshelf2", "posts")
SEEDS = range(60)


def test_cylinders_of_table2_stand_on_the_table():
    for seed in SEEDS:
        scene = generate("table2", seed)
        (top,) = scene.boxes
        assert len(scene.cylinders) == 6
        for cylinder in scene.cylinders:
            foot = cylinder.X_WP.translation()[2] - cylinder.half_height
            assert foot == pytest.approx(top.top)
            assert 0.02 <= cylinder.radius <= 0.07
        above = scene.X_WE_target.translation()[2] - top.top
        assert 0.08 <= above <= 0.25


def test_goals_of_bookshelf2_are_inside_the_shelf():
    for seed in SEEDS:
        scene = generate("bookshelf2", seed)
        lower, _, middle, _, _ = scene.boxes
        x, y, z = scene.X_WE_target.translation()
        assert 1.0 <= x <= 1.15 and abs(y) <= 0.25
        assert 0.05 <= z - lower.top <= 0.12
        assert z < middle.X_WP.translation()[2] - 0.2
        assert len(scene.cylinders) == 3


def test_posts_stand_on_the_floor_beside_a_level_goal():
    for seed in SEEDS:
        scene = generate("posts", seed)
        assert not scene.boxes and len(scene.cylinders) == 5
        for post in scene.cylinders:
            assert post.X_WP.translation()[2] == pytest.approx(post.half_height)
        approach_W = scene.X_WE_target.rotation().matrix()[:, 2]
        assert approach_W[2] == pytest.approx(0, abs=1e-12)
        assert approach_W[0] >= np.cos(0.4)
        goal = scene.X_WE_target.translation()
        sides = [
            post.X_WP.translation()[1] - goal[1] for post in scene.cylinders[:2]
        ]
        assert -0.24 <= sides[0] <= -0.14 and 0.14 <= sides[1] <= 0.24


def test_the_straight_way_out_of_a_room_leads_through_its_wall():
    blocked = 0
    for seed in SEEDS:
        scene = generate("room", seed)
        x, y, yaw = scene.X_WB_start
        goal = scene.X_WE_target.translation()
        way = goal[:2] - [x, y]
        assert 5 < np.linalg.norm(way) < 8
        # It faces away from the goal.
        assert way @ [np.cos(yaw), np.sin(yaw)] < 0
        above = Spheres.at(np.array([x, y, 0.9]), 0.3)
        assert SignedDistanceField(scene).clearances(above).minimum() > 0.5
        left, right = scene.boxes[4:6]
        gap = [
            left.X_WP.translation()[1] + left.half_extents[1],
            right.X_WP.translation()[1] - right.half_extents[1],
        ]
        assert 0.95 <= gap[1] - gap[0] <= 1.15
        at_wall = y - x * way[1] / way[0]
        blocked += not gap[0] + 0.25 < at_wall < gap[1] - 0.25
    assert blocked > 0.6 * len(SEEDS)


@pytest.mark.parametrize("family", FRESH)
def test_goal_and_start_vary(family):
    scenes = [generate(family, seed) for seed in SEEDS]
    goals = np.array([s.X_WE_target.translation() for s in scenes])
    starts = np.array([s.X_WB_start for s in scenes])
    assert (np.ptp(goals, axis=0) > 0.1).all()
    assert (np.ptp(starts, axis=0) > [0.35, 1.3, 1.0]).all()
