"""Robots get out of where they are too near, and starts are what they say."""

import numpy as np
import pytest

from apps.studies.ways_out.start import (
    DEEPEST,
    JOINTS,
    MOVER,
    SURROUNDINGS,
    UNSEEN,
    Start,
    draw,
    has_unseen_space,
    place_of,
)
from apps.studies.ways_out.trial import run_trial
from remosplat_drake.scene.mover import Movers

NOTHING = Movers(0.0, [])


@pytest.mark.parametrize("seed", [155, 282, 411])
def test_a_start_whose_way_to_the_target_is_refused_is_left(seed):
    """The target bends these ways out until verification refuses them."""
    result = run_trial(Start("ur5e", seed))
    assert result.out_after is not None
    assert not result.stopped
    assert result.nearer_at_ticks <= 1e-9
    assert result.nearer_between <= 5e-4


def test_a_corner_of_a_splat_is_left():
    """Two surfaces are equally near there: a row to one does not suffice."""
    result = run_trial(Start("ur5e", 20041))
    assert result.out_after is not None
    assert not result.stopped


def test_starts_are_too_near_to_what_they_say():
    place = place_of("panda")
    near = draw(Start("panda", 0, SURROUNDINGS))
    assert -DEEPEST <= place.margins(near.q, NOTHING).min() < 0.0

    beside = draw(Start("panda", 0, MOVER))
    assert place.margins(beside.q, NOTHING).min() >= 0.0
    assert -DEEPEST <= place.margins(beside.q, beside.movers).min() < 0.0

    folded = draw(Start("panda", 0, JOINTS))
    assert place.margins(folded.q, NOTHING).min() >= 0.0
    assert place.joint_margins(folded.q).min() < 0.0
    robot = place.world.robot
    assert (folded.q >= robot.position_lower).all()
    assert (folded.q <= robot.position_upper).all()


def test_unseen_space_is_near_only_where_it_is_solid():
    assert has_unseen_space("frankie")
    assert not has_unseen_space("panda")
    q = draw(Start("frankie", 0, UNSEEN)).q
    solid = place_of("frankie", unseen_is_solid=True)
    assert place_of("frankie").margins(q, NOTHING).min() >= 0.0
    assert -DEEPEST <= solid.margins(q, NOTHING).min() < 0.0


def test_equal_seeds_draw_equal_starts():
    start = Start("panda", 3, JOINTS)
    assert np.array_equal(draw(start).q, draw(start).q)
