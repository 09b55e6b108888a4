"""Computes the greatest speeds that limits and clearances permit along a path.

The speed at a point of the path is the greatest speed from which the robot can
keep, up to the path's end, its limits of velocity, acceleration and torque, and
the law of the collision damper. The speed depends only on the point, and not on
time. So a robot that is late or was pushed continues from its present place.
"""

import dataclasses as dc

import numpy as np

from remosplat_drake.controller.ingredients import CollisionDamperConfig
from remosplat_drake.controller.ingredients.collision_damper import (
    approach_speed,
)
from remosplat_drake.controller.planning.free_space import FreeSpace
from remosplat_drake.controller.planning.kernels.node_speeds import (
    node_speeds,
    path_nodes,
)
from remosplat_drake.controller.program.path import Path


@dc.dataclass(frozen=True)
class TimingLimits:
    """Bounds of speeds along paths, in addition to the robot's limits.

    Attributes:
        damper: Settings of the collision damper.
        approach_scale: Factor of the damper's gain on paths.
        dt: The control period [s].
    """

    damper: CollisionDamperConfig = dc.field(
        default_factory=CollisionDamperConfig
    )
    approach_scale: float = 1.0
    dt: float = 0.02


def timed_path(
    space: FreeSpace, corners: np.ndarray, limits: TimingLimits
) -> Path:
    """Finds the greatest speeds along a path.

    Args:
        space: The free space.
        corners: Corners of a free path, shape (k, n_q) [rad, m].
        limits: Bounds of speeds in addition to the robot's limits.

    Returns:
        The path through the corners and through points between them, with
        speeds. If there is only one corner, the path has no speeds.
    """
    dynamics = space.robot.dynamics
    q, s = path_nodes(np.array(corners, float))
    if len(q) < 2:
        return Path(q, s)
    scale, stopping = limits.approach_scale, space.stopping
    slope = approach_speed(limits.damper, scale, stopping, 1.0)
    law = slope, stopping, limits.dt
    with space.calls() as line:
        v, a = node_speeds(
            *(space.arrays, line, dynamics.masses, dynamics.limit),
            *((q, s), law),
        )
    return Path(q, s, v, a)
