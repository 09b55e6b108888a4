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
    """The constraints of a robot with n spheres and k pairs of its own shapes.

    The pairs of shapes belong to l pairs of links.

    Attributes:
        robot: The robot.
        map: The map, in the form that `map_for_kernels` returns.
        off: The map's `Misplacement`.
        level: Clearance that each sphere keeps from the map, shape (n,) [m].
        balls: Balls that enclose spheres, and the spheres.
        ball_level: Clearance that each ball and sphere keeps, shape (m,) [m].
        ball_order: Order in which balls are checked, shape (g,). Kernels change
            this order, so only one thread at a time may use the `SpaceArrays`.
        samples: Samples of a part of a motion.
        work: Working memory for checks against the map.
        self_pairs: The pairs of the robot's own shapes.
        self_level: Distance that each pair keeps, shape (k,) [m].
        link_level: Largest distance that any pair of shapes of each pair of
            links keeps, shape (l,) [m].
        self_bend: Bounds of the accelerations of points on one link in the
            frame of the other link, for each two entries of the command and
            each pair of links, shape (n_u, n_u, l), padded in the last
            dimension.
        self_work: Working memory for checks of these pairs.
        movers: Standing movers, which are further obstacles, enlarged by the
            distance to keep.
        mover_level: Distance that each sphere keeps from these movers, shape
            (n,) [m].
        lower: Lower bounds of the joints, shape (n_q,) [rad, m].
        upper: Upper bounds of the joints, shape (n_q,) [rad, m].
        backing: Longest distance that the base may drive backwards [m].
    """

    robot: RobotArrays | Packed[RobotArrays]
    map: Any
    off: Misplacement
    level: np.ndarray
    balls: SphereTree | Packed[SphereTree]
    ball_level: np.ndarray
    ball_order: np.ndarray
    samples: MotionSamples | Packed[MotionSamples]
    work: MapWork | Packed[MapWork]
    self_pairs: SelfCollisionArrays | Packed[SelfCollisionArrays]
    self_level: np.ndarray
    link_level: np.ndarray
    self_bend: np.ndarray
    self_work: SelfWork | Packed[SelfWork]
    movers: MoverArrays | Packed[MoverArrays]
    mover_level: np.ndarray
    lower: np.ndarray
    upper: np.ndarray
    backing: float
