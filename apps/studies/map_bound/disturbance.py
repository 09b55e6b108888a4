"""Disturbances of a perfect capture, like those of real cameras."""

import dataclasses as dc

import numpy as np
from scipy.spatial.transform import Rotation

from remosplat_drake.capture.capture import Capture
from remosplat_drake.capture.rendering.sensor_noise import (
    sensor_noise,
    with_noise,
)


@dc.dataclass(frozen=True)
class Disturbance:
    """Errors of a capture.

    Attributes:
        sensor: Name of a preset of `sensor_noise`.
        position: Standard deviation of each camera's position along each axis
            [m].
        rotation: Standard deviation of each camera's rotation about each axis
            [rad].
        drift: Length by which the positions have drifted at the last view [m].
        scale: Ratio of measured to true depths.
    """

    sensor: str = "none"
    position: float = 0.0
    rotation: float = 0.0
    drift: float = 0.0
    scale: float = 1.0

    def __str__(self) -> str:
        """Describes the errors in a few words."""
        words = {
            self.sensor: self.sensor != "none",
            f"noise {1e3 * self.position:.1f} mm": self.position,
            f"drift {1e3 * self.drift:.1f} mm": self.drift,
            f"depth {100 * (self.scale - 1):+.2f} %": self.scale != 1.0,
        }
        return ", ".join(word for word, is_so in words.items() if is_so)


TURN = np.deg2rad(10)
"""Rotation of drifting poses per metre of drift, like that of visual odometry
[rad/m]."""

EXACT = Disturbance()

NAMED = {
    "exact": EXACT,
    "depth +2 %": Disturbance(scale=1.02),
    "poses 5 mm, 0.15 deg": Disturbance(
        position=0.005, rotation=np.deg2rad(0.15)
    ),
    "drift 50 mm": Disturbance(drift=0.05),
}
"""The disturbances of the review's table."""


def draw_disturbance(rng: np.random.Generator) -> Disturbance:
    """Draws a disturbance; each kind is absent in a part of all cases.

    Pose noise is uniform up to 20 mm, with 0.03 degrees a millimetre; drift
    up to 100 mm; the scale is off by up to 3 % either way.
    """
    position = rng.choice([0.0, 0.02 * rng.random()])
    return Disturbance(
        sensor=str(rng.choice(["none", "kinect", "realsense_d435"])),
        position=position,
        rotation=np.deg2rad(30 * position),
        drift=rng.choice([0.0, 0.1 * rng.random()]),
        scale=rng.choice([1.0, 1 + 0.03 * rng.uniform(-1, 1)]),
    )


def disturbed(capture: Capture, what: Disturbance, seed: int) -> Capture:
    """Returns a capture with the errors of a real camera.

    The drift goes along a smooth random curve that begins at the first view,
    and turns the cameras a little as well.

    Args:
        capture: A perfect capture, its views in the order of time.
        what: The errors.
        seed: Seed of all random numbers.
    """
    rng = np.random.default_rng([seed, 1])
    capture = with_noise(capture, sensor_noise(what.sensor), seed)
    count = len(capture)
    turn = what.rotation * rng.standard_normal((count, 3))
    shift = what.position * rng.standard_normal((count, 3))
    part = np.linspace(0, 1, count)
    shift = shift + what.drift * SmoothCurve.drawn(rng)(part)
    turn = turn + TURN * what.drift * SmoothCurve.drawn(rng)(part)
    X_WC = capture.X_WC.copy()
    R = Rotation.from_rotvec(turn).as_matrix()
    X_WC[:, :3, :3] = R @ X_WC[:, :3, :3]
    X_WC[:, :3, 3] += shift
    depth = (what.scale * capture.depth).astype(np.float32)
    return dc.replace(capture, X_WC=X_WC, depth=depth)


@dc.dataclass(frozen=True, eq=False)
class SmoothCurve:
    """A curve from the origin to a point.

    Attributes:
        end: The point, shape (3,).
        bend: Amplitudes of its two waves, shape (2, 3).
    """

    end: np.ndarray
    bend: np.ndarray

    @staticmethod
    def drawn(rng: np.random.Generator) -> "SmoothCurve":
        """Draws a curve to a random unit vector."""
        end = rng.standard_normal(3)
        end /= np.linalg.norm(end)
        return SmoothCurve(end, 0.3 * rng.standard_normal((2, 3)))

    def __call__(self, part: np.ndarray) -> np.ndarray:
        """Returns points at fractions (n,) of the curve, shape (n, 3)."""
        part = part[:, None]
        return part * self.end + np.sin(np.pi * part * [1, 2]) @ self.bend
