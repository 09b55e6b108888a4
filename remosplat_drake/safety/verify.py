"""Verify-then-scale: no command reaches a state that the map forbids.

The damper rows of the program are linear in u and hold at the tick's start;
the state one tick later is checked against the map itself.
"""

import numpy as np

from remosplat_drake.oracle.distance_field import DistanceField
from remosplat_drake.robot.robot_model import RobotModel, RobotState

SCALES = (1.0, 0.5, 0.25, 0.125, 0.0625, 0.03125)
"""Fractions of a command that are tried before standing still."""


def safe_scale(
    robot: RobotModel,
    field: DistanceField,
    state: RobotState,
    u: np.ndarray,
    dt: float,
    stopping_distance: float,
    clearance: np.ndarray,
) -> float:
    """The largest tried fraction of u that every sphere survives.

    A fraction passes if, after holding it for dt, each sphere is at least
    min(stopping_distance, its present clearance) from the scene. There is no
    tolerance, which would let the clearance creep down tick by tick; zero
    always passes, because the scene is static and the map deterministic.

    Args:
        robot: Predicts the next state.
        field: The map.
        state: Kinematics at the present configuration.
        u: The command, shape (n_u,).
        dt: Control period [s].
        stopping_distance: d_s [m].
        clearance: Present clearance of each sphere, or a lower bound of it
            that is at least d_s, shape (n,) [m].

    Returns:
        A factor in [0, 1] for the whole vector u.
    """
    floor = np.minimum(stopping_distance, clearance)
    for scale in SCALES:
        q_next = robot.advance(state.q, scale * u, dt)
        if _clears(robot, field, state, q_next, floor, clearance):
            return scale
    return 0.0


def _clears(
    robot: RobotModel,
    field: DistanceField,
    state: RobotState,
    q_next: np.ndarray,
    floor: np.ndarray,
    clearance: np.ndarray,
) -> bool:
    spheres = robot.spheres_at(q_next)
    if field.is_lipschitz:
        moved = np.linalg.norm(spheres.p_WS - state.spheres.p_WS, axis=1)
        index = np.flatnonzero(clearance - moved <= floor)
        if not len(index):
            return True
        spheres, floor = spheres.select(index), floor[index]
    reach = float(floor.max())
    near = field.clearances(spheres, np.nextafter(reach, np.inf))
    return bool((near.per_sphere(len(spheres)) >= floor).all())
