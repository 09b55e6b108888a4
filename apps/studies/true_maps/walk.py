"""`Walk`: the path of a camera that a person carries around a point.

It is a function of time, so that images may have other times than their poses,
and rows of one image different times.
"""

import dataclasses as dc

import numpy as np

from apps.studies.true_maps.scene import MeshScene

RATE = 10.0
"""Images per second [1/s]."""

NEAREST, FARTHEST = 0.6, 1.6
"""Range of the camera's distance from the focus [m]."""

_FASTEST = 0.6
"""Largest speed around the focus, towards it, and up and down [m/s]."""

_TREMOR = 0.001, float(np.deg2rad(0.1))
"""Amplitudes of a hand's tremor: positions [m] and directions [rad]."""


@dc.dataclass(frozen=True, eq=False)
class Walk:
    """A smooth walk around a point, to and fro, that looks at it.

    Each row of `waves` is a sine: amplitude, frequency [Hz], phase [rad].

    Attributes:
        focus_W: The point, shape (3,) [m].
        mean: Azimuth [rad], distance from the focus [m] and elevation [rad]
            in the middle of the walk, shape (3,).
        waves: Waves of these three values, shape (3, k, 3).
        look: Waves of the viewed point's distance from the focus along x, y and
            z [m], and of the camera's roll [rad], shape (4, k, 3).
    """

    focus_W: np.ndarray
    mean: np.ndarray
    waves: np.ndarray
    look: np.ndarray

    def X_WC(self, time: np.ndarray) -> np.ndarray:
        """Computes the camera's poses (OpenCV axes) at times (...) [s].

        Returns:
            Shape (..., 4, 4).
        """
        time = np.asarray(time, float)
        azimuth, distance, elevation = (
            mean + _sum(waves, time)
            for mean, waves in zip(self.mean, self.waves, strict=True)
        )
        *aside, roll = (_sum(waves, time) for waves in self.look)
        level = np.cos(elevation)
        away_W = [
            level * np.cos(azimuth),
            level * np.sin(azimuth),
            np.sin(elevation),
        ]
        X_WC = np.zeros((*time.shape, 4, 4))
        X_WC[..., :3, 3] = self.focus_W
        X_WC[..., :3, 3] += distance[..., None] * np.stack(away_W, axis=-1)
        X_WC[..., 3, 3] = 1
        z_W = self.focus_W + np.stack(aside, axis=-1) - X_WC[..., :3, 3]
        z_W /= np.linalg.norm(z_W, axis=-1, keepdims=True)
        x_W = np.cross(z_W, [0, 0, 1])
        x_W /= np.linalg.norm(x_W, axis=-1, keepdims=True)
        y_W = np.cross(z_W, x_W)
        c, s = np.cos(roll)[..., None], np.sin(roll)[..., None]
        axes = c * x_W + s * y_W, c * y_W - s * x_W, z_W
        X_WC[..., :3, :3] = np.stack(axes, axis=-1)
        return X_WC


def draw_walk(
    scene: MeshScene, seconds: float, rng: np.random.Generator
) -> Walk:
    """Draws a walk on the open side of a scene.

    Args:
        scene: The scene.
        seconds: Length of the walk [s].
        rng: Source of randomness.
    """
    half = 0.5 * (FARTHEST - NEAREST)
    distance = rng.uniform(0.3, 1.0) * half
    mean = np.array(
        [
            scene.open_to,
            NEAREST + half + rng.uniform(-1, 1) * (half - distance),
            np.deg2rad(rng.uniform(25, 40)),
        ]
    )
    # From one end to the other, and at most back again.
    turns = rng.uniform(0.5, 1.0) / seconds
    azimuth = rng.uniform(0.6, 1.0) * scene.open_by
    azimuth = min(azimuth, _widest(turns) / mean[1])
    mean[0] += rng.uniform(-1, 1) * (scene.open_by - azimuth)
    slow = rng.uniform(0.6, 1.7, 2) / seconds
    elevation = np.deg2rad(rng.uniform(5, 20))
    elevation = min(elevation, _widest(slow[1]) / mean[1])
    phase = rng.uniform(0, 2 * np.pi, 2)
    waves = [
        [azimuth, turns, -np.pi / 2],
        [min(distance, _widest(slow[0])), slow[0], phase[0]],
        [elevation, slow[1], phase[1]],
    ]
    aside = _drawn([0.08, 0.08, 0.08, 0.06], 0.15, 0.4, rng)
    place, angle = _TREMOR
    shaken = _drawn([angle, place, angle], 1.5, 4.0, rng)
    looked = _drawn([place, place, place, angle], 1.5, 4.0, rng)
    return Walk(
        scene.focus_W,
        mean,
        np.stack([waves, shaken], axis=1),
        np.stack([aside, looked], axis=1),
    )


def _widest(frequency: float) -> float:
    """Amplitude of a wave [m] with the largest speed of a hand."""
    return _FASTEST / (2 * np.pi * frequency)


def _drawn(
    amplitude: list[float],
    slowest: float,
    fastest: float,
    rng: np.random.Generator,
) -> np.ndarray:
    """Waves of given amplitudes and random frequencies [Hz] and phases."""
    size = len(amplitude), 2
    rest = rng.uniform([slowest, 0], [fastest, 2 * np.pi], size)
    return np.column_stack([amplitude, rest])


def _sum(waves: np.ndarray, time: np.ndarray) -> np.ndarray:
    amplitude, frequency, phase = waves.T
    angle = 2 * np.pi * frequency * time[..., None] + phase
    return (amplitude * np.sin(angle)).sum(axis=-1)
