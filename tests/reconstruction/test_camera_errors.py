"""Displacements of points, against cameras of which one number is wrong."""

import dataclasses as dc
from collections.abc import Callable

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from remosplat_drake.capture.capture import Capture
from remosplat_drake.capture.undistortion import Distortion, distort
from remosplat_drake.reconstruction.alignment.camera_errors import (
    ASPECT,
    CENTER_X,
    CENTER_Y,
    COUNT,
    DELAY,
    FOCAL,
    GROWTH,
    K1,
    K2,
    OFFSET,
    READOUT,
    SCALE,
    SHIFT,
    TURN,
    CameraPrior,
    displacements_of,
    velocity_C,
)

K = np.array([[70.0, 0, 41], [0, 72, 29], [0, 0, 1]])
HEIGHT, WIDTH = 60, 80
OMEGA_W, V_W = np.array([0.3, -0.5, 0.4]), np.array([0.2, 0.1, -0.6])
ROW, COLUMN, DEPTH = 7, 66, 1.7
"""The pixel that is looked at, near a corner of the image."""

STEP = 1e-5


@pytest.fixture(scope="module")
def capture() -> Capture:
    """One view, turned about all axes, whose camera moves."""
    X_WC = np.eye(4)
    X_WC[:3, :3] = Rotation.from_rotvec([0.4, -1.1, 0.7]).as_matrix()
    X_WC[:3, 3] = [0.5, -0.2, 1.3]
    return Capture(
        K=K[None],
        X_WC=X_WC[None],
        rgb=np.zeros((1, HEIGHT, WIDTH, 3), np.uint8),
        depth=np.full((1, HEIGHT, WIDTH), DEPTH, np.float32),
        velocity_W=np.concatenate([OMEGA_W, V_W])[None],
    )


def seen(
    capture: Capture,
    K: np.ndarray = K,
    depth: float = DEPTH,
    lens: Distortion | None = None,
    time: float = 0.0,
    X_CD: np.ndarray | None = None,
) -> np.ndarray:
    """The pixel's point in the given frame C, by the camera as it truly is.

    Args:
        capture: The camera as it was told.
        K: Its true intrinsic matrix [pixels].
        depth: The true depth [m].
        lens: Its true distortion.
        time: When it took the pixel, after its pose was told [s].
        X_CD: Its true pose D on its carrier.
    """
    target = (np.array([COLUMN + 0.5, ROW + 0.5]) - K[:2, 2]) / K[
        [0, 1], [0, 1]
    ]
    xy = target.copy()
    for _ in range(10):
        xy += target - distort(lens or Distortion(), xy)
    X_WC, X_WD = capture.X_WC[0], capture.X_WC[0].copy()
    turn = Rotation.from_rotvec(time * OMEGA_W).as_matrix()
    X_WD[:3, :3] = turn @ X_WD[:3, :3]
    X_WD[:3, 3] += time * V_W
    if X_CD is not None:
        X_WD = X_WD @ X_CD
    p_W = X_WD[:3, :3] @ (depth * np.append(xy, 1)) + X_WD[:3, 3]
    return X_WC[:3, :3].T @ (p_W - X_WC[:3, 3])


def with_lens(row: int, column: int, change: float) -> np.ndarray:
    altered = K.copy()
    altered[row, column] += change
    return altered


def mounted(axis: int, turn: float = 0.0, shift: float = 0.0) -> np.ndarray:
    X_CD, unit = np.eye(4), np.eye(3)[axis]
    X_CD[:3, :3] = Rotation.from_rotvec(turn * unit).as_matrix()
    X_CD[:3, 3] = shift * unit
    return X_CD


def late(e: float) -> float:
    """When the pixel's row is taken, in a read-out around the image's time."""
    return e * ((ROW + 0.5) / HEIGHT - 0.5)


TRUTHS: dict[int, Callable[[Capture, float], np.ndarray]] = {
    SCALE: lambda c, e: seen(c, depth=DEPTH * (1 + e)),
    OFFSET: lambda c, e: seen(c, depth=DEPTH + e),
    GROWTH: lambda c, e: seen(c, depth=DEPTH + e * DEPTH**2),
    FOCAL: lambda c, e: seen(c, K @ np.diag([1 + e, 1 + e, 1])),
    ASPECT: lambda c, e: seen(c, K @ np.diag([1, 1 + e, 1])),
    CENTER_X: lambda c, e: seen(c, with_lens(0, 2, e * K[0, 0])),
    CENTER_Y: lambda c, e: seen(c, with_lens(1, 2, e * K[1, 1])),
    K1: lambda c, e: seen(c, lens=Distortion(k1=e)),
    K2: lambda c, e: seen(c, lens=Distortion(k2=e)),
    DELAY: lambda c, e: seen(c, time=e),
    READOUT: lambda c, e: seen(c, time=late(e)),
    TURN: lambda c, e: seen(c, X_CD=mounted(0, turn=e)),
    TURN + 1: lambda c, e: seen(c, X_CD=mounted(1, turn=e)),
    TURN + 2: lambda c, e: seen(c, X_CD=mounted(2, turn=e)),
    SHIFT: lambda c, e: seen(c, X_CD=mounted(0, shift=e)),
    SHIFT + 1: lambda c, e: seen(c, X_CD=mounted(1, shift=e)),
    SHIFT + 2: lambda c, e: seen(c, X_CD=mounted(2, shift=e)),
}
"""Where the pixel's point is if one number of the camera is off by e."""


@pytest.mark.parametrize("error", range(COUNT))
def test_displacements_are_those_of_a_camera_with_one_wrong_number(
    capture, error
):
    ends = [TRUTHS[error](capture, e) for e in (STEP, -STEP)]
    expected = (ends[0] - ends[1]) / (2 * STEP)
    found = displacements_of(capture, 0, seen(capture)[None])
    assert np.linalg.norm(expected) > 0.03
    np.testing.assert_allclose(found[0, error], expected, atol=1e-8)


def test_many_points_are_displaced_each_by_itself(capture):
    p_C = np.random.default_rng(0).uniform([-1, -1, 0.5], [1, 1, 3], (5, 3))
    together = displacements_of(capture, 0, p_C)
    for i in range(5):
        alone = displacements_of(capture, 0, p_C[i : i + 1])
        np.testing.assert_array_equal(together[i], alone[0])


def test_by_hand_on_the_axis(capture):
    """On the optical axis, 2 m away, nothing but depth and pose matters."""
    b = displacements_of(capture, 0, np.array([[0, 0, 2.0]]))[0]
    np.testing.assert_allclose(b[SCALE], [0, 0, 2])
    np.testing.assert_allclose(b[OFFSET], [0, 0, 1])
    np.testing.assert_allclose(b[GROWTH], [0, 0, 4])
    np.testing.assert_array_equal(b[[FOCAL, ASPECT, K1, K2]], 0)
    np.testing.assert_allclose(b[CENTER_X], [-2, 0, 0])
    np.testing.assert_allclose(b[CENTER_Y], [0, -2, 0])
    np.testing.assert_allclose(
        b[TURN : TURN + 3], [[0, -2, 0], [2, 0, 0], [0, 0, 0]]
    )
    np.testing.assert_allclose(b[SHIFT : SHIFT + 3], np.eye(3))


def test_velocities_are_told_in_the_cameras_own_frame(capture):
    both = velocity_C(capture, 0)
    R_WC = capture.X_WC[0, :3, :3]
    np.testing.assert_allclose(R_WC @ both[:3], OMEGA_W)
    np.testing.assert_allclose(R_WC @ both[3:], V_W)


def test_without_velocities_times_move_nothing(capture):
    still = dc.replace(capture, velocity_W=None)
    b = displacements_of(still, 0, seen(still)[None])[0]
    np.testing.assert_array_equal(b[[DELAY, READOUT]], 0)
    others = np.delete(np.arange(COUNT), [DELAY, READOUT])
    moving = displacements_of(capture, 0, seen(capture)[None])[0]
    np.testing.assert_array_equal(b[others], moving[others])


def test_deviations_are_in_the_order_of_the_errors():
    prior = CameraPrior(
        scale=0.01, offset=0.02, growth=0.03, focal=0.04, aspect=0.05,
        center=0.06, distortion=0.07, delay=0.08, readout=0.09, turn=0.1,
        shift=0.11,
    ).deviations()  # fmt: skip
    expected = {
        SCALE: 1, OFFSET: 2, GROWTH: 3, FOCAL: 4, ASPECT: 5, CENTER_X: 6,
        CENTER_Y: 6, K1: 7, K2: 7, DELAY: 8, READOUT: 9,
        TURN: 10, TURN + 1: 10, TURN + 2: 10,
        SHIFT: 11, SHIFT + 1: 11, SHIFT + 2: 11,
    }  # fmt: skip
    hundredths = [expected[error] for error in range(COUNT)]
    np.testing.assert_allclose(100 * prior, hundredths)
