"""Targets of several end effectors."""

import copy

import numpy as np
import pytest

from remosplat_drake.signals.aim import Aim
from remosplat_drake.signals.target import Target


def at(x: float) -> np.ndarray:
    X = np.eye(4)
    X[0, 3] = x
    return X


def test_a_pose_is_the_first_ones():
    aim = Aim.of(at(1))
    assert Aim.of(aim) is copy.deepcopy(aim) is aim
    assert [i for i, _ in aim.items] == [0]
    np.testing.assert_array_equal(aim.first.X_WT, at(1))


def test_who_has_no_target_is_left_out():
    aim = Aim((None, Target(at(3)), Target(at(5))))
    assert aim.arrays.effector.tolist() == [1, 2]
    np.testing.assert_array_equal(aim.arrays.X_WT, [at(3), at(5)])
    here = np.stack([at(0), at(2.5), at(4)])
    assert [e.distance for e in aim.errors(here)] == [0.5, 1.0]
    assert aim.farthest(here, lambda error: error.distance < 0.7)[0] == 2
    with pytest.raises(ValueError, match="needs a target"):
        Aim((None, None))


def test_all_have_to_arrive():
    aim = Aim((Target(at(1)), Target(at(2))))

    def near(error) -> bool:
        return error.distance < 0.1

    assert aim.is_reached(np.stack([at(1), at(2.05)]), near)
    assert not aim.is_reached(np.stack([at(1.2), at(2)]), near)


def test_aims_are_told_apart_by_who_shall_reach_what():
    aim = Aim((Target(at(1)), None))
    assert aim.equals(Aim.of(at(1)))
    assert not aim.equals(Aim((None, Target(at(1)))))
    assert not aim.equals(Aim((Target(at(1)), Target(at(1)))))
    assert not aim.equals(Aim.of(at(2)))


def test_an_aim_may_name_its_configuration():
    plain, there = Aim.of(at(1)), Aim((Target(at(1)),), q=np.zeros(3))
    assert there.arrays.by_path and not plain.arrays.by_path
    assert there.equals(Aim((Target(at(1)),), q=np.zeros(3)))
    assert not there.equals(plain) and not plain.equals(there)
    assert not there.equals(Aim((Target(at(1)),), q=np.ones(3)))


def test_the_farthest_beside_its_line_counts():
    line = Target(at(1)).on_line(at(0), 0.1)
    aim = Aim((line, Target(at(1)), line))
    beside = at(0.5)
    beside[1, 3] = 0.02
    assert aim.has_line
    found = aim.line_deviation(np.stack([at(0.5), at(9), beside]))
    assert found == pytest.approx(0.02)
    assert np.isnan(Aim.of(at(1)).line_deviation(beside[None]))
