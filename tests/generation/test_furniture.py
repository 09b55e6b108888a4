"""Furniture stands free of robots and is open where hands reach in."""

import numpy as np
import pytest

from remosplat_drake.generation.furniture import KINDS, furniture
from remosplat_drake.oracle.signed_distance import SignedDistanceField
from remosplat_drake.robot.sphere_model import Spheres


@pytest.mark.parametrize("kind", KINDS)
def test_robots_stand_free_beside_it(frankie, kind):
    for seed in range(3):
        scene = furniture(frankie, kind, seed).scene
        home = frankie.spheres_at(frankie.q_home)
        room = SignedDistanceField(scene).clearances(home, 0.5)
        assert room.minimum() > 0.19


@pytest.mark.parametrize("kind", KINDS)
def test_its_inside_is_free_and_no_board(frankie, kind):
    drawn = furniture(frankie, kind, 1)
    field = SignedDistanceField(drawn.scene)
    for box in drawn.inside:
        p_WC = box.X_WP.translation()
        assert drawn.holds(p_WC)
        # The walls are half its size away, and not nearer.
        clear = field.clearances(Spheres.at(p_WC), 2.0).minimum()
        assert clear > 0.1
    for board in drawn.scene.boxes:
        assert not drawn.holds(board.X_WP.translation())


def test_it_depends_on_the_seed_alone(frankie):
    first = furniture(frankie, "shelf", 4)
    again = furniture(frankie, "shelf", 4)
    other = furniture(frankie, "shelf", 5)
    assert first.scene.content_hash == again.scene.content_hash
    assert first.scene.content_hash != other.scene.content_hash


def test_a_shelf_is_one_bay_above_the_other(frankie):
    bays = furniture(frankie, "shelf", 2).inside
    lows = [b.X_WP.translation()[2] - b.half_extents[2] for b in bays]
    tops = [b.X_WP.translation()[2] + b.half_extents[2] for b in bays]
    np.testing.assert_allclose(lows[1:], np.array(tops[:-1]) + 0.02)
