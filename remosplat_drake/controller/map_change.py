"""Checks that a moving robot may go over to another map or pose in it.

A command was verified in the map that counted when it was computed. Between two
ticks, while it is being executed, another map may take that one's place if the
rest of the command and its braking ramp are allowed there, too: then the next
tick finds a ramp that has been verified by `verify`.
"""

import numpy as np

from remosplat_drake.controller.tick.reactive_law import ReactiveLaw
from remosplat_drake.controller.verification.verify import Surroundings
from remosplat_drake.signals.distance_field import DistanceField

NO_WAY_TO_STOP = "the new map leaves too little room to stop"


def objection(
    law: ReactiveLaw, field: DistanceField, q: np.ndarray, u: np.ndarray
) -> str:
    """Says why a map must not be changed to while a command is executed.

    A robot at rest may always change: it moves no nearer to anything, and
    its supervisor judges where it stands.

    Args:
        law: The control law that verifies commands.
        field: The map.
        q: Configuration in it, shape (n_q,) [rad, m].
        u: The command that is executed, shape (n_u,) [rad/s, m/s]; all of a
            tick of it is taken to lie ahead.

    Returns:
        The reason for people; empty if the map may count.
    """
    if not (law.verify and u.any()):
        return ""
    state, influence = law.robot.state(q), law.collision.influence
    clearances = field.clearances(state.spheres, influence)
    if not clearances.is_known:
        return f"{NO_WAY_TO_STOP}: clearances are not finite"
    around = Surroundings(
        law.robot,
        field,
        state,
        np.minimum(clearances.per_sphere(len(state.spheres)), influence),
        law.collision.stopping,
        law.dt,
        law.self_clearance,
    )
    if not around.objection(around.path(u)):
        return ""
    return (
        f"{NO_WAY_TO_STOP}: clearance {1e3 * clearances.minimum():.1f} mm,"
        " and the braking ramp comes nearer"
    )
