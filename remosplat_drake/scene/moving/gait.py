"""Computes the walk and the reaching motions of a person.

The result is the positions of the ends of a person's limbs over time. The
proportions, as fractions of a person's height, are those of Winter,
"Biomechanics and motor control of human movement". Legs swing as straight rods
about the hips. Arms, with bent elbows, swing in antiphase. One period is a
stride.
"""

import dataclasses as dc
import math
from collections.abc import Sequence
from typing import Annotated

import numpy as np
import scipy
from annotated_types import Interval, Len

from remosplat_drake.base.ranges import AngleDeg, Config, Coordinate, Position

KNOT_PERIOD = 0.05
"""Time between two knots of a limb's curve [s]."""

STRIDE = 0.8
"""Length of a stride (two steps), as a fraction of the person's height."""

LEG_SWING, ARM_SWING = math.radians(24), math.radians(20)
"""Greatest angles of legs and arms from the vertical, at walking speed
[rad]."""

WALKING_SPEED = 1.0
"""The legs' greatest angles do not increase above this walking speed [m/s]."""

HIP, SHOULDER, HEAD = 0.53, 0.82, 0.92
"""Heights of joints and of the head's middle, as fractions of the height."""

UPPER_ARM, FOREARM = 0.186, 0.20
"""Lengths from the shoulder to the elbow, and from there to the middle of the
hand, as fractions of the height."""

HIP_WIDTH, SHOULDER_WIDTH = 0.055, 0.115
"""Distances of hips and shoulders from the body's middle, as fractions of the
height."""

RADIUS = {
    "body": 0.17,
    "head": 0.11,
    "left leg": 0.08,
    "right leg": 0.08,
    "left upper arm": 0.055,
    "left forearm": 0.05,
    "right upper arm": 0.055,
    "right forearm": 0.05,
}
"""Radii of a person's parts, including clothes [m]."""


Time = Annotated[float, Interval(ge=0, le=1e5)]
"""Time since the run began [s]."""


@dc.dataclass
class Step(Config):
    """Position of a person on the floor at a given time."""

    # Time since the run began [s].
    time: Time = 0.0
    # Position x, y between the feet in W [m].
    position: Annotated[list[Coordinate], Len(2, 2)] = dc.field(
        default_factory=lambda: [0.0, 0.0]
    )
    # Direction in which the person faces, from W's x axis; absent: the walking
    # direction [deg].
    yaw_deg: AngleDeg | None = None


@dc.dataclass
class Reach(Config):
    """A point for which a person reaches with the right hand."""

    # Time at which the hand begins to leave the person's side [s].
    time: Time = 0.0
    # Time for which the hand stays at the point [s].
    duration: Annotated[float, Interval(ge=0, le=1000)] = 1.0
    # Duration of the motion to the point, and of the motion back [s].
    swing: Annotated[float, Interval(ge=0.2, le=100)] = 1.0
    # The point in W [m]. If it is farther than the arm's length, the hand
    # stretches towards it.
    point: Position = dc.field(default_factory=lambda: [0.0] * 3)

    @property
    def end(self) -> float:
        """Time at which the hand is at the person's side again [s]."""
        return self.time + self.duration + 2.0 * self.swing


def person_ends(
    height: float, walk: Sequence[Step], reaches: Sequence[Reach]
) -> tuple[np.ndarray, np.ndarray, dict[str, float]]:
    """Computes the positions of the ends of a person's parts.

    Args:
        height: The person's height [m].
        walk: Positions of the person over time.
        reaches: The reaching motions.

    Returns:
        The knots' times, shape (n,) [s]; the ends of the k parts' axes in W,
        shape (n, k, 2, 3) [m]; and the parts' radii by their names [m].
    """
    first = min([walk[0].time, *(reach.time for reach in reaches)])
    last = max([walk[-1].time, *(reach.end for reach in reaches)])
    n = max(3, math.ceil((last - first) / KNOT_PERIOD) + 1)
    times = np.linspace(first, max(last, first + KNOT_PERIOD), n)
    p_WP, yaw, phase, share = _walk(height, walk, times)
    ends = np.array(
        [_parts(height, *now) for now in zip(phase, share, strict=True)]
    )
    c, s = np.cos(yaw), np.sin(yaw)
    R_WP = np.zeros((n, 3, 3))
    R_WP[:, 0, 0], R_WP[:, 0, 1], R_WP[:, 1, 0] = c, -s, s
    R_WP[:, 1, 1] = c
    R_WP[:, 2, 2] = 1.0
    ends = np.einsum("nij,nkej->nkei", R_WP, ends)
    ends[..., :2] += p_WP[:, None, None, :]
    if reaches:
        _reach(height, reaches, times, R_WP, ends)
    return times, ends, RADIUS


def _walk(
    height: float, walk: Sequence[Step], times: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Returns position, heading, phase of the stride, and limb swing."""
    knots = np.array([step.time for step in walk])
    p = np.array([step.position for step in walk])
    if len(knots) == 1:
        yaw = math.radians(walk[0].yaw_deg or 0.0)
        zeros = np.zeros(len(times))
        return np.repeat(p, len(times), axis=0), zeros + yaw, zeros, zeros
    way = scipy.interpolate.CubicSpline(knots, p, bc_type="clamped")
    now = np.clip(times, knots[0], knots[-1])
    speed = np.linalg.norm(way(now, 1), axis=1)
    step = np.diff(times, prepend=times[0])
    phase = np.cumsum(2.0 * np.pi * speed * step / (STRIDE * height))
    heading = _smooth_steps(knots, np.unwrap(_headings(walk, p)), now)
    # The limbs come to rest at the same time as the person.
    share = speed**2 / (speed**2 + (0.5 * WALKING_SPEED) ** 2)
    return way(now), heading, phase, share


def _headings(walk: Sequence[Step], p: np.ndarray) -> np.ndarray:
    """Returns the headings at the steps: given ones, or walking directions."""
    ways = np.diff(p, axis=0)
    ahead = np.arctan2(ways[:, 1], ways[:, 0])
    # A standing person keeps the heading.
    for i in range(len(ahead)):
        if not ways[i].any():
            ahead[i] = ahead[i - 1] if i else 0.0
    ahead = np.unwrap(ahead)
    found = np.concatenate(
        [ahead[:1], 0.5 * (ahead[1:] + ahead[:-1]), ahead[-1:]]
    )
    for i, step in enumerate(walk):
        if step.yaw_deg is not None:
            found[i] = math.radians(step.yaw_deg)
    return found


def _parts(height: float, phase: float, share: float) -> np.ndarray:
    """Returns the ends of all parts in the person's frame P: x ahead, z up."""
    hip, shoulder = HIP * height, SHOULDER * height
    swing = share * math.sin(phase)
    parts: list = [
        [[0, 0, hip], [0, 0, shoulder - RADIUS["body"]]],
        [[0, 0, HEAD * height], [0, 0, (HEAD + 0.02) * height]],
    ]
    length = hip - RADIUS["left leg"]
    for side in (1.0, -1.0):
        angle = side * LEG_SWING * swing
        top = np.array([0.0, side * HIP_WIDTH * height, hip])
        parts.append([top, top + length * _down(angle)])
    for side in (1.0, -1.0):
        angle = -side * ARM_SWING * swing
        top = np.array([0.0, side * SHOULDER_WIDTH * height, shoulder])
        elbow = top + UPPER_ARM * height * _down(angle)
        bend = angle + 0.25 + 0.25 * share
        parts += [
            [top, elbow],
            [elbow, elbow + FOREARM * height * _down(bend)],
        ]
    return np.array(parts, float)


def _down(angle: float) -> np.ndarray:
    """Unit vector along a hanging limb that is swung ahead by an angle."""
    return np.array([math.sin(angle), 0.0, -math.cos(angle)])


def _reach(
    height: float,
    reaches: Sequence[Reach],
    times: np.ndarray,
    R_WP: np.ndarray,
    ends: np.ndarray,
) -> None:
    """Moves the right hand to the points and back; the elbow follows."""
    names = list(RADIUS)
    upper, lower = names.index("right upper arm"), names.index("right forearm")
    hand = ends[:, lower, 1].copy()
    for reach in reaches:
        out = _smooth((times - reach.time) / reach.swing)
        back = _smooth((reach.end - times) / reach.swing)
        share = np.minimum(out, back)[:, None]
        hand += share * (np.array(reach.point) - hand)
    lengths = UPPER_ARM * height, FOREARM * height
    for i, shoulder in enumerate(ends[:, upper, 0]):
        elbow, reached = _bent_arm(shoulder, hand[i], *lengths, R_WP[i])
        ends[i, upper, 1] = ends[i, lower, 0] = elbow
        ends[i, lower, 1] = reached


def _bent_arm(
    shoulder: np.ndarray,
    hand: np.ndarray,
    upper: float,
    lower: float,
    R_WP: np.ndarray,
) -> tuple[np.ndarray, np.ndarray]:
    """Returns elbow and hand of a reaching arm, its elbow down and outward."""
    way = hand - shoulder
    far = float(np.linalg.norm(way))
    # For a near point, this value is nearly the distance; for a far point, it
    # stays below the length of a straight arm.
    most = 0.99 * (upper + lower)
    reached = far / (1.0 + (far / most) ** 8) ** (1.0 / 8.0)
    along = way / far
    hand = shoulder + reached * along
    ahead = (reached**2 + upper**2 - lower**2) / (2.0 * reached)
    aside = math.sqrt(max(upper**2 - ahead**2, 0.0))
    out = R_WP @ np.array([-0.4, -0.5, -1.0])
    out -= along * (out @ along)
    out /= np.linalg.norm(out)
    return shoulder + ahead * along + aside * out, hand


def _smooth_steps(
    knots: np.ndarray, values: np.ndarray, times: np.ndarray
) -> np.ndarray:
    """Interpolates values smoothly, with rate zero at each value."""
    k = np.clip(np.searchsorted(knots, times, "right") - 1, 0, len(knots) - 2)
    x = (times - knots[k]) / (knots[k + 1] - knots[k])
    return values[k] + _smooth(x) * (values[k + 1] - values[k])


def _smooth(x: np.ndarray) -> np.ndarray:
    """Rises from 0 to 1, at rest at both ends, with continuous acceleration."""
    x = np.clip(x, 0.0, 1.0)
    return x**3 * (10 - 15 * x + 6 * x**2)
