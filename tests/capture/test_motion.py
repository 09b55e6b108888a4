"""Velocities of cameras from their poses."""

import numpy as np
from scipy.spatial.transform import Rotation

from remosplat_drake.capture.motion import (
    LONGEST_STEP,
    camera_accelerations,
    camera_velocities,
)


def poses(turns: list[float], places: list[float]) -> np.ndarray:
    """Poses that are turned about W's z [rad] and lie on W's x axis [m]."""
    X_WC = np.tile(np.eye(4), (len(turns), 1, 1))
    X_WC[:, :3, :3] = Rotation.from_rotvec(
        np.outer(turns, [0, 0, 1])
    ).as_matrix()
    X_WC[:, 0, 3] = places
    return X_WC


def test_by_hand():
    """0.1 s apart; in the middle it has moved by 0.3 m in 0.2 s."""
    times = np.array([5.0, 5.1, 5.2])
    velocity_W = camera_velocities(times, poses([0, 0.1, 0.4], [0, 0.2, 0.3]))
    np.testing.assert_allclose(velocity_W[:, 2], [1, 2, 3])
    np.testing.assert_allclose(velocity_W[:, 3], [2, 1.5, 1])
    np.testing.assert_allclose(velocity_W[:, [0, 1, 4, 5]], 0, atol=1e-12)


def test_a_turn_is_told_in_the_world_whatever_the_camera_looks_at():
    """A turn about W's z, of a camera whose own z points along W's x."""
    R_WC = Rotation.from_euler("y", 90, degrees=True)
    X_WC = np.tile(np.eye(4), (2, 1, 1))
    for i, turn in enumerate((0.0, 0.05)):
        R = Rotation.from_euler("z", turn) * R_WC
        X_WC[i, :3, :3] = R.as_matrix()
    velocity_W = camera_velocities(np.array([0, 0.1]), X_WC)
    np.testing.assert_allclose(
        velocity_W, [[0, 0, 0.5, 0, 0, 0]] * 2, atol=1e-9
    )


def test_a_gap_is_not_differentiated():
    times = np.array([0.0, 0.1, 0.1 + LONGEST_STEP + 1e-6, 1.0])
    velocity_W = camera_velocities(times, poses([0] * 4, [0, 0.1, 9, 99]))
    np.testing.assert_allclose(velocity_W[:2, 3], [1, 1])
    assert np.isnan(velocity_W[2:]).all()


def test_frames_in_any_order():
    times = np.array([0.2, 0.0, 0.1])
    velocity_W = camera_velocities(times, poses([0] * 3, [0.3, 0.0, 0.2]))
    np.testing.assert_allclose(velocity_W[:, 3], [1, 2, 1.5])


def test_unusable_poses_are_left_out():
    """The frames beside them are each other's neighbours."""
    X_WC = poses([0] * 4, [0, 0, 0.1, 0.2])
    X_WC[1] = np.nan
    velocity_W = camera_velocities(np.array([0, 0.05, 0.1, np.nan]), X_WC)
    np.testing.assert_allclose(velocity_W[[0, 2], 3], [1, 1])
    assert np.isnan(velocity_W[[1, 3]]).all()


def test_two_frames_of_one_time_tell_nothing():
    velocity_W = camera_velocities(np.zeros(2), poses([0, 1], [0, 1]))
    assert np.isnan(velocity_W).all()


def test_accelerations_of_a_throw_are_gravity():
    """Thrown upwards at 30 Hz: z = 3 t - g t^2 / 2; in one piece and two."""
    times = np.arange(30) / 30
    for gap in (0.0, 1.0):
        later = times + gap * (np.arange(30) >= 15)
        velocity_W = np.zeros((30, 6))
        velocity_W[:, 5] = 3 - 9.81 * later
        acceleration_W = camera_accelerations(later, velocity_W)
        np.testing.assert_allclose(acceleration_W[:, 5], -9.81)
        np.testing.assert_allclose(acceleration_W[:, :5], 0)


def test_what_has_no_velocity_has_no_acceleration():
    velocity_W = np.zeros((4, 6))
    velocity_W[1] = np.nan
    acceleration_W = camera_accelerations(
        np.array([0, 0.1, 0.15, 9]), velocity_W
    )
    np.testing.assert_array_equal(acceleration_W[[0, 2]], 0)
    assert np.isnan(acceleration_W[[1, 3]]).all()
