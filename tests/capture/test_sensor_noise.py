"""Sensor noise: the numbers of each camera, worked by hand on flat walls."""

import dataclasses as dc

import numpy as np
import pytest

from remosplat_drake.base.errors import RemoSplatError
from remosplat_drake.capture.rendering.sensor_noise import (
    PRESETS,
    SensorNoise,
    noisy_depth,
    sensor_noise,
    with_noise,
)

K = np.array([[300.0, 0, 100], [0, 300, 75], [0, 0, 1]])
RNG = np.random.default_rng


def wall(z: float) -> np.ndarray:
    """A wall that faces the camera at a distance [m]."""
    return np.full((150, 200), z, np.float32)


@pytest.mark.parametrize(
    ("name", "z", "spread"),
    [
        ("kinect", 1, 0.0012 + 0.0019 * 0.6**2),
        ("kinect", 2, 0.0012 + 0.0019 * 1.6**2),
        # 0.08 pixels of disparity; f B = 21.2 pixel metres.
        ("realsense_d435", 1, 0.08 / 21.2),
        ("realsense_d435", 2, 4 * 0.08 / 21.2),
    ],
)
def test_depth_noise_grows_with_the_square_of_depth(name, z, spread):
    noise = dc.replace(PRESETS[name], inverse_depth_step=0.0)
    depth = noisy_depth(K, wall(z), noise, RNG(0))
    error = depth[depth > 0] - z
    assert error.std() == pytest.approx(spread, rel=0.02)
    assert abs(error.mean()) < 0.03 * spread


def test_steep_surfaces_are_noisier_and_then_lost():
    # The plane z = 1 + x tan(60 degrees): ahead it is met at 60 degrees.
    slope = np.tan(np.deg2rad(60))
    u = (np.arange(200) + 0.5 - 100) / 300
    depth = np.tile(1 / (1 - slope * u), (150, 1)).astype(np.float32)
    middle = slice(95, 105)
    noise = SensorNoise(axial_grazing=1e-3)
    error = noisy_depth(K, depth, noise, RNG(1)) - depth
    # theta^2 / (pi/2 - theta)^2 = 4 at 60 degrees.
    assert error[:, middle].std() == pytest.approx(4e-3, rel=0.1)
    kept = noisy_depth(K, depth, SensorNoise(max_incidence=1.0), RNG(1))
    assert not kept[:, middle].any()
    kept = noisy_depth(K, depth, SensorNoise(max_incidence=1.1), RNG(1))
    assert (kept[:, middle] > 0).all()


def test_depth_comes_in_steps_of_disparity():
    noise = SensorNoise(inverse_depth_step=0.00285)
    ramp = np.linspace(1.9, 2.1, 30_000, dtype=np.float32).reshape(150, 200)
    depth = noisy_depth(K, ramp, noise, RNG(0))
    steps = np.diff(np.unique(depth))
    # d(1/z) = 0.00285 is dz = z^2 d(1/z) = 11.4 mm at 2 m.
    assert np.median(steps) == pytest.approx(0.0114, rel=0.02)
    assert np.abs(depth - ramp).max() < 0.0065


def test_range_and_dropout_leave_holes():
    noise = SensorNoise(min_range=0.5, max_range=3, dropout=0.1)
    assert not noisy_depth(K, wall(0.4), noise, RNG(0)).any()
    assert not noisy_depth(K, wall(3.1), noise, RNG(0)).any()
    lost = (noisy_depth(K, wall(1), noise, RNG(0)) == 0).mean()
    assert lost == pytest.approx(0.1, abs=0.01)
    assert not noisy_depth(K, wall(0), SensorNoise(), RNG(0)).any()


def test_only_outlines_wander_and_fray():
    depth = wall(2)
    depth[:, :100] = 1
    noise = SensorNoise(outline_jitter=1, outline_loss=0.5)
    noisy = noisy_depth(K, depth, noise, RNG(0))
    assert set(np.unique(noisy)) == {0.0, 1.0, 2.0}
    np.testing.assert_array_equal(noisy[:, :97], depth[:, :97])
    np.testing.assert_array_equal(noisy[:, 103:], depth[:, 103:])
    seam = noisy[:, 99:101]
    assert (seam == 0).mean() == pytest.approx(0.5, abs=0.1)
    assert 0.1 < (seam[:, 0] == 2).mean() < 0.3


def test_no_noise_changes_nothing(scene_capture):
    same = with_noise(scene_capture, SensorNoise())
    for name in ("K", "rgb", "depth", "X_WC"):
        np.testing.assert_array_equal(
            getattr(same, name), getattr(scene_capture, name)
        )


def test_a_seed_names_one_capture(scene_capture):
    noise = PRESETS["kinect"]
    once, again = (with_noise(scene_capture, noise, 3) for _ in range(2))
    np.testing.assert_array_equal(once.depth, again.depth)
    np.testing.assert_array_equal(once.rgb, again.rgb)
    part = with_noise(scene_capture.select(np.arange(2)), noise, 3)
    np.testing.assert_array_equal(part.depth, once.depth[:2])
    other = with_noise(scene_capture, noise, 4)
    assert (other.depth != once.depth).any()


def test_colours_and_poses_are_disturbed_as_asked(scene_capture):
    noise = SensorNoise(color_noise=4, position=0.01, rotation=0.02)
    noisy = with_noise(scene_capture, noise)
    lit = (scene_capture.rgb > 20) & (scene_capture.rgb < 235)
    error = noisy.rgb[lit].astype(float) - scene_capture.rgb[lit]
    assert error.std() == pytest.approx(4, rel=0.05)
    X_CD = np.linalg.inv(scene_capture.X_WC) @ noisy.X_WC
    shift = X_CD[:, :3, 3]
    angle = np.arccos((np.trace(X_CD[:, :3, :3], axis1=1, axis2=2) - 1) / 2)
    assert shift.std() == pytest.approx(0.01, rel=0.4)
    assert np.sqrt((angle**2).mean() / 3) == pytest.approx(0.02, rel=0.4)


def test_presets_have_names():
    assert sensor_noise("none") == SensorNoise()
    with pytest.raises(RemoSplatError, match="kinect, none, realsense_d435"):
        sensor_noise("lidar")
