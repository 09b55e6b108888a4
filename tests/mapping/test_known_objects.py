"""Known objects are kept out of a live map, wherever they are."""

import numpy as np
import pytest
from pydrake.math import RigidTransform, RotationMatrix

from remosplat_drake.capture.capture import Capture
from remosplat_drake.capture.frames import Frame
from remosplat_drake.mapping.known_objects import (
    find_own_pixels,
    with_known_insides,
)
from remosplat_drake.mapping.store.frame_store import FrameStore
from remosplat_drake.oracle.own_points import own_points
from remosplat_drake.scene.objects.placed_object import PlacedObject
from remosplat_drake.scene.objects.scene_object import SceneObject
from remosplat_drake.scene.primitive_scene import Box
from remosplat_drake.signals.coverage import FREE, UNSEEN, Coverage

HALF, ABOVE = 0.1, 1.0
"""Half the box's side, and the height of the camera above the floor [m]."""

FOCAL, SIZE = 100.0, (60, 80)

BOX = SceneObject("box", Box(RigidTransform(), np.full(3, HALF)))


def at(x: float, z: float = HALF, *, stands: bool = True) -> PlacedObject:
    return PlacedObject("box", RigidTransform([x, 0, z]).GetAsMatrix4(), stands)


def looking_down(top: float) -> Capture:
    """A frame of a floor and a box whose upper side is at a height."""
    height, width = SIZE
    K = np.array(
        [[FOCAL, 0, 0.5 * width], [0, FOCAL, 0.5 * height], [0, 0, 1.0]]
    )
    X_WC = RigidTransform(RotationMatrix.MakeXRotation(np.pi), [0, 0, ABOVE])
    depth = np.full(SIZE, ABOVE, np.float32)
    y, x = np.indices(SIZE) + 0.5
    reach = FOCAL * HALF / (ABOVE - top)
    shown = np.maximum(abs(x - 0.5 * width), abs(y - 0.5 * height)) < reach
    depth[shown] = ABOVE - top
    return Capture(
        K=K[None],
        X_WC=X_WC.GetAsMatrix4()[None],
        rgb=np.zeros((1, *SIZE, 3), np.uint8),
        depth=depth[None],
    )


def test_pixels_of_an_object_are_found_where_it_is():
    capture = looking_down(2 * HALF)
    shown = capture.depth < ABOVE
    assert 300 < shown.sum() < shown.size / 2
    own = find_own_pixels(capture, [BOX], [[at(0.0)]])
    assert (own == shown).all()
    # It is somewhere else, or unknown.
    for placed in ([at(0.6)], []):
        assert not find_own_pixels(capture, [BOX], [placed]).any()


def test_the_foot_counts_only_if_the_object_is_carried():
    """A point at the foot of a standing object may be one of its support."""
    side = np.array([[HALF, 0.0, -HALF + 0.005], [HALF, 0.0, 0.0]])
    np.testing.assert_array_equal(own_points(side, BOX, 0.01), [False, True])
    assert own_points(side, BOX, 0.01, stands=False).all()


def test_the_inside_of_an_object_is_not_unseen():
    voxel = 0.05
    state = np.full((20, 20, 10), UNSEEN, np.uint8)
    coverage = Coverage(np.array([-0.5, -0.5, 0.0]), voxel, state)
    known = with_known_insides(coverage, [BOX], [[at(0.0)], [at(0.3)]])
    middle = coverage.lower + voxel * (np.argwhere(known.state == FREE) + 0.5)
    # Two boxes of 0.2 m, and voxels that they touch.
    assert middle.min(axis=0) == pytest.approx([-0.125, -0.125, 0.025])
    assert middle.max(axis=0) == pytest.approx([0.425, 0.125, 0.225])
    assert (known.state != UNSEEN).sum() < 2 * 6 * 6 * 5 + 1
    nothing = with_known_insides(coverage, [BOX], [[]])
    assert (nothing.state == UNSEEN).all()


def test_a_frame_keeps_the_objects_that_were_known(tmp_path):
    capture = looking_down(2 * HALF)
    frame = Frame(
        "frame",
        capture.K[0],
        capture.X_WC[0],
        capture.rgb[0],
        capture.depth[0],
        time=1.0,
    )
    store = FrameStore(tmp_path)
    first = store.add(frame, np.zeros(3), [at(0.25, stands=False)])
    second = store.add(frame, np.zeros(3))
    again = FrameStore(tmp_path)
    (box,) = again.objects(first)
    assert box.name == "box" and not box.stands
    np.testing.assert_array_equal(box.X_WO, at(0.25).X_WO)
    assert again.objects(second) == ()
