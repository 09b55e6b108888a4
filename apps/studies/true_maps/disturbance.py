"""`Disturbance`: errors of a capture, by name or drawn at random."""

import dataclasses as dc

import numpy as np


@dc.dataclass(frozen=True)
class Disturbance:
    """Errors of a capture; the default has none.

    Attributes:
        sensor: Name of a preset of `sensor_noise`.
        flying: Share of the pixels at edges whose depth lies between the
            foreground's and the background's.
        drift: Length by which the positions have drifted at the last view [m].
        late_loop: Length by which the positions have drifted when a loop is
            closed, after four fifths of the walk; later positions are exact
            [m].
        jump: Length by which tracking jumps at one moment, for good [m].
        focal: Relative error of the focal length in K; positive: too large.
        principal: Distance of K's principal point from the true one, in
            widths of the image.
        k1: Radial distortion of the lens, which K does not contain.
        readout: Time from the first row of an image to the last [s]; poses
            are those of the middle row.
        scale: Ratio of measured to true depths.
        quadratic: Depths z are too large by this times z^2 [1/m].
        delay: Time by which poses are newer than their images [s].
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
        """Describes the errors in a few words."""
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
    """Draws a disturbance; a third of all cases has each kind.

    One case in eight has none. Sizes are uniform up to the largest; signed ones
    are positive or negative.
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
