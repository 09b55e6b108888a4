"""`FreeSpace`: checks whether configurations and motions keep distances."""

from contextlib import AbstractContextManager, nullcontext
from functools import lru_cache

import numpy as np

from remosplat_drake.base.kernels.packed import Packed
from remosplat_drake.base.kernels.template import Template
from remosplat_drake.controller.planning.kernels.collision_checks import (
    first_reached,
    is_free,
    is_free_between,
)
from remosplat_drake.controller.planning.kernels.map_checks import (
    sphere_margins,
)
from remosplat_drake.controller.planning.kernels.map_work import MapWork
from remosplat_drake.controller.planning.kernels.motion_samples import (
    MotionSamples,
)
from remosplat_drake.controller.planning.kernels.self_work import SelfWork
from remosplat_drake.controller.planning.kernels.space_arrays import SpaceArrays
from remosplat_drake.controller.planning.kernels.start_levels import (
    lower_levels,
)
from remosplat_drake.controller.planning.obstructions import (
    NOTHING_STANDS,
    StandingMovers,
)
from remosplat_drake.controller.verification.kernels.verified import (
    SelfCollisionArrays,
)
from remosplat_drake.controller.verification.map_calls import (
    MapCalls,
    is_pythons,
    map_for_kernels,
)
from remosplat_drake.controller.verification.self_sweep import (
    SelfClearance,
    no_self_collision_arrays,
)
from remosplat_drake.robot.robot_model import RobotModel
from remosplat_drake.signals.distance_field import DistanceField


class FreeSpace:
    """The configurations and motions of a robot that keep all distances.

    In a free configuration, each sphere keeps the stopping distance from the
    scene, the shapes of two links keep a distance from each other, and joints
    are within bounds. If a distance is smaller than required at the start, it
    must not decrease further. Motions are checked like commands in
    verification: between two samples, distances may be smaller by the tolerance
    of verification. Only one thread at a time may use a `FreeSpace`.

    Attributes:
        robot: The robot.
        field: The map.
        stopping: Stopping distance [m].
        lower: Lower bounds of the joints, shape (n_q,) [rad, m].
        upper: Upper bounds of the joints, shape (n_q,) [rad, m].
        backing: Longest distance that the base may drive backwards [m].
        checks: Number of configurations and motions that were checked.
        arrays: The space, packed for kernels.
    """

    def __init__(
        self,
        robot: RobotModel,
        field: DistanceField,
        stopping: float,
        self_clearance: SelfClearance | None,
        bounds: tuple[np.ndarray, np.ndarray],
        start: np.ndarray,
        backing: float = 0.0,
        standing: StandingMovers = NOTHING_STANDS,
    ):
        """Makes the free space of a robot at a start configuration.

        Args:
            robot: The robot.
            field: The map.
            stopping: Stopping distance [m].
            self_clearance: Pairs of the robot's own shapes and their stopping
                distance; None if self-collision is not checked.
            bounds: Lower and upper bounds of q, each of shape (n_q,) [rad, m].
            start: Present configuration, shape (n_q,) [rad, m].
            backing: Longest distance that the base may drive backwards [m].
            standing: Standing movers, which are further obstacles.
        """
        self.robot, self.field = robot, field
        self.stopping, self.backing = stopping, backing
        self.lower, self.upper = bounds
        self.checks = 0
        self._is_pythons = is_pythons(field)
        own, self_bend = _own_shapes(robot, self_clearance)
        apart = 0.0 if self_clearance is None else self_clearance.stopping
        pairs = own.values.pairs
        compiled, off = map_for_kernels(field)
        balls = robot.sphere_tree
        ball_level = np.full(len(balls.radius), float(stopping))
        samples, work, self_work = _memory(robot, own, self_bend.shape[2])
        values = SpaceArrays(
            robot=robot.arrays,
            map=compiled,
            off=off,
            level=ball_level[-len(robot.spheres) :],
            balls=balls,
            ball_level=ball_level,
            # The order is reversed, since the hand collides most often, and its
            # balls are the last.
            ball_order=np.arange(len(balls.first) - 1)[::-1],
            samples=samples.copy(),
            work=work.copy(),
            self_pairs=own,
            self_level=np.full(len(pairs.first), float(apart)),
            link_level=np.zeros(len(pairs.boxes)),
            self_bend=self_bend,
            self_work=self_work.copy(),
            movers=standing.arrays,
            mover_level=standing.levels(robot, start),
            lower=self.lower,
            upper=self.upper,
            backing=float(backing),
        )
        self.arrays = Packed(values)
        with self.calls() as line:
            lower_levels(self.arrays, line, np.array(start[None], float))

    def is_free(self, q: np.ndarray) -> bool:
        """Returns whether a configuration keeps all distances.

        Args:
            q: The configuration, shape (n_q,) [rad, m].
        """
        self.checks += 1
        with self.calls() as line:
            return is_free(self.arrays, line, q)

    def is_free_between(self, a: np.ndarray, b: np.ndarray) -> bool:
        """Returns whether the whole motion between two configurations is free.

        Args:
            a: Configuration at the start, which must be free, shape (n_q,)
                [rad, m].
            b: Configuration at the end, shape (n_q,) [rad, m].
        """
        self.checks += 1
        with self.calls() as line:
            return is_free_between(self.arrays, line, a, b)

    def first_reached(self, q: np.ndarray, goals: np.ndarray) -> int | None:
        """Returns the index of the first goal that a single motion reaches.

        Args:
            q: Configuration at the start, which must be free, shape (n_q,)
                [rad, m].
            goals: Configurations at the end, shape (k, n_q) [rad, m].

        Returns:
            The index; None if no motion is free.
        """
        with self.calls() as line:
            k = first_reached(self.arrays, line, q, goals)
        self.checks += min(k + 1, len(goals))
        return k if k < len(goals) else None

    def margins(self, q: np.ndarray, far: float) -> np.ndarray:
        """Measures the margins: clearances of spheres minus the required ones.

        Args:
            q: Configurations, shape (k, n_q) [rad, m].
            far: Value at which margins are truncated [m]. With a small value,
                the query takes less time.

        Returns:
            The margins, shape (k, n) [m].
        """
        with self.calls() as line:
            return sphere_margins(self.arrays, line, np.array(q, float), far)

    def calls(self) -> AbstractContextManager[int]:
        """Returns a context in which kernels can query maps that need Python.

        The `with` statement returns a number, by which kernels find the map.
        """
        if self._is_pythons:
            return MapCalls(self.robot, self.field)
        return nullcontext(0)


def prepare(robot: RobotModel, self_clearance: SelfClearance | None) -> None:
    """Computes what all free spaces of a robot share, before the first search.

    Args:
        robot: The robot.
        self_clearance: Pairs of the robot's own shapes; None if self-collision
            is not checked.
    """
    own, bend = _own_shapes(robot, self_clearance)
    _memory(robot, own, bend.shape[2])
    _ = robot.chain_arrays


def _own_shapes(
    robot: RobotModel, self_clearance: SelfClearance | None
) -> tuple[Packed[SelfCollisionArrays], np.ndarray]:
    """Returns the pairs of the robot's own shapes, and bounds of their bend."""
    if self_clearance is None:
        none = np.zeros((robot.n_u, robot.n_u, 0))
        return no_self_collision_arrays(robot), none
    return self_clearance.arrays, self_clearance.bend


@lru_cache(maxsize=16)
def _memory(
    robot: RobotModel, own: Packed[SelfCollisionArrays], bends: int
) -> tuple[Template[MotionSamples], Template[MapWork], Template[SelfWork]]:
    """Returns the kernels' working memory, of which each space has a copy."""
    return (
        Template(MotionSamples.make(robot.arrays.values.tree, robot.n_q)),
        Template(MapWork.make(len(robot.sphere_tree.radius), robot.n_u)),
        Template(SelfWork.make(own.values.pairs, bends)),
    )
