"""`Movers`: moving objects, with pose, velocity and bounds on their motion.

A mover is a moving obstacle: a person is a set of capsules, a door is a box.
Its future position is unknown, but is bounded by its present velocity and its
limits of speed and acceleration; see `kernels/mover_reach.py`.
"""

import dataclasses as dc
import math
from collections.abc import Iterator, Sequence
from functools import cached_property

import numpy as np
from pydrake.common.eigen_geometry import AngleAxis
from pydrake.math import RigidTransform, RotationMatrix

from remosplat_drake.base.errors import FieldError
from remosplat_drake.base.kernels.packed import Packed
from remosplat_drake.scene.kernels.mover_reach import MoverArrays
from remosplat_drake.scene.mover_camera import MoverCamera

FORESIGHT = 2.0
"""Rollouts assume that movers keep their twist for this time, and then rest
[s]."""

MOST = 200
"""There are at most this many movers; each mover adds some microseconds to a
tick."""


@dc.dataclass(frozen=True, eq=False)
class Mover:
    """A rounded box that moves: a sphere, a capsule, or a box.

    The core of a mover is a box around the origin of the mover's frame M; sides
    of the box may have length zero. The mover is the set of points within
    `radius` of the core. A deep copy is the object itself.

    Attributes:
        name: Display name of the mover, "left arm" for example.
        X_WM: Pose of the mover's frame M in W, at the stamp of its `Movers`.
        half_extents: Half side lengths of the core along M's axes, (3,) [m].
        radius: Radius around the core [m].
        v_WM: Velocity of M's origin in W, shape (3,) [m/s].
        w_WM: Angular velocity of M in W, shape (3,) [rad/s].
        max_speed: Upper bound on the speed of all points of the core, at any
            time [m/s].
        max_acceleration: Upper bound on the acceleration of all points of the
            core, at any time [m/s^2].
        velocity_error: Bound on the velocity error of points of the core [m/s].
        position_error: Bound on the position error of points of the core [m].

    Raises:
        FieldError: A value is not finite, or negative, or has another shape.
    """

    name: str
    X_WM: RigidTransform
    half_extents: np.ndarray
    radius: float
    v_WM: np.ndarray = dc.field(default_factory=lambda: np.zeros(3))
    w_WM: np.ndarray = dc.field(default_factory=lambda: np.zeros(3))
    max_speed: float = 2.0
    max_acceleration: float = 5.0
    velocity_error: float = 0.0
    position_error: float = 0.0

    def __post_init__(self):
        for field in ("half_extents", "v_WM", "w_WM"):
            value = np.array(getattr(self, field), float)
            if value.shape != (3,) or not np.isfinite(value).all():
                self._refuse(field, "three finite numbers")
            value.flags.writeable = False
            object.__setattr__(self, field, value)
        if (self.half_extents < 0.0).any():
            self._refuse("half_extents", "at least 0")
        for field in ("radius", *_BOUNDS):
            value = float(getattr(self, field))
            if not 0.0 <= value < math.inf:
                self._refuse(field, "finite and at least 0")
            object.__setattr__(self, field, value)
        if not np.isfinite(self.X_WM.GetAsMatrix4()).all():
            self._refuse("X_WM", "finite")

    def _refuse(self, field: str, wanted: str):
        got = getattr(self, field)
        where = f"mover {self.name!r}"
        raise FieldError(where, field, f"must be {wanted}, got {got}")

    def __deepcopy__(self, memo) -> "Mover":
        return self

    @property
    def speed(self) -> float:
        """Bound on the present speed of all points of the core [m/s]."""
        far = np.linalg.norm(self.half_extents)
        turning = np.linalg.norm(self.w_WM) * far
        return float(np.linalg.norm(self.v_WM) + turning)

    def after(self, time: float) -> RigidTransform:
        """Predicts the mover's pose in W for a constant twist.

        Args:
            time: Time since the stamp of the mover's pose [s].
        """
        turn = float(np.linalg.norm(self.w_WM))
        R_WM = self.X_WM.rotation()
        if turn * time:
            turned = AngleAxis(turn * time, self.w_WM / turn)
            R_WM = RotationMatrix(turned) @ R_WM
        p_WM = self.X_WM.translation() + self.v_WM * time
        return RigidTransform(R_WM, p_WM)

    @staticmethod
    def sphere(name: str, center, radius: float, **rest) -> "Mover":
        """Makes a mover that is a sphere.

        Args:
            name: Display name of the mover.
            center: Centre of the sphere in W, shape (3,) [m].
            radius: Radius of the mover [m].
            rest: The other attributes of a `Mover`: velocities and bounds.
        """
        X_WM = RigidTransform(np.array(center, float))
        return Mover(name, X_WM, np.zeros(3), radius, **rest)

    @staticmethod
    def capsule(
        name: str,
        X_WM: RigidTransform,
        half_length: float,
        radius: float,
        **rest,
    ) -> "Mover":
        """Makes a mover that is a capsule along M's z axis.

        Args:
            name: Display name of the mover.
            X_WM: Pose of its frame M, at its centre, in W.
            half_length: Half the length of its axis, without its caps [m].
            radius: Radius of the mover [m].
            rest: The other attributes of a `Mover`: velocities and bounds.
        """
        return Mover(name, X_WM, np.array([0, 0, half_length]), radius, **rest)

    @staticmethod
    def box(name: str, X_WM: RigidTransform, half_extents, **rest) -> "Mover":
        """Makes a mover that is a box.

        Args:
            name: Display name of the mover.
            X_WM: Pose of its frame M, at its centre, in W.
            half_extents: Half side lengths along M's axes, shape (3,) [m].
            rest: The other attributes of a `Mover`: velocities and bounds.
        """
        return Mover(name, X_WM, np.array(half_extents, float), 0.0, **rest)


_BOUNDS = ("max_speed", "max_acceleration", "velocity_error", "position_error")


@dc.dataclass(frozen=True, eq=False)
class Movers:
    """All known movers; a deep copy is the object itself.

    Attributes:
        stamp: Time of their poses [s].
        movers: The movers.
        cameras: The cameras that detected the movers, with the space that they
            watch. Empty if another source provides the movers; that source then
            covers all space.
        problem: Reason why there is no newer information; empty if there is no
            problem.

    Raises:
        FieldError: The stamp is not finite, or there are more than `MOST`.
    """

    stamp: float
    movers: Sequence[Mover] = ()
    cameras: Sequence[MoverCamera] = ()
    problem: str = ""

    def __post_init__(self):
        if not math.isfinite(self.stamp):
            problem = f"must be finite, got {self.stamp}"
            raise FieldError("movers", "stamp", problem)
        if len(self.movers) > MOST:
            problem = f"must be at most {MOST}, got {len(self.movers)}"
            raise FieldError("movers", "number", problem)
        object.__setattr__(self, "movers", tuple(self.movers))
        object.__setattr__(self, "cameras", tuple(self.cameras))

    def __deepcopy__(self, memo) -> "Movers":
        return self

    def __len__(self) -> int:
        return len(self.movers)

    def __iter__(self) -> Iterator[Mover]:
        return iter(self.movers)

    def at(self, time: float) -> MoverArrays:
        """Returns the movers as arrays for kernels, with their age at a time.

        Args:
            time: The time [s]; see `age`.
        """
        return self.arrays.values._replace(age=self.age(time))

    def age(self, time: float) -> float:
        """Returns the age of the movers' state at a time [s].

        Args:
            time: The time [s]. If the stamp is later than this, the clocks
                disagree; the difference then also counts as age.
        """
        return abs(float(time) - self.stamp)

    def predicted(self, time: float) -> "Movers":
        """Predicts the movers at another time, with constant twists.

        Args:
            time: The time [s].
        """
        ahead = time - self.stamp
        if ahead == 0.0:
            return self
        moved = [dc.replace(m, X_WM=m.after(ahead)) for m in self.movers]
        return dc.replace(self, stamp=time, movers=moved)

    def moved_on(self, time: float, longest: float) -> "Movers":
        """Predicts the movers' measured state at a later time.

        The movers keep their twists for `longest`, and then rest. The stamp
        does not change, so that age and uncertainty at a given time do not
        change, either.

        Args:
            time: Time from now on [s].
            longest: Time for which they keep their twists [s].
        """
        rests = time > longest
        none = {"v_WM": np.zeros(3), "w_WM": np.zeros(3)} if rests else {}
        moved = [
            dc.replace(m, X_WM=m.after(min(time, longest)), **none)
            for m in self.movers
        ]
        return dc.replace(self, movers=moved)

    @cached_property
    def arrays(self) -> Packed[MoverArrays]:
        """The movers as arrays for kernels, at their stamp."""
        return Packed(_arrays(self.movers))


def _arrays(movers: Sequence[Mover]) -> MoverArrays:
    k = len(movers)

    def rows(values: list, *shape: int) -> np.ndarray:
        return np.array(values, float, order="C").reshape(k, *shape)

    return MoverArrays(
        rows([m.half_extents for m in movers], 3),
        rows([m.radius for m in movers]),
        rows([m.X_WM.rotation().matrix() for m in movers], 3, 3),
        rows([m.X_WM.translation() for m in movers], 3),
        rows([m.v_WM for m in movers], 3),
        rows([m.w_WM for m in movers], 3),
        rows([[getattr(m, bound) for bound in _BOUNDS] for m in movers], 4),
        0.0,
    )


STILL = Movers(0.0)
"""The value for a scene without movers."""
