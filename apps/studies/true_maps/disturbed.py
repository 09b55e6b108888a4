"""Simulates captures of hand-held cameras and their trackers."""

import dataclasses as dc

import numpy as np
from scipy.ndimage import maximum_filter, minimum_filter

from apps.studies.true_maps.cameras import FAR, WIDTH, Cameras, pinhole
from apps.studies.true_maps.disturbance import Disturbance
from apps.studies.true_maps.ray_casting import RayCaster
from apps.studies.true_maps.tracking import (
    Tracker,
    acceleration_W,
    velocity_W,
)
from apps.studies.true_maps.walk import Walk
from remosplat_drake.capture.capture import Capture
from remosplat_drake.capture.rendering.sensor_noise import (
    near_outline,
    sensor_noise,
    with_noise,
)
from remosplat_drake.capture.undistortion import Distortion

_EDGE = 0.02
"""Least difference of the depths on both sides of an edge, as a fraction of the
depth."""


def true_cameras(
    walk: Walk, time: np.ndarray, what: Disturbance, seed: int
) -> Cameras:
    """Returns the true cameras of a capture's images.

    Args:
        walk: The camera's path.
        time: Times of the poses, shape (n,) [s].
        what: The errors.
        seed: Seed of all random numbers.
    """
    K = pinhole()
    turn = np.random.default_rng([seed, 1]).uniform(0, 2 * np.pi)
    offset = what.principal * WIDTH * np.array([np.cos(turn), np.sin(turn)])
    K[:2, 2] += offset
    lens = Distortion(k1=what.k1)
    return Cameras(walk, time - what.delay, K, lens, what.readout)


def disturbed(
    caster: RayCaster, cameras: Cameras, what: Disturbance, seed: int
) -> Capture:
    """Simulates the capture of a real camera.

    Args:
        caster: Casts rays into the scene.
        cameras: The cameras that `true_cameras` returns.
        what: The errors of the capture.
        seed: Seed of all random numbers.
    """
    time = cameras.time + what.delay
    rgb, exact = cameras.images(caster)
    K = pinhole()
    K[[0, 1], [0, 1]] *= 1 + what.focal
    tracker = Tracker(cameras.walk, time, what, seed)
    capture = Capture(
        K=np.tile(K, (len(time), 1, 1)),
        X_WC=tracker.X_WC(time),
        rgb=rgb,
        depth=exact,
        velocity_W=velocity_W(tracker.X_WC, time),
        acceleration_W=acceleration_W(tracker.X_WC, time),
    )
    capture = with_noise(capture, sensor_noise(what.sensor), seed)
    rng = np.random.default_rng([seed, 3])
    z = [
        with_flying_pixels(z, true, what.flying, rng)
        for z, true in zip(capture.depth, exact, strict=True)
    ]
    z = what.scale * np.array(z)
    z = z + what.quadratic * z**2
    return dc.replace(capture, depth=z.astype(np.float32))


def with_flying_pixels(
    z: np.ndarray, exact: np.ndarray, share: float, rng: np.random.Generator
) -> np.ndarray:
    """Returns a depth image with depths between both sides at edges.

    Args:
        z: Measured depths, shape (h, w) [m]; those of 0 stay 0.
        exact: Exact depths, shape (h, w) [m].
        share: Share of the pixels at edges that is changed.
        rng: Source of randomness.
    """
    filled = np.where(exact > 0, exact, FAR)
    low, high = minimum_filter(filled, 3), maximum_filter(exact, 3)
    edge = near_outline(exact) & (high - low > _EDGE * high) & (z > 0)
    flies = edge & (rng.random(z.shape) < share)
    between = low + rng.random(z.shape) * (high - low)
    return np.where(flies, between, z)
