"""Random states of a robot in a known scene, and distance errors there."""

import numpy as np

from remosplat_drake.robot.robot_model import RobotModel
from remosplat_drake.robot.sphere_model import Spheres
from remosplat_drake.signals.distance_field import DistanceField

BASE_LOWER, BASE_UPPER = (-0.5, -1.2, -np.pi / 2), (0.8, 1.2, np.pi / 2)
"""Bounds of a mobile base's pose before the scene: x, y, yaw [m, m, rad]."""

INFLUENCE = 0.5
"""Influence distance of the controller [m]."""


def free_states(
    robot: RobotModel, truth: DistanceField, count: int, seed: int = 0
) -> np.ndarray:
    """Draws random configurations that touch nothing, shape (count, n_q).

    Joints are uniform within their limits, a base within `BASE_LOWER` and
    `BASE_UPPER`. Only states with a sphere within `INFLUENCE` of the scene are
    used.

    Args:
        robot: Model of the robot.
        truth: Distances to the true scene.
        count: Number of configurations.
        seed: Seed of the random numbers.
    """
    rng = np.random.default_rng(seed)
    lower, upper = robot.position_lower.copy(), robot.position_upper.copy()
    if robot.n_base:
        lower[:3], upper[:3] = BASE_LOWER, BASE_UPPER
    states = []
    while len(states) < count:
        q = rng.uniform(lower, upper)
        clearance = truth.clearances(robot.spheres_at(q)).minimum()
        if 0 < clearance < INFLUENCE:
            states.append(q)
    return np.array(states)


def distance_errors(
    robot: RobotModel,
    field: DistanceField,
    truth: DistanceField,
    states: np.ndarray,
) -> tuple[np.ndarray, Spheres]:
    """Measures the errors of a map's distances, over all spheres in its range.

    Args:
        robot: Model of the robot.
        field: Distances by the map. A sphere without a surface in range has the
            distance `INFLUENCE`, as for the controller.
        truth: Distances to the true scene.
        states: Configurations, shape (k, n_q).

    Returns:
        Measured minus true distance of the spheres that are truly within
        `INFLUENCE`, shape (m,) [m], and those spheres.
    """
    n = len(robot.spheres)
    placed = [robot.spheres_at(q) for q in states]
    spheres = Spheres(
        np.concatenate([s.p_WS for s in placed]),
        np.concatenate([s.R_WL for s in placed]),
        np.concatenate([s.radius for s in placed]),
        np.concatenate([s.ignore_below for s in placed]),
    )
    total = n * len(states)
    expected = truth.clearances(spheres).per_sphere(total)
    near = expected < INFLUENCE
    spheres = spheres.select(near)
    measured = field.clearances(spheres, INFLUENCE).per_sphere(len(spheres))
    return np.minimum(measured, INFLUENCE) - expected[near], spheres
