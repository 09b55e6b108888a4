"""`MotionPlanner`: searches a path, and reports why none is found."""

import dataclasses as dc
import math
from collections.abc import Callable
from functools import cached_property
from time import perf_counter

import numpy as np

from remosplat_drake.controller.planning.blending import blended_corners
from remosplat_drake.controller.planning.free_space import FreeSpace, prepare
from remosplat_drake.controller.planning.goal_configurations import (
    GoalConfigurations,
    goal_configurations,
)
from remosplat_drake.controller.planning.obstructions import (
    NOTHING_STANDS,
    StandingMovers,
)
from remosplat_drake.controller.planning.out_of_reach import out_of_reach
from remosplat_drake.controller.planning.plan import (
    CRAMPED,
    CUT_OFF,
    UNREACHED,
    Plan,
)
from remosplat_drake.controller.planning.planning_config import PlanningConfig
from remosplat_drake.controller.planning.roadmap import NO_ROADMAP, Roadmap
from remosplat_drake.controller.planning.search import Search
from remosplat_drake.controller.planning.segments import driven_corners
from remosplat_drake.controller.planning.timing import TimingLimits, timed_path
from remosplat_drake.controller.program.joint_margins import (
    STOP_SHARE,
    joint_margins,
)
from remosplat_drake.controller.program.path import Path
from remosplat_drake.controller.verification.self_sweep import SelfClearance
from remosplat_drake.robot.robot_model import RobotModel
from remosplat_drake.scene.mover import Movers
from remosplat_drake.signals.aim import Aim
from remosplat_drake.signals.distance_field import DistanceField
from remosplat_drake.signals.target import Target

_ROAM = 2.0
"""The base's x and y may leave the bounding box of start and goals by at most
this distance [m]."""


@dc.dataclass(frozen=True, eq=False)
class MotionPlanner:
    """Searches paths of a robot to targets.

    Attributes:
        robot: The robot.
        self_clearance: Pairs of the robot's own shapes and their stopping
            distance; None if self-collision is not checked.
        config: Settings of searches.
        timing: Bounds of speeds along paths.
    """

    robot: RobotModel
    self_clearance: SelfClearance | None
    config: PlanningConfig
    timing: TimingLimits = dc.field(default_factory=TimingLimits)

    def __post_init__(self) -> None:
        """Computes what depends on the robot alone, so that no search does."""
        prepare(self.robot, self.self_clearance)

    def plan(
        self,
        q: np.ndarray,
        aim: Aim | Target | np.ndarray,
        field: DistanceField,
        stopping: float,
        attempt: int = 0,
        interrupted: Callable[[], bool] = lambda: False,
        roadmap: Roadmap = NO_ROADMAP,
        around: Movers | None = None,
        separation: float = 0.0,
    ) -> Plan:
        """Searches a path to a target; equal arguments give equal paths.

        Args:
            q: Present configuration, shape (n_q,) [rad, m].
            aim: The targets of the end effectors, as an `Aim`. A `Target` or a
                pose X_WT of shape (4, 4) is also accepted; it is the target of
                the first end effector.
            field: The map.
            stopping: Distance that all spheres keep from the scene [m].
            attempt: Number of earlier searches. Each search draws other random
                numbers.
            interrupted: Function that returns whether to abort the search.
            roadmap: Corners of earlier paths, which are tried first.
            around: Standing movers; None if there are none.
            separation: Distance that all spheres keep from standing movers [m].
        """
        started = perf_counter()
        space = self.free_space(q, field, stopping, around, separation)
        plan = self._plan(space, q, Aim.of(aim), attempt, interrupted, roadmap)
        return dc.replace(plan, seconds=perf_counter() - started)

    def _plan(
        self,
        space: FreeSpace,
        q: np.ndarray,
        aim: Aim,
        attempt: int,
        interrupted: Callable[[], bool],
        roadmap: Roadmap,
    ) -> Plan:
        unreached = out_of_reach(self.robot, aim, q)
        if unreached:
            return Plan(None, unreached, 0, 0, lack=UNREACHED)
        config = self.config
        start = np.clip(q, space.lower, space.upper)
        goals = goal_configurations(
            space,
            aim,
            start,
            seeds=config.seeds,
            most=config.goals,
            rng=np.random.default_rng(self._seed(attempt)),
        )
        if not len(goals.q):
            why = self._no_goal(goals, space.stopping)
            lack = CRAMPED if goals.reached else UNREACHED
            return Plan(None, why, space.checks, 0, lack=lack)
        search = self.search(space, start, goals.q, attempt, interrupted)
        corners = search.straight_to(goals.q)
        if corners is None:
            corners = roadmap.path_between(space, start, goals.q)
        if corners is None:
            corners = search.path_to(goals.q)
        if corners is None:
            reason = (
                f"no path to {len(goals.q)} goal configurations found in"
                f" {space.checks} checks; more checks may find one: raise"
                " `planning.checks`"
            )
            return Plan(None, reason, space.checks, len(goals.q), lack=CUT_OFF)
        corners = search.shortened(corners)
        driven = np.concatenate([q[None], driven_corners(space, corners)])
        corners, checks = Path.through(driven).q, space.checks
        path = self._timed(space, corners)
        return Plan(path, "", checks, len(goals.q), corners=corners)

    def _timed(self, space: FreeSpace, corners: np.ndarray) -> Path:
        """Rounds off the corners of a path, and computes its speeds."""
        blended = blended_corners(space, corners, self.config.blend)
        return timed_path(space, blended, self.timing)

    def search(
        self,
        space: FreeSpace,
        q: np.ndarray,
        goals: np.ndarray,
        attempt: int = 0,
        interrupted: Callable[[], bool] = lambda: False,
    ) -> Search:
        """Prepares the search of a path to goal configurations.

        Args:
            space: The free space.
            q: Start of the path, shape (n_q,) [rad, m].
            goals: Possible ends of the path, shape (k, n_q) [rad, m].
            attempt: Number of earlier searches. Each search draws other random
                numbers, and may check twice as many motions as the search
                before it.
            interrupted: Function that returns whether to abort the search.
        """
        return Search(
            space,
            q,
            self._box(q, goals),
            self.config.checks << attempt,
            self._seed(attempt),
            interrupted,
        )

    def open_part(
        self, path: Path, q: np.ndarray, field: DistanceField, stopping: float
    ) -> Path:
        """Truncates a path before the next part that a map blocks.

        Args:
            path: The path.
            q: Present configuration, shape (n_q,) [rad, m].
            field: The map.
            stopping: Distance that all spheres keep from the scene [m].

        Returns:
            The path. It is the same object if no part ahead of q is blocked.
        """
        s, _ = path.nearest(q)
        space = self.free_space(q, field, stopping)
        here, start = path.at(s), s
        for k in np.flatnonzero(path.s > s):
            if not space.is_free_between(here, path.q[k]):
                return timed_path(space, path.until(start).q, self.timing)
            here, start = path.q[k], float(path.s[k])
        return path

    def free_space(
        self,
        q: np.ndarray,
        field: DistanceField,
        stopping: float,
        around: Movers | None = None,
        separation: float = 0.0,
    ) -> FreeSpace:
        """Returns the free space of the robot in a configuration.

        Args:
            q: Present configuration, shape (n_q,) [rad, m].
            field: The map.
            stopping: Distance that all spheres keep from the scene [m].
            around: Standing movers; None if there are none.
            separation: Distance that all spheres keep from standing movers [m].
        """
        return FreeSpace(
            self.robot,
            field.for_planning,
            stopping,
            self.self_clearance,
            self._bounds,
            q,
            self.config.backing,
            StandingMovers.make(around, separation)
            if around
            else NOTHING_STANDS,
        )

    def _seed(self, attempt: int) -> int:
        return 1 + self.config.seed + attempt

    @cached_property
    def _bounds(self) -> tuple[np.ndarray, np.ndarray]:
        robot, config = self.robot, self.config
        stop = np.zeros(robot.n_q)
        hinge = math.radians(config.joint_stop)
        margins = joint_margins(robot, hinge, config.slide_stop, STOP_SHARE)
        stop[robot.n_q - len(margins) :] = margins
        return robot.position_lower + stop, robot.position_upper - stop

    def _box(
        self, q: np.ndarray, goals: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray]:
        """Returns finite bounds within which configurations are drawn."""
        lower, upper = (bound.copy() for bound in self._bounds)
        if self.robot.n_base:
            all_q = np.vstack([q, goals])
            lower[:2] = all_q[:, :2].min(axis=0) - _ROAM
            upper[:2] = all_q[:, :2].max(axis=0) + _ROAM
            lower[2] = all_q[:, 2].min() - math.pi
            upper[2] = all_q[:, 2].max() + math.pi
        return lower, upper

    def _no_goal(self, goals: GoalConfigurations, stopping: float) -> str:
        if not goals.reached:
            return (
                "no configuration was found that reaches the target (from"
                f" {goals.seeds} seeds); move or turn the target"
            )
        if not goals.missing:
            return (
                f"none of {goals.reached} configurations that reach the target"
                " is free: in the best one, links of the robot are too near to"
                " each other or to a mover; move or turn the target"
            )
        link = self.robot.spheres.links[goals.tightest]
        part = self.robot.description.called(link)
        return (
            f"none of {goals.reached} configurations that reach the target"
            f" keeps {1e3 * stopping:.3g} mm from the scene: in the best one,"
            f" {part} is {max(1.0, 1e3 * goals.missing):.0f} mm too near;"
            " move or turn the target"
        )
