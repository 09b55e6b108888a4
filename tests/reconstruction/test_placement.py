"""A map stands upright on its floor, or says why it does not."""

import dataclasses as dc

import numpy as np
import pytest
from pydrake.math import RigidTransform, RollPitchYaw

from remosplat_drake.base.errors import RemoSplatError
from remosplat_drake.capture.capture import Capture
from remosplat_drake.capture.rendering.camera_poses import look_at
from remosplat_drake.capture.rendering.synthetic import render_capture
from remosplat_drake.reconstruction.placement import (
    CAPTURE,
    FLOOR,
    NONE,
    place,
)
from remosplat_drake.scene.primitive_scene import Box, PrimitiveScene

ON_ITS_SIDE = RigidTransform(RollPitchYaw(1.4, 0.3, 0.5), [1, 2, 3])


def moved(capture: Capture, X_VW: RigidTransform) -> Capture:
    return dc.replace(capture, X_WC=X_VW.GetAsMatrix4() @ capture.X_WC)


@pytest.fixture(scope="module")
def without_floor() -> Capture:
    """Four views of a small plate."""
    plate = Box(RigidTransform(), np.array([0.2, 0.2, 0.01]))
    poses = [
        look_at(np.array([x, y, 0.8]), np.zeros(3))
        for x, y in ((1, 0.2), (0.2, 1), (-1, 0.1), (0.1, -1))
    ]
    return render_capture(PrimitiveScene(boxes=(plate,)), poses, 120, 90)


def test_a_frame_that_stands_on_its_floor_stays(scene_capture):
    placement = place(scene_capture)
    assert placement.has_floor and not placement.moves
    assert placement.placed(scene_capture) is scene_capture


def test_a_frame_on_its_side_is_set_upright(scene_capture):
    placement = place(moved(scene_capture, ON_ITS_SIDE))
    assert placement.has_floor and placement.moves
    R_FW = (placement.X_FW @ ON_ITS_SIDE).rotation().matrix()
    assert R_FW[2, 2] > np.cos(1e-3)


def test_a_frame_above_its_floor_is_lowered(scene_capture):
    raised = moved(scene_capture, RigidTransform([0, 0, 1.0]))
    placement = place(raised)
    assert placement.moves
    heights = placement.placed(raised).X_WC[:, 2, 3]
    np.testing.assert_allclose(heights, scene_capture.X_WC[:, 2, 3], atol=1e-3)


def test_without_a_floor_nothing_is_guessed(without_floor):
    placement = place(without_floor)
    assert not placement.has_floor and not placement.moves
    assert placement.words.startswith("no floor: ")
    with pytest.raises(RemoSplatError, match="no floor"):
        place(without_floor, FLOOR)


def test_without_a_floor_gravity_may_be_known(without_floor):
    """As of ARKit's world, whose y axis is up."""
    X_VW = RigidTransform(RollPitchYaw(-np.pi / 2, 0, 0), [0, 0, 0])
    turned = moved(without_floor, X_VW)
    turned = dc.replace(turned, up_W=(0.0, 1.0, 0.0))
    placement = place(turned)
    assert placement.moves and not placement.has_floor
    assert "height is unknown" in placement.words
    placed = placement.placed(turned)
    assert placed.up_W == pytest.approx((0, 0, 1))
    np.testing.assert_allclose(
        placed.X_WC[:, 2, 3], without_floor.X_WC[:, 2, 3], atol=1e-12
    )


def test_known_gravity_rules_out_tilted_floors(scene_capture):
    sideways = dc.replace(scene_capture, up_W=(1.0, 0.0, 0.0))
    assert not place(sideways).has_floor


def test_the_captures_own_frame_is_taken_at_its_word(without_floor):
    placement = place(without_floor, CAPTURE)
    assert placement.has_floor and not placement.moves
    assert not place(without_floor, NONE).has_floor
