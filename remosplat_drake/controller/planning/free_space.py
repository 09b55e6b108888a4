"""`FreeSpace`: which configurations and motions keep their distances."""

import numpy as np

from remosplat_drake.controller.planning.kernels.map_looks import (
    is_off_the_map,
    keeps_off_the_map,
)
from remosplat_drake.controller.planning.kernels.self_looks import (
    keeps_off_itself,
)
from remosplat_drake.controller.planning.obstructions import StandingMovers
from remosplat_drake.controller.planning.steering import (
    held_command,
    waypoints,
)
from remosplat_drake.controller.verification.kernels.between_looks import (
    TOLERANCE,
)
from remosplat_drake.controller.verification.kernels.map_sweep import (
    sweeps_clear,
)
from remosplat_drake.controller.verification.kernels.places import held
from remosplat_drake.controller.verification.map_calls import (
    MapCalls,
    map_for_kernels,
)
from remosplat_drake.controller.verification.self_sweep import SelfClearance
from remosplat_drake.robot.robot_model import RobotModel
from remosplat_drake.signals.distance_field import DistanceField

_LOOK = 0.4
"""How far a sphere moves between two looks of the first round [m]."""

_EDGE = 1e-6
"""Distance by which rooms are told from none [m]."""

_BLINK = 0.01
"""How far two of the robot's own shapes may move between two looks although
they are nearer to what they keep [m]. Verification looks more closely."""

_FAR = 0.25
"""Distance beyond which it does not matter how far the scene is [m]."""


class FreeSpace:
    """The configurations from which nothing is nearer than it may be.

    Each sphere keeps the stopping distance from the scene, or what it has at
    the start where that is less; shapes of two links keep theirs from each
    other; joints keep within bounds. Motions are looked at as verification
    looks at commands: the scene is asked again only where the spheres have
    moved farther than what they had left (the field is 1-Lipschitz), so that
    nothing slips through between two looks but for verification's tolerance.

    Attributes:
        robot: The robot.
        field: The map.
        stopping: Stopping distance [m].
        lower: Lower bounds of the joints, shape (n_q,) [rad, m].
        upper: Upper bounds of the joints, shape (n_q,) [rad, m].
        backing: Longest way that the base may drive backwards [m].
        checks: Number of configurations and motions that were looked at.
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
        standing: StandingMovers | None = None,
    ):
        """Makes the free space of a robot that stands somewhere.

        Args:
            robot: The robot.
            field: The map.
            stopping: Stopping distance [m].
            self_clearance: Distances that the robot keeps from itself; None if
                it keeps none.
            bounds: Lower and upper bounds of q, shape (n_q,) each [rad, m].
            start: Where the robot is, shape (n_q,) [rad, m].
            backing: Longest way that the base may drive backwards [m].
            standing: What stands in the way besides the scene; None for
                nothing.
        """
        self.robot, self.field = robot, field
        self.stopping, self.backing = stopping, backing
        self.lower, self.upper = bounds
        self._own = self_clearance
        self._standing = standing
        self._compiled = field.compiled
        self._known: dict[bytes, np.ndarray] = {}
        self.checks = 0
        self._level = np.full(len(robot.spheres), stopping)
        self._level = np.minimum(stopping, self._clearance(start))
        if standing is not None:
            self._standing = standing.seen_from(robot.spheres_at(start))

    def is_free(self, q: np.ndarray) -> bool:
        """Tells whether a configuration keeps all distances.

        Args:
            q: The configuration, shape (n_q,) [rad, m].
        """
        self.checks += 1
        if (q < self.lower).any() or (q > self.upper).any():
            return False
        if not self._keeps_off(q) or self._is_obstructed(q):
            return False
        own = self._own
        if own is None:
            return True
        return bool((own.distances(q, own.stopping) >= own.stopping).all())

    def rooms(self, q: np.ndarray, far: float = _FAR) -> np.ndarray:
        """Measures what all spheres have above what they keep, in one query.

        Args:
            q: Configurations, shape (k, n_q) [rad, m].
            far: Clearance beyond the stopping distance at which rooms are cut
                off: a small one makes the query cheaper [m].

        Returns:
            The rooms, shape (k, n) [m].
        """
        k, n = len(q), len(self._level)
        spheres = self.robot.place_spheres(
            q, np.repeat(np.arange(k), n), np.tile(np.arange(n), k)
        )
        found = self.field.clearances(spheres, self.stopping + far)
        rooms = np.minimum(found.per_sphere(k * n), self.stopping + far)
        return rooms.reshape(k, n) - self._level

    def is_free_between(self, a: np.ndarray, b: np.ndarray) -> bool:
        """Tells whether the whole motion between two configurations is free.

        Args:
            a: A free configuration to start from, shape (n_q,) [rad, m].
            b: Configuration to end at, shape (n_q,) [rad, m].
        """
        self.checks += 1
        if (b < self.lower).any() or (b > self.upper).any():
            return False
        corners = waypoints(self.robot, a, b, self.backing)
        # Most motions that are not free end in the scene.
        if not self._keeps_off(corners[-1]) or self._is_obstructed(corners[-1]):
            return False
        return all(
            self._keeps(corners[k], corners[k + 1])
            for k in range(len(corners) - 1)
        )

    def _keeps(self, a: np.ndarray, b: np.ndarray) -> bool:
        """Tells whether one straight stretch of a motion is free."""
        robot, own = self.robot, self._own
        u = held_command(robot, a, b)
        travel = float((robot.jacobian_bound @ np.abs(u)).max())
        looks = max(1, round(travel / _LOOK))
        spheres = robot.spheres_at(a)
        motion = a, u, robot.n_base
        if self._standing is not None and not self._standing.is_passed(
            robot, a, u, travel
        ):
            return False
        if own is not None and not keeps_off_itself(
            robot.tree.arrays,
            motion,
            own.arrays,
            np.minimum(own.distances(a, own.stopping), own.stopping),
            _BLINK,
        ):
            return False
        if self._compiled is not None:
            return keeps_off_the_map(
                robot.arrays,
                motion,
                self._level,
                self._compiled,
                looks,
                TOLERANCE,
            )
        times = np.linspace(0.0, 1.0, looks + 1)[1:]
        with MapCalls(robot, self.field) as line:
            return sweeps_clear(
                robot.arrays,
                held(a, u, robot.n_base, times, times),
                (*map_for_kernels(self.field), line),
                spheres.p_WS,
                self._clearance(a),
                self._level,
                np.full(len(self._level), TOLERANCE),
            )

    def _is_obstructed(self, q: np.ndarray) -> bool:
        """Tells whether something that stands there is too near."""
        standing = self._standing
        return standing is not None and standing.obstructs(
            self.robot.spheres_at(q)
        )

    def _keeps_off(self, q: np.ndarray) -> bool:
        """Tells whether all spheres keep their distances from the scene."""
        if self._compiled is not None:
            return is_off_the_map(
                self.robot.arrays, q, self._level, self._compiled
            )
        if q.tobytes() in self._known:
            return bool((self._clearance(q) >= self._level).all())
        # Who asks for no more than that gets a quick answer.
        return bool((self.rooms(q[None], _EDGE) >= 0.0).all())

    def _clearance(self, q: np.ndarray) -> np.ndarray:
        """Measures each sphere's clearance, shape (n,) [m], once for each q."""
        key = q.tobytes()
        known = self._known.get(key)
        if known is None:
            known = self.rooms(q[None])[0] + self._level
            self._known[key] = known
        return known
