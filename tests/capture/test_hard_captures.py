"""Findings about things that depth cameras get wrong, and their limits."""

import dataclasses as dc

import numpy as np
import pytest
from pydrake.math import RigidTransform

from remosplat_drake.capture.capture import Capture
from remosplat_drake.capture.checks.inspection import inspect_capture
from remosplat_drake.capture.rendering.camera_poses import look_at
from remosplat_drake.capture.rendering.synthetic import render_capture
from remosplat_drake.scene.primitive_scene import Box, Cylinder, PrimitiveScene

SIZE = 120, 90


def box(middle, half) -> Box:
    return Box(RigidTransform(middle), np.array(half, float))


def names(capture: Capture) -> list[str]:
    return [finding.name for finding in inspect_capture(capture).findings]


def joined(parts: list[Capture]) -> Capture:
    def all_of(name: str) -> np.ndarray:
        return np.concatenate([getattr(part, name) for part in parts])

    return Capture(
        K=all_of("K"),
        X_WC=all_of("X_WC"),
        rgb=all_of("rgb"),
        depth=all_of("depth"),
    )


ROOM = (
    box([0, 0, -0.05], [3, 3, 0.05]),
    box([2, 0, 1], [0.05, 3, 1]),
    box([0, 2, 1], [3, 0.05, 1]),
    box([0.8, 0.9, 0.3], [0.3, 0.4, 0.3]),
    box([1.2, -0.6, 0.5], [0.2, 0.3, 0.5]),
)


def poses_in_the_room(n: int = 14) -> list[RigidTransform]:
    """Cameras on an arc that look into the room's corner."""
    return [
        look_at(
            np.array([1.6 * np.cos(a), 1.6 * np.sin(a), 1.2]),
            np.array([0.9, 0.7, 0.5]),
        )
        for a in np.linspace(np.pi - 0.3, 1.5 * np.pi + 0.3, n)
    ]


def test_a_room_is_fine():
    scene = PrimitiveScene(boxes=ROOM)
    assert names(render_capture(scene, poses_in_the_room(), *SIZE)) == []


def test_a_moving_person_is_told():
    """A cylinder that takes a step between any two frames."""
    parts = []
    for i, pose in enumerate(poses_in_the_room()):
        p_WP = [0.1 + 0.08 * i, 0.9 - 0.12 * i, 0.85]
        person = Cylinder(RigidTransform(p_WP), 0.2, 0.85)
        scene = PrimitiveScene(boxes=ROOM, cylinders=(person,))
        parts.append(render_capture(scene, [pose], *SIZE))
    found = inspect_capture(joined(parts)).findings
    assert "moving" in [finding.name for finding in found]
    assert any("an object has moved" in finding.problem for finding in found)


def test_frames_without_overlap_are_refused():
    """Five cameras in the middle of a room, each with a wall of its own."""
    walls = [
        box([2 * np.cos(a), 2 * np.sin(a), 1], [0.4, 0.4, 1])
        for a in 2 * np.pi * np.arange(5) / 5
    ]
    poses = [
        look_at(np.array([0.1 * i, 0, 1.0]), wall.X_WP.translation())
        for i, wall in enumerate(walls)
    ]
    scene = PrimitiveScene(boxes=tuple(walls))
    inspection = inspect_capture(render_capture(scene, poses, *SIZE))
    assert "no-overlap" in [finding.name for finding in inspection.defects]


def test_one_blank_wall_checks_nothing_along_it():
    scene = PrimitiveScene(boxes=(box([2, 0, 1], [0.05, 9, 9]),))
    poses = [
        look_at(np.array([0.0, 0.1 * i, 1.0]), np.array([2, 0.3, 1.0 + i / 20]))
        for i in range(8)
    ]
    capture = render_capture(scene, poses, *SIZE)
    assert names(capture) == ["one-plane"]


def two_rooms(joints: int) -> Capture:
    """Two corners back to back, and cameras that see both."""
    rooms = (
        *ROOM,
        *(
            box([-6, 0, 0] - b.X_WP.translation() * [1, 1, -1], b.half_extents)
            for b in ROOM
        ),
    )
    here = poses_in_the_room(8)
    there = [
        look_at(np.array([-6, 0, 0]) - p * [1, 1, -1], q)
        for p, q in (
            (pose.translation(), np.array([-6.9, -0.7, 0.5])) for pose in here
        )
    ]
    scene = PrimitiveScene(boxes=rooms)
    # From high above, both floors are seen at once.
    above = [
        look_at(np.array([-3.0, 0.2 * i, 7.5]), np.array([-3.0, 0.1, 0]))
        for i in range(joints)
    ]
    poses = [*here, *above, *there]
    return render_capture(scene, poses, 240, 180, fov_y=1.2)


@pytest.mark.parametrize(
    ("joints", "name"), [(0, "separate-groups"), (1, "one-joint")]
)
def test_two_rooms_hang_by_what_joins_them(joints, name):
    found = inspect_capture(two_rooms(joints)).findings
    assert name in [finding.name for finding in found]
    if joints:
        (joint,) = [f for f in found if f.name == name]
        assert 8 in joint.frames


BEHIND_THE_MIRROR = (
    box([2, -1.75, 1], [0.05, 1.25, 1]),
    box([2, 2.25, 1], [0.05, 0.75, 1]),
    box([3.6, 0, 1], [0.05, 3, 1]),
    box([2.9, 0.5, 0.4], [0.2, 0.3, 0.4]),
)
"""A wall with a hole, and what is mirrored in it."""


def of_a_mirror() -> Capture:
    others = tuple(b for i, b in enumerate(ROOM) if i != 1)
    scene = PrimitiveScene(boxes=(*others, *BEHIND_THE_MIRROR))
    return render_capture(scene, poses_in_the_room(), *SIZE)


def test_of_a_mirror_and_of_glass_nothing_is_promised():
    """A mirror is a hole in its wall, with a room behind it.

    All frames agree about that room, and about what stands behind glass.
    """
    assert names(of_a_mirror()) == []


@pytest.mark.parametrize("every", [pytest.param(2, marks=pytest.mark.slow), 5])
def test_a_mirror_that_other_frames_see_as_a_wall_is_told(every):
    """Few frames that look through it are told as well as many."""
    wall = render_capture(
        PrimitiveScene(boxes=ROOM), poses_in_the_room(), *SIZE
    )
    mirror = of_a_mirror()
    through = np.arange(len(wall)) % every == 0
    depth = np.where(through[:, None, None], mirror.depth, wall.depth)
    (found,) = inspect_capture(dc.replace(wall, depth=depth)).findings
    assert found.name == "moving"
    assert "is a mirror or glass" in found.problem
    if every == 5:
        assert found.frames == (0, 5, 10)


def test_glass_that_only_some_frames_see_is_told():
    """Pane in even frames, what is behind it in odd ones."""
    poses = poses_in_the_room()
    pane = box([0.55, 0.55, 0.8], [0.02, 0.6, 0.8])
    seen = render_capture(PrimitiveScene(boxes=(*ROOM, pane)), poses, *SIZE)
    through = render_capture(PrimitiveScene(boxes=ROOM), poses, *SIZE)
    even = (np.arange(len(poses)) % 2 == 0)[:, None, None]
    capture = dc.replace(seen, depth=np.where(even, seen.depth, through.depth))
    assert "moving" in names(capture)


def of_another_camera(baseline: float, width: int, height: int) -> Capture:
    """Colours of one camera, and the depth of one to its right [m]."""
    scene, poses = PrimitiveScene(boxes=ROOM), poses_in_the_room()
    beside = [X_WC @ RigidTransform([baseline, 0, 0]) for X_WC in poses]
    colours = render_capture(scene, poses, width, height)
    depth = render_capture(scene, beside, width, height).depth
    return dc.replace(colours, depth=depth)


def test_depth_that_is_registered_to_another_camera_is_told():
    """A wide baseline is a shift of edges; a short one is inexact poses."""
    assert names(of_another_camera(0.055, 320, 240)) == ["colours", "inexact"]
    assert names(of_another_camera(0.025, *SIZE)) == ["inexact"]
