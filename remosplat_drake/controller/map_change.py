"""Checks whether a moving robot may begin to use a new map or base pose.

Each command was verified in the map that was in use when the command was
computed. While the command is executed, a new map may replace this map if the
rest of the command and its braking ramp are allowed in the new map, too. So the
next tick starts with a braking ramp that is verified in the new map.
"""

import numpy as np

from remosplat_drake.controller.tick.reactive_law import ReactiveLaw
from remosplat_drake.controller.verification.verify import Surroundings
from remosplat_drake.robot.payload import Payload
from remosplat_drake.signals.distance_field import DistanceField

NO_WAY_TO_STOP = "the new map leaves too little space to stop"


def objection(
    law: ReactiveLaw,
    field: DistanceField,
    q: np.ndarray,
    u: np.ndarray,
    payload: Payload | None = None,
) -> str:
    """Returns why a map must not be used while a command is executed.

    A robot at rest may always use a new map, since it does not move, and the
    supervisor checks its clearance.

    Args:
        law: The control law that verifies commands.
        field: The map.
        q: Configuration in the map, shape (n_q,) [rad, m].
        u: The command that is being executed, shape (n_u,) [rad/s, m/s]. The
            check assumes that it is executed for a full tick from now on.
        payload: The carried object; None if the robot carries nothing.

    Returns:
        The reason, for display; empty if the map may be used.
    """
    if not (law.verify and u.any()):
        return ""
    law = law.holding(payload)
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
