"""Each cause of standing still, in a closed loop in which it holds the robot.

Solids, joint limits and others' constraints are in `test_motion_status_system`.
"""

import numpy as np
import pytest
from held_robot import SHELF, drive
from pydrake.math import RigidTransform

from remosplat_drake.generation.primitive_surfels import surfel_splat
from remosplat_drake.oracle.composite import CompositeDistanceField
from remosplat_drake.oracle.oracle_config import SphereToEllipsoid
from remosplat_drake.oracle.unknown_space import UnknownSpaceField
from remosplat_drake.scene.primitive_scene import Box, PrimitiveScene
from remosplat_drake.signals import motion_status as states
from remosplat_drake.signals import thing as things

BELOW = [0.5, 0.0, 0.05]
"""Below the shelf and what else is there [m]."""

TOP = 0.27
"""Height of the shelf's upper side [m]."""

BRIEFLY = "time_limit: 14"

FINGERS = ("panda_leftfinger", "panda_rightfinger")


def splat_of_the_shelf():
    """The shelf, as a map has it: a surface without a name."""
    splat = surfel_splat(PrimitiveScene(boxes=(SHELF,)), 20_000)
    return SphereToEllipsoid().make(splat)


def unseen_below(height: float) -> UnknownSpaceField:
    """Height below which is unseen space, where the hand is sent to [m]."""
    voxel, n = 0.05, 60
    lower = np.full(3, -0.5 * n * voxel)
    x, y, z = lower[:, None] + voxel * (np.arange(n) + 0.5)
    unseen = np.zeros((n, n, n), bool)
    unseen[np.ix_(x > 0.3, np.isfinite(y), z < height)] = True
    return UnknownSpaceField(unseen, lower, voxel)


def test_the_surface_of_a_map(tmp_path):
    status = drive(
        tmp_path, BELOW, text=BRIEFLY, field=splat_of_the_shelf()
    ).motion_status
    assert status.cause == things.MAP, status.text
    assert status.thing == things.THE_MAP.name
    assert status.link in FINGERS
    assert status.p_W is not None
    assert status.p_W[2] == pytest.approx(TOP, abs=0.01)


def test_a_map_s_surface_has_the_name_of_what_is_there(tmp_path):
    """Where the truth is known, the same splat is called by it."""
    status = drive(
        tmp_path, BELOW, SHELF, text=BRIEFLY, field=splat_of_the_shelf()
    ).motion_status
    assert (status.cause, status.thing) == (
        things.MAP,
        "the shelf",
    )


def test_unseen_space(tmp_path):
    status = drive(
        tmp_path, BELOW, text=BRIEFLY, field=unseen_below(0.25)
    ).motion_status
    assert status.cause == things.UNSEEN, status.text
    assert status.link in FINGERS
    assert status.p_W is not None
    assert status.p_W[2] == pytest.approx(0.25)
    assert status.text.endswith(": add a frame that sees it")


@pytest.mark.parametrize(
    "height, cause", [(0.35, things.UNSEEN), (0.15, things.MAP)]
)
def test_of_a_map_and_the_unseen_the_upper_one_holds(tmp_path, height, cause):
    field = CompositeDistanceField([splat_of_the_shelf(), unseen_below(height)])
    status = drive(tmp_path, BELOW, text=BRIEFLY, field=field).motion_status
    assert status.cause == cause, status.text


def test_the_floor(tmp_path):
    floor = Box(
        RigidTransform([0.55, 0, -0.02]), np.array([0.3, 0.6, 0.02]), "floor"
    )
    result = drive(tmp_path, [0.5, 0.0, -0.3], floor, text=BRIEFLY)
    status = result.motion_status
    # The elbow creeps on, by a few milliradians a second.
    told = [s.kind for _, s in result.motion_history]
    assert told == [states.MOVING, states.HELD]
    assert (status.cause, status.thing) == (
        things.FLOOR,
        "the floor",
    )
    assert status.link in FINGERS


def test_the_robot_itself(tmp_path):
    """A hand that is sent into its own base, which must not drive away."""
    status = drive(
        tmp_path,
        [0.0, 0.0, 0.2],
        text="{time_limit: 14, robot: {model: frankie}, controller:"
        " {velocity_limits:"
        " {max_forward: 0, max_reverse: 0, max_yaw_rate: 0}}}",
    ).motion_status
    assert status.cause == states.SELF_COLLISION, status.text
    assert status.thing == "the base"
