"""A camera that is not what its calibration says, and frames that tell it."""

import dataclasses as dc
import re
from functools import cache

import numpy as np
import pytest
from laden_table import THING, table
from pydrake.math import RigidTransform, RollPitchYaw
from scipy.spatial.transform import Rotation

from apps.studies.map_bound.ray_casting import cast_capture
from remosplat_drake.capture.capture import Capture
from remosplat_drake.capture.rendering.camera_poses import look_at
from remosplat_drake.capture.rendering.sensor_noise import (
    sensor_noise,
    with_noise,
)
from remosplat_drake.mapping.camera_suspicion import (
    LEAST_FRAMES,
    Judgement,
    judge_camera,
)
from remosplat_drake.reconstruction.alignment.camera_errors import (
    COUNT,
    FOCAL,
    GROWTH,
    TURN,
)
from remosplat_drake.scene.primitive_scene import Box

FRAMES = 10
TURN_CD = np.deg2rad([0.6, -0.64, 0.48])
"""The true camera D in the one that its mount says, C: turned by 1 degree."""

MUG = Box(RigidTransform([0.75, 0.25, 0.48]), np.array([0.06, 0.04, 0.05]))
BOOK = Box(RigidTransform([1.25, -0.2, 0.5]), np.array([0.05, 0.08, 0.07]))


@cache
def exact(*things: Box) -> Capture:
    """Ten frames by a wrist camera that moves before the laden table."""
    rng = np.random.default_rng(5)
    p_WT = np.array([1.0, 0, 0.5])
    poses = []
    for _ in range(FRAMES):
        azimuth = np.pi + rng.uniform(-0.9, 0.9)
        elevation = rng.uniform(0.4, 1.1)
        side = np.array(
            [
                np.cos(azimuth) * np.cos(elevation),
                np.sin(azimuth) * np.cos(elevation),
                np.sin(elevation),
            ]
        )
        p_WC = p_WT + rng.uniform(0.55, 1.0) * side
        X_WC = look_at(p_WC, p_WT + rng.uniform(-0.1, 0.1, 3))
        roll = RollPitchYaw(0, 0, rng.uniform(-0.6, 0.6))
        poses.append(X_WC.multiply(RigidTransform(roll, np.zeros(3))))
    scene = table(THING, *(things or (MUG, BOOK)))
    return cast_capture(scene, poses, 200, 150, np.deg2rad(45))


def judged(capture: Capture, **options) -> Judgement:
    names = tuple(f"frame {i}" for i in range(len(capture)))
    return judge_camera(capture, names, **options)


def turned(capture: Capture) -> Capture:
    """The same images, by a camera that believes in its mount."""
    X_DC = np.eye(4)
    X_DC[:3, :3] = Rotation.from_rotvec(TURN_CD).as_matrix().T
    return dc.replace(capture, X_WC=capture.X_WC @ X_DC)


def shortened(capture: Capture) -> Capture:
    """The same images, with a focal length that is 3 % too short."""
    K = capture.K.copy()
    K[:, [0, 1], [0, 1]] *= 0.97
    return dc.replace(capture, K=K)


def stretched(capture: Capture) -> Capture:
    """The same images, by a sensor whose depth errs by 2 cm at 1 m."""
    z = capture.depth
    return dc.replace(capture, depth=z + np.float32(0.02) * z * z)


def shaken(capture: Capture, size: float) -> Capture:
    """The same images from poses that are wrong, each in its own way [m]."""
    rng = np.random.default_rng(0)
    X_WC = capture.X_WC.copy()
    X_WC[:, :3, 3] += rng.normal(0, size, (len(capture), 3))
    return dc.replace(capture, X_WC=X_WC)


SENSORS = pytest.mark.parametrize(
    "sensor", [pytest.param("none", marks=pytest.mark.slow), "realsense_d435"]
)


def measured(capture: Capture, sensor: str) -> Capture:
    return with_noise(capture, sensor_noise(sensor), seed=1)


@SENSORS
def test_an_exact_camera_is_left_as_it_is(sensor):
    capture = measured(exact(), sensor)
    dut = judged(capture)
    assert (dut.words, dut.problem) == ("", "")
    assert not dut.errors.any()
    assert dut.undone(capture) is capture


@SENSORS
def test_a_camera_that_is_turned_on_its_mount_is_turned_back(sensor):
    capture = measured(turned(exact()), sensor)
    dut = judged(capture)
    assert np.linalg.norm(dut.errors[TURN:][:3] - TURN_CD) < np.deg2rad(0.02)
    assert re.fullmatch(
        r"the camera is (0\.9|1\.0)\d* degrees from its configured pose"
        r" \(.*\): corrected",
        dut.words,
    )
    right = dut.undone(capture)
    np.testing.assert_allclose(right.X_WC, exact().X_WC, atol=5e-4)


@SENSORS
def test_a_focal_length_is_found(sensor):
    capture = measured(shortened(exact()), sensor)
    dut = judged(capture)
    assert abs(0.97 * (1 + dut.errors[FOCAL]) - 1) < 5e-4
    assert dut.words.startswith("the focal length is 3.")
    assert " % longer than the capture says" in dut.words
    np.testing.assert_allclose(dut.undone(capture).K, exact().K, rtol=5e-4)


def test_a_depth_that_grows_with_its_square_is_found():
    dut = judged(stretched(exact()))
    # To first order: z^2 is of the depth that is too large.
    assert -0.02 < dut.errors[GROWTH] < -0.018
    assert dut.words.startswith("depths are shorter than the capture says by")
    near = exact().depth < 1.2
    z = dut.undone(stretched(exact())).depth[near]
    np.testing.assert_allclose(z, exact().depth[near], atol=1e-3)


def test_five_frames_are_enough_and_four_tell_nothing():
    few = turned(exact())
    found = judged(few.select(np.arange(LEAST_FRAMES)))
    assert np.linalg.norm(found.errors[TURN:][:3] - TURN_CD) < 1e-3
    nothing = judged(few.select(np.arange(LEAST_FRAMES - 1)))
    assert not nothing.errors.any() and not nothing.problem


@pytest.mark.parametrize("wrong", [lambda capture: capture, turned])
def test_neither_a_thing_that_comes_nor_one_frame_elsewhere_counts(wrong):
    depth, X_WC = exact().depth.copy(), wrong(exact()).X_WC.copy()
    depth[:5] = exact(MUG).depth[:5]
    X_WC[7, :3, 3] += 0.25
    dut = judged(dc.replace(exact(), depth=depth, X_WC=X_WC))
    told = dut.errors[TURN:][:3]
    expected = TURN_CD if wrong is turned else np.zeros(3)
    np.testing.assert_allclose(told, expected, atol=1e-4)
    assert not dut.problem


def test_poses_that_joints_tell_nearly_are_no_error_of_the_camera():
    dut = judged(shaken(exact(), 0.001))
    assert not dut.errors.any() and not dut.problem


def test_wrong_poses_are_refused_and_named():
    dut = judged(shaken(exact(), 0.015))
    assert dut.problem.startswith("the frames contradict each other: their")
    assert "the robot's poses from joints and odometry are wrong" in dut.problem
    assert not dut.errors.any()


def test_frames_that_others_contradict_leave_no_doubt_about_the_rest():
    """Half of the pairs of ten frames are pairs with one of three."""
    X_WC = turned(exact()).X_WC.copy()
    X_WC[[2, 5, 8], :3, 3] += [[0.1, 0, 0], [0, 0.1, 0], [-0.1, 0, 0]]
    dut = judged(dc.replace(exact(), X_WC=X_WC))
    assert np.linalg.norm(dut.errors[TURN:][:3] - TURN_CD) < 1e-3
    assert not dut.problem and len(dut.names) == FRAMES


def test_a_depth_that_no_calibration_explains_is_refused_and_named():
    z = exact().depth
    bent = dc.replace(exact(), depth=z + np.float32(0.03) * np.sin(12 * z))
    assert "the depth is distorted" in judged(bent).problem


def test_the_poses_of_a_drifting_base_are_no_error_of_the_camera():
    dut = judged(shaken(exact(), 0.003), drifts=True)
    assert not dut.errors.any() and not dut.problem


def test_a_drifting_base_does_not_hide_that_a_camera_is_turned():
    capture = shaken(turned(exact()), 0.003)
    before = np.linalg.norm(TURN_CD)
    dut = judged(capture, drifts=True)
    assert np.linalg.norm(dut.errors[TURN:][:3] - TURN_CD) < 0.2 * before


def test_frames_that_share_nothing_tell_nothing():
    X_WC = exact().X_WC.copy()
    X_WC[:, 1, 3] += 5.0 * np.arange(FRAMES)
    dut = judged(dc.replace(exact(), X_WC=X_WC))
    assert not dut.errors.any() and not dut.problem


def names(first: int, last: int) -> tuple[str, ...]:
    return tuple(f"frame {i}" for i in range(first, last))


@pytest.mark.parametrize(
    ("problem", "first", "last", "holds"),
    [
        ("", 0, 8, True),
        ("", 0, 15, True),
        ("", 0, 16, False),
        ("", 0, 6, True),
        ("", 3, 8, False),
        ("too bad", 0, 8, True),
        ("too bad", 0, 9, False),
    ],
)
def test_frames_are_judged_again_when_half_of_them_are_others(
    problem, first, last, holds
):
    dut = Judgement(frozenset(names(0, 8)), np.zeros(COUNT), problem=problem)
    assert dut.holds_for(names(first, last)) is holds


def test_progress_is_told():
    told: list[tuple[str, int, int]] = []

    def report(*stage) -> None:
        told.append(stage)

    judged(exact(), report=report)
    assert {stage for stage, _, _ in told} == {"judging the camera"}
    assert all(0 <= done <= total for _, done, total in told)
