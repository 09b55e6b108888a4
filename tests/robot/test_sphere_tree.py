"""Balls around spheres: they hold them, are small, and move with one link."""

import numpy as np
import pytest

from remosplat_drake.robot.robot_model import load_robot
from remosplat_drake.robot.sphere_tree import enclosing_ball


@pytest.mark.parametrize("name", ["panda", "frankie", "fetch"])
def test_each_sphere_is_in_a_ball_of_its_link(name):
    robot = load_robot(name)
    tree = robot.sphere_tree.values
    groups, n = len(tree.first) - 1, len(robot.spheres)
    assert sorted(tree.member) == list(range(groups, groups + n))
    np.testing.assert_array_equal(tree.p_LS[groups:], robot.spheres.p_LS)
    np.testing.assert_array_equal(tree.radius[groups:], robot.spheres.radius)
    for ball in range(groups):
        members = tree.member[tree.first[ball] : tree.first[ball + 1]]
        assert len(members)
        assert (tree.body[members] == tree.body[ball]).all()
        away = np.linalg.norm(tree.p_LS[members] - tree.p_LS[ball], axis=1)
        assert (away + tree.radius[members] <= tree.radius[ball] + 1e-12).all()
    assert groups < n


def test_a_ball_around_two_is_hardly_larger_than_it_must_be():
    """Radii of 0.1 m, 1 m apart: the least ball has a radius of 0.6 m."""
    centers = np.array([[0.0, 0, 0], [1, 0, 0]])
    center, radius = enclosing_ball(centers, np.full(2, 0.1))
    assert 0.6 <= radius < 0.62
    assert np.linalg.norm(center - [0.5, 0, 0]) < 0.02
