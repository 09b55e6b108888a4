"""Disturbances of captures, as carried cameras and their trackers make them."""

import dataclasses as dc
from collections.abc import Callable

import numpy as np
from scipy.ndimage import maximum_filter, minimum_filter
from scipy.spatial.transform import Rotation

from apps.studies.map_bound.disturbance import TURN, SmoothCurve
from apps.studies.true_maps.cameras import (
    FAR,
    WIDTH,
    Cameras,
    pinhole,
)
from apps.studies.true_maps.ray_casting import RayCaster
from apps.studies.true_maps.walk import RATE, Walk
from remosplat_drake.capture.capture import Capture
from remosplat_drake.capture.rendering.sensor_noise import (
    near_outline,
    sensor_noise,
    with_noise,
)
from remosplat_drake.capture.undistortion import Distortion

_CLOSED = 0.8
"""Part of the walk after which a late loop is closed."""

_EDGE = 0.02
"""An edge's two sides differ by more than this part of their depth."""

_STEP = 1e-4
"""Time by which a pose is moved to find its velocity [s]."""


@dc.dataclass(frozen=True)
class Disturbance:
    """What is wrong with a capture; the default is nothing.

    Attributes:
        sensor: Name of a preset of `sensor_noise`.
        flying: Share of the pixels at edges whose depth lies between the
            foreground's and the background's.
        drift: Length by which the positions have drifted at the last view [m].
        late_loop: Length by which the positions have drifted when a loop is
            closed, after four fifths of the walk; the rest is right [m].
        jump: Length by which tracking jumps at one moment, for good [m].
        focal: By what part the focal length in K is too large.
        principal: Distance of K's principal point from the true one, in
            widths of the image.
        k1: Radial distortion of the lens, which K knows nothing of.
        readout: Time from the first row of an image to the last [s]; poses
            are those of the middle row.
        scale: How many times too large the depths are.
        quadratic: Depths z are too large by this times z^2 [1/m].
        delay: How much newer the poses are than their images [s].
        hand_eye: Length of the error of the camera's position in its mount
            [m].
        hand_eye_turn: Angle of the error of its rotation [rad].
    """

    sensor: str = "none"
    flying: float = 0.0
    drift: float = 0.0
    late_loop: float = 0.0
    jump: float = 0.0
    focal: float = 0.0
    principal: float = 0.0
    k1: float = 0.0
    readout: float = 0.0
    scale: float = 1.0
    quadratic: float = 0.0
    delay: float = 0.0
    hand_eye: float = 0.0
    hand_eye_turn: float = 0.0

    def __str__(self) -> str:
        """What is wrong, in a few words."""
        words = {
            self.sensor: self.sensor != "none",
            f"flying {100 * self.flying:.0f} %": self.flying,
            f"drift {1e3 * self.drift:.0f} mm": self.drift,
            f"late loop {1e3 * self.late_loop:.0f} mm": self.late_loop,
            f"jump {1e3 * self.jump:.0f} mm": self.jump,
            f"focal {100 * self.focal:+.1f} %": self.focal,
            f"principal {100 * self.principal:.2f} %": self.principal,
            f"k1 {self.k1:+.3f}": self.k1,
            f"readout {1e3 * self.readout:.0f} ms": self.readout,
            f"depth {100 * (self.scale - 1):+.1f} %": self.scale != 1,
            f"z^2 {self.quadratic:+.4f}": self.quadratic,
            f"delay {1e3 * self.delay:.0f} ms": self.delay,
            f"hand-eye {1e3 * self.hand_eye:.1f} mm"
            f" {np.rad2deg(self.hand_eye_turn):.1f} deg": self.hand_eye
            or self.hand_eye_turn,
        }
        return ", ".join(word for word, is_so in words.items() if is_so)


EXACT = Disturbance()

NAMED = {
    "exact": EXACT,
    "kinect": Disturbance("kinect"),
    "kinect, flying 30 %": Disturbance("kinect", flying=0.3),
    "late loop 80 mm": Disturbance(late_loop=0.08),
    "jump 40 mm": Disturbance(jump=0.04),
    "z^2 0.01": Disturbance(quadratic=0.01),
    "distortion": Disturbance(k1=0.05),
    "focal -3 %": Disturbance(focal=-0.03),
    "rolling shutter 30 ms": Disturbance(readout=0.03),
    "delay 100 ms": Disturbance(delay=0.1),
    "hand-eye 5 mm, 2 deg": Disturbance(
        hand_eye=0.005, hand_eye_turn=np.deg2rad(2)
    ),
}
"""The disturbances of the report's table."""

PRESENT = 1 / 3
"""Probability of each kind of disturbance."""


UNDISTURBED = 1 / 8
"""Probability of a capture without any."""


def draw_disturbance(rng: np.random.Generator) -> Disturbance:
    """Draws a disturbance: each kind is there in a third of all cases.

    One case in eight has none. Sizes are uniform up to the largest; those with
    a sign go either way.
    """
    if rng.random() < UNDISTURBED:
        return EXACT

    def upto(most: float) -> float:
        return float(most * rng.random() * (rng.random() < PRESENT))

    def either(most: float) -> float:
        return float(most * rng.uniform(-1, 1) * (rng.random() < PRESENT))

    hand_eye = upto(1.0)
    return Disturbance(
        sensor=str(rng.choice(["none", "kinect", "realsense_d435"])),
        flying=upto(0.4),
        drift=upto(0.08),
        late_loop=upto(0.08),
        jump=upto(0.04),
        focal=either(0.03),
        principal=upto(0.01),
        k1=either(0.05),
        readout=upto(0.03),
        scale=1 + either(0.02),
        quadratic=either(0.01),
        delay=upto(0.1),
        hand_eye=0.005 * hand_eye,
        hand_eye_turn=float(np.deg2rad(2)) * hand_eye,
    )


def true_cameras(
    walk: Walk, time: np.ndarray, what: Disturbance, seed: int
) -> Cameras:
    """Returns the cameras that really take the images of a capture.

    Args:
        walk: The camera's path.
        time: Times of the poses, shape (n,) [s].
        what: What is wrong.
        seed: Seed of all that is random.
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
    """Takes a capture as it comes from a real camera.

    Args:
        caster: Casts rays into the scene.
        cameras: The cameras that `true_cameras` returns.
        what: What is wrong with the capture.
        seed: Seed of all that is random.
    """
    time = cameras.time + what.delay
    rgb, exact = cameras.images(caster)
    K = pinhole()
    K[[0, 1], [0, 1]] *= 1 + what.focal
    pose = _given_pose(cameras.walk, time, what, seed)
    capture = Capture(
        K=np.tile(K, (len(time), 1, 1)),
        X_WC=pose(time),
        rgb=rgb,
        depth=exact,
        velocity_W=velocity(pose, time),
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


def velocity(
    pose: Callable[[np.ndarray], np.ndarray], time: np.ndarray
) -> np.ndarray:
    """Returns angular velocities [rad/s], then those of centres [m/s], in W.

    Args:
        pose: Poses at times (n,), shape (n, 4, 4).
        time: The times, shape (n,) [s].
    """
    before, after = pose(time - _STEP), pose(time + _STEP)
    R = after[:, :3, :3] @ before[:, :3, :3].transpose(0, 2, 1)
    turned = Rotation.from_matrix(R).as_rotvec()
    moved = after[:, :3, 3] - before[:, :3, 3]
    return np.concatenate([turned, moved], axis=1) / (2 * _STEP)


def with_flying_pixels(
    z: np.ndarray, exact: np.ndarray, share: float, rng: np.random.Generator
) -> np.ndarray:
    """Returns a depth image in which pixels at edges show what is between.

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


def _given_pose(
    walk: Walk, time: np.ndarray, what: Disturbance, seed: int
) -> Callable[[np.ndarray], np.ndarray]:
    """The poses that a tracker tells, as a function of time (n,) [s]."""
    rng = np.random.default_rng([seed, 2])
    drift, turn, loop, loop_turn = (SmoothCurve.drawn(rng) for _ in range(4))
    jump, jump_turn, hand, hand_turn = rng.standard_normal((4, 3))
    jump, jump_turn, hand, hand_turn = (
        vector / np.linalg.norm(vector)
        for vector in (jump, jump_turn, hand, hand_turn)
    )
    start, seconds = time[0], time[-1] - time[0]
    half_way = 0.5 / RATE  # No image is taken where tracking jumps.
    jumps = time[int(rng.uniform(0.2, 0.8) * len(time))] + half_way
    closed = time[int(_CLOSED * len(time)) - 1] + half_way
    X_CD = np.eye(4)
    X_CD[:3, 3] = what.hand_eye * hand
    angle = what.hand_eye_turn * hand_turn
    X_CD[:3, :3] = Rotation.from_rotvec(angle).as_matrix()

    def pose(at: np.ndarray) -> np.ndarray:
        part = (at - start) / seconds
        late = (at < closed)[:, None] * part[:, None] / _CLOSED
        # A loop's drift is largest where it is closed.
        opened = what.late_loop * (at < closed)[:, None]
        jumped = what.jump * (at > jumps)[:, None]
        shift = (
            what.drift * drift(part) + opened * loop(late[:, 0]) + jumped * jump
        )
        turned = TURN * (
            what.drift * turn(part)
            + opened * loop_turn(late[:, 0])
            + jumped * jump_turn
        )
        X_WC = walk.X_WC(at)
        R = Rotation.from_rotvec(turned).as_matrix()
        X_WC[:, :3, :3] = R @ X_WC[:, :3, :3]
        X_WC[:, :3, 3] += shift
        return X_WC @ X_CD

    return pose
