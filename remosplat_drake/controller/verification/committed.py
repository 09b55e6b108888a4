"""What verification must know of a robot that does not obey at once."""

import dataclasses as dc

import numpy as np

from remosplat_drake.controller.verification.verify import Surroundings
from remosplat_drake.signals.motion import Motion


def committed(
    around: Surroundings, motion: Motion, u: np.ndarray, u_previous: np.ndarray
) -> Surroundings:
    """Moves verification to where the next command begins to act.

    The clearances are known where planning starts, which is farther on. A
    sphere that is x away from there has at most x less; where that tells too
    little the map is asked.

    Args:
        around: Robot and map, with state and clearances at `q_planned`.
        motion: What the robot is about to do already.
        u: The wanted command, shape (n_u,) [rad/s, m/s].
        u_previous: The command being executed, shape (n_u,) [rad/s, m/s].
    """
    robot = around.robot
    state = around.state
    if not np.array_equal(motion.q_start, state.q):
        state = robot.state(motion.q_start)
    moved = state.spheres.p_WS - around.state.spheres.p_WS
    clearance = around.clearance - np.linalg.norm(moved, axis=1)
    peak = np.maximum(motion.in_flight, np.abs(u))
    peak = np.maximum(peak, np.abs(u_previous))
    needed = around.stopping + robot.sphere_tube(motion.model.tube, peak)
    near = np.flatnonzero(~(clearance >= needed))
    if len(near):
        spheres = robot.place_spheres(
            motion.q_start[None], np.zeros(len(near), int), near
        )
        reach = float(needed[near].max())
        found = around.field.clearances(spheres, np.nextafter(reach, np.inf))
        clearance[near] = np.minimum(found.per_sphere(len(near)), reach)
    return dc.replace(around, state=state, clearance=clearance, motion=motion)
