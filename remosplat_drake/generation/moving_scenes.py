"""Draws random moving obstacles (movers) for a scene with a reaching robot.

Movers cross the paths of the hand and of the base, or reach for the robot's
target. Their speeds are at most 1 m/s, except for the swinging limbs of walking
people. At the end, all movers leave, so that the robot can reach the target.
"""

import math

import numpy as np

from remosplat_drake.scene.moving.gait import Reach, Step
from remosplat_drake.scene.moving.mover_track import MoverConfig, WaypointConfig
from remosplat_drake.scene.moving.person import Person
from remosplat_drake.scene.primitive_scene import PrimitiveScene

MOVING_VERSION = 1
"""Version of the generator. Increase it whenever a seed gives other movers."""

MOST_MOVERS = 5
"""A scene has at most this many movers."""

SLOWEST, FASTEST = 0.3, 1.0
"""The greatest speed of a mover that crosses the robot's path, or of a person's
hand, is drawn from this range [m/s]."""

TOLD_SPEED, TOLD_ACCELERATION = 1.6, 4.0
"""Speed limit and acceleration limit of crossing movers, as reported to the
robot: walking speed (ISO 13855) [m/s], and the acceleration of a hand [m/s^2].
"""

START_ROOM = 0.9
"""At the start, movers are at least this far from the middle of the robot [m].
"""

END_ROOM = 1.2
"""At the end, movers are at least this far from the base's path to the target
[m]."""

HAND = np.array([0.6, 0.0, 0.95])
"""Position of the hand at the start, relative to the middle of the base [m]."""


def draw_movers(scene: PrimitiveScene, seed: int) -> list[MoverConfig | Person]:
    """Draws the movers of a scene, deterministically.

    Args:
        scene: The scene, which must have a target and a start.
        seed: Any non-negative integer.
    """
    assert scene.X_WE_target is not None and scene.X_WB_start is not None
    rng = np.random.default_rng(
        [MOVING_VERSION, *b"moving", *scene.name.encode(), seed]
    )
    x, y, yaw = scene.X_WB_start
    base = np.array([x, y, 0.0])
    c, s = math.cos(yaw), math.sin(yaw)
    hand = base + np.array([[c, -s, 0], [s, c, 0], [0, 0, 1]]) @ HAND
    goal = scene.X_WE_target.translation()
    found: list[MoverConfig | Person] = []
    walks = 0
    for i in range(int(rng.integers(1, MOST_MOVERS + 1))):
        kind = rng.choice(["crosses", "reaches", "walks"], p=[0.5, 0.3, 0.2])
        if kind == "walks" and walks == 0:
            walks += 1
            found.append(walker(rng, base, goal))
        elif kind == "reaches":
            found.append(forearm(rng, f"arm {i + 1}", goal))
        else:
            found.append(crosser(rng, f"thing {i + 1}", base, hand, goal))
    return found


def crosser(
    rng: np.random.Generator,
    name: str,
    base: np.ndarray,
    hand: np.ndarray,
    goal: np.ndarray,
) -> MoverConfig:
    """Draws a ball, a stick or a box that crosses the path of the hand.

    Args:
        rng: The random numbers.
        name: Name of the mover.
        base: Start position of the base [m].
        hand: Start position of the hand [m].
        goal: Target of the hand [m].
    """
    speed = rng.uniform(SLOWEST, FASTEST)
    duration = rng.uniform(3.0, 6.0)
    # The mover is at rest at both ends and fastest half-way, where its speed is
    # 1.5 times the mean speed.
    way = speed * duration / 1.5
    start = rng.uniform(0.0, 3.0)
    while True:
        heading = rng.uniform(-math.pi, math.pi)
        rise = rng.uniform(-0.1, 0.1)
        along = np.array([math.cos(heading), math.sin(heading), rise])
        middle = hand + rng.uniform(0.2, 1.0) * (goal - hand)
        middle = middle + rng.uniform(-0.1, 0.1, 3)
        first, last = middle - 0.5 * way * along, middle + 0.5 * way * along
        if np.linalg.norm((first - base)[:2]) > START_ROOM:
            break
    stops = [(start, first), (start + duration, last)]
    if _distance_to_way(last, base, goal) < END_ROOM:
        # The mover continues until it is out of the robot's way.
        gone = _out_of_the_way(last, along, base, goal)
        leaving = 1.6 * np.linalg.norm(gone - last) / speed + 0.5
        stops.append((float(start + duration + leaving), gone))
    size = rng.uniform(0.04, 0.12)
    half_extents = [
        [0.0, 0.0, 0.0],
        [0.0, 0.0, float(rng.uniform(0.1, 0.3))],
        rng.uniform(0.05, 0.15, 3).tolist(),
    ][int(rng.integers(3))]
    angles = np.degrees(rng.uniform(-math.pi, math.pi, (len(stops), 3)))
    # The mover turns slightly during the motion.
    angles[1:] = angles[0] + 0.1 * (angles[1:] - angles[0])
    return MoverConfig(
        name=name,
        half_extents=half_extents,
        radius=float(0.01 if all(half_extents) else size),
        max_speed=TOLD_SPEED,
        max_acceleration=TOLD_ACCELERATION,
        waypoints=[
            WaypointConfig(float(t), p.tolist(), a.tolist())
            for (t, p), a in zip(stops, angles, strict=True)
        ],
    )


def _distance_to_way(
    p: np.ndarray, base: np.ndarray, goal: np.ndarray
) -> float:
    """Distance in the plane from a point to the straight way to the goal."""
    way = (goal - base)[:2]
    share = np.clip((p - base)[:2] @ way / (way @ way), 0.0, 1.0)
    return float(np.linalg.norm((p - base)[:2] - share * way))


def _out_of_the_way(
    p: np.ndarray, along: np.ndarray, base: np.ndarray, goal: np.ndarray
) -> np.ndarray:
    """Returns a point far from the path, on the mover's side of it."""
    way = (goal - base)[:2] / np.linalg.norm((goal - base)[:2])
    across = np.array([-way[1], way[0]])
    middle = 0.5 * (base + goal)[:2]
    side = np.sign(across @ (p[:2] - middle)) or 1.0
    if abs(across @ along[:2]) > 0.3:
        side = np.sign(across @ along[:2])
    ahead = way @ (p[:2] - middle)
    gone = middle + ahead * way + 1.3 * END_ROOM * side * across
    return np.array([*gone, p[2]])


def forearm(
    rng: np.random.Generator, name: str, goal: np.ndarray
) -> MoverConfig:
    """Draws a forearm that reaches for the robot's target and withdraws.

    Args:
        rng: The random numbers.
        name: Name of the mover.
        goal: Target position of the robot's hand [m].
    """
    speed = rng.uniform(SLOWEST, FASTEST)
    half_length = 0.2
    # The forearm comes from the far side, a little from above.
    heading = rng.uniform(-1.1, 1.1)
    along = np.array([-math.cos(heading), -math.sin(heading), -0.25])
    along /= np.linalg.norm(along)
    there = goal + rng.normal(0.0, 0.05, 3) + [0.0, 0.0, 0.05]
    there = there - half_length * along
    out = there - 1.2 * along
    swing = 1.5 * 1.2 / speed
    start, stay = rng.uniform(0.0, 4.0), rng.uniform(0.5, 2.5)
    times = np.cumsum([start, swing, stay, swing])
    # The capsule's z axis is along the forearm.
    pitch = math.degrees(math.acos(along[2]))
    yaw = math.degrees(math.atan2(along[1], along[0]))
    return MoverConfig(
        name=name,
        half_extents=[0.0, 0.0, half_length],
        radius=0.05,
        max_speed=TOLD_SPEED,
        max_acceleration=TOLD_ACCELERATION,
        waypoints=[
            WaypointConfig(float(t), p.tolist(), [0.0, pitch, yaw])
            for t, p in zip(times, (out, there, there, out), strict=True)
        ],
    )


def walker(
    rng: np.random.Generator, base: np.ndarray, goal: np.ndarray
) -> Person:
    """Draws a person who walks between the robot and its target, or behind it.

    With a probability of one half, the person stops behind the target, reaches
    for it, and continues.

    Args:
        rng: The random numbers.
        base: Start position of the base [m].
        goal: Target position of the robot's hand [m].
    """
    side = rng.choice([-1.0, 1.0])
    start = rng.uniform(0.0, 3.0)
    if rng.uniform() < 0.5:
        x = base[0] + rng.uniform(0.9, 1.2)
        y = base[1] - side * 2.2, base[1] + side * 2.2
        time = start, start + 1.5 * 4.4 / FASTEST
        return Person(
            walk=[
                Step(float(t), [float(x), float(v)])
                for t, v in zip(time, y, strict=True)
            ]
        )
    x = goal[0] + rng.uniform(0.75, 0.85)
    y = goal[1] + 0.15
    stay = rng.uniform(3.0, 5.0)
    there = start + 1.5 * 2.0 / FASTEST
    steps = [
        (start, y - side * 2.0, None),
        (there, y, 180.0),
        (there + stay, y, 180.0),
        (there + stay + 3.0, y + side * 2.0, None),
    ]
    swing = 0.9
    point = goal + np.array([0.05, 0.0, rng.uniform(0.05, 0.15)])
    return Person(
        walk=[Step(float(t), [float(x), float(v)], w) for t, v, w in steps],
        reaches=[
            Reach(float(there), float(stay - 2 * swing), swing, point.tolist())
        ],
    )
