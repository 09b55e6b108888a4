"""`SpaceArrays`: the free space of a robot, packed for kernels."""

from typing import Any, NamedTuple

import numpy as np

from remosplat_drake.base.kernels.packed import Packed
from remosplat_drake.controller.planning.kernels.map_work import MapWork
from remosplat_drake.controller.planning.kernels.motion_samples import (
    MotionSamples,
)
from remosplat_drake.controller.planning.kernels.self_work import SelfWork
from remosplat_drake.controller.verification.kernels.verified import (
    SelfCollisionArrays,
)
from remosplat_drake.robot.robot_arrays import RobotArrays
from remosplat_drake.robot.sphere_tree import SphereTree
from remosplat_drake.scene.kernels.mover_reach import MoverArrays
from remosplat_drake.signals.compiled_map import Misplacement


class SpaceArrays(NamedTuple):
    """The constraints of a robot with n spheres and k pairs of own shapes.

    The pairs are those of l pairs of links.

    Attributes:
        robot: The robot.
        map: The map, as `map_for_kernels` returns it.
        off: The map's `Misplacement`.
        level: Clearance that each sphere keeps from the map, shape (n,) [m].
        balls: Balls around the spheres, and the spheres.
        ball_level: Clearance that each ball and sphere keeps, shape (m,) [m].
        ball_order: Order in which balls are checked, shape (g,). Kernels change
            it, so only one thread at a time may use a space.
        samples: Samples of a part of a motion.
        work: Working memory for checks against the map.
        self_pairs: The pairs of the robot's own shapes.
        self_level: Distance that each pair keeps, shape (k,) [m].
        link_level: For each pair of links, the largest distance that a pair of
            their shapes keeps, shape (l,) [m].
        self_bend: Bounds on the accelerations of points on one link as seen
            from the other, for each two entries of the command and each pair of
            links, shape (n_u, n_u, l), padded in the last dimension.
        self_work: Working memory for checks of these pairs.
        movers: Standing movers as further obstacles, enlarged by the distance
            to keep.
        mover_level: Distance that each sphere keeps from them, shape (n,) [m].
        lower: Lower bounds of the joints, shape (n_q,) [rad, m].
        upper: Upper bounds of the joints, shape (n_q,) [rad, m].
        backing: Longest way that the base may drive backwards [m].
    """

    robot: RobotArrays | Packed[RobotArrays]
    map: Any
    off: Misplacement
    level: np.ndarray
    balls: SphereTree | Packed[SphereTree]
    ball_level: np.ndarray
    ball_order: np.ndarray
    samples: MotionSamples
    work: MapWork
    self_pairs: SelfCollisionArrays | Packed[SelfCollisionArrays]
    self_level: np.ndarray
    link_level: np.ndarray
    self_bend: np.ndarray
    self_work: SelfWork
    movers: MoverArrays | Packed[MoverArrays]
    mover_level: np.ndarray
    lower: np.ndarray
    upper: np.ndarray
    backing: float
