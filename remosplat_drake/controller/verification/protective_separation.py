"""Computes the protective separation distance between spheres and movers.

Speed and separation monitoring (ISO/TS 15066, now part of ISO 10218-2) requires
the distance

    S_p = S_h + S_r + S_s + C + Z_d + Z_r

between a person and a robot. S_h, S_r and S_s are the distances that the person
and the robot move until the robot is at rest, C is an additional distance, and
Z_d and Z_r are the errors of their positions. Verification is more precise than
this sum, since it predicts positions over time. The sum is reported because it
is the standard measure for such robots. No conformity is claimed: the cameras,
computers and software are not safety-rated.
"""

import dataclasses as dc
import math
from collections.abc import Sequence

import numpy as np

from remosplat_drake.controller.verification.kernels.least_margin import (
    least_margin,
)
from remosplat_drake.robot.braking import braking_steps
from remosplat_drake.robot.robot_state import RobotState
from remosplat_drake.scene.kernels.mover_reach import near_movers
from remosplat_drake.scene.mover import Movers
from remosplat_drake.signals.separation import Separation


@dc.dataclass(frozen=True)
class Monitoring:
    """The required separation, and the robot's stopping times.

    Attributes:
        separation: The additional distance C [m].
        reaction: Time until the command acts, plus the time for which the
            command is held [s].
        braking: Time from the end of `reaction` until the robot is at rest [s].
        braking_way: Time in which the robot would move the braking distance if
            the command were held [s].
    """

    separation: float
    reaction: float
    braking: float
    braking_way: float

    @staticmethod
    def make(
        u: np.ndarray,
        acceleration_limit: np.ndarray,
        dt: float,
        separation: float,
        delay: float = 0.0,
    ) -> "Monitoring":
        """Computes the times of a command that is held for a tick.

        After the tick, a ramp scales the command down to zero in n equal steps,
        one in each tick. The ramp takes n - 1 ticks. During the ramp, the robot
        moves as far as the full command would move it in half the time of the
        ramp.

        Args:
            u: The command, shape (n_u,) [rad/s, m/s].
            acceleration_limit: Bounds of |du/dt| of the ramp, shape (n_u,).
            dt: Control period [s].
            separation: The additional distance C [m].
            delay: Time until the command acts [s].
        """
        steps = math.ceil(braking_steps(u, acceleration_limit, dt))
        ramp = max(steps - 1, 0) * dt
        return Monitoring(separation, dt + delay, ramp, 0.5 * ramp)


@dc.dataclass(frozen=True, eq=False)
class ProtectiveSeparation:
    """S_p and its parts for m pairs of a sphere and a mover.

    Attributes:
        sphere: Index of the sphere, shape (m,).
        mover: Index of the mover, shape (m,).
        distance: Distance between the surfaces of sphere and mover, with the
            mover predicted to the present time, shape (m,) [m].
        mover_way: S_h, the largest distance by which the mover approaches until
            the robot rests, shape (m,) [m].
        reaction_way: S_r, the distance by which the sphere approaches before it
            brakes, shape (m,) [m].
        braking_way: S_s, the distance by which the sphere approaches while it
            brakes, shape (m,) [m].
        separation: C, the additional distance [m].
        mover_error: Z_d, the bound of the mover's position error when the robot
            has come to rest, shape (m,) [m].
        robot_error: Z_r, the bound of the error of the sphere's position, shape
            (m,) [m].
    """

    sphere: np.ndarray
    mover: np.ndarray
    distance: np.ndarray
    mover_way: np.ndarray
    reaction_way: np.ndarray
    braking_way: np.ndarray
    separation: float
    mover_error: np.ndarray
    robot_error: np.ndarray

    @property
    def needed(self) -> np.ndarray:
        """The protective separation distance S_p, shape (m,) [m]."""
        return (
            self.mover_way
            + self.reaction_way
            + self.braking_way
            + self.separation
            + self.mover_error
            + self.robot_error
        )

    @property
    def margin(self) -> np.ndarray:
        """Distance minus S_p of each pair, shape (m,) [m]."""
        return self.distance - self.needed

    def least(self, links: Sequence[str], movers: Movers) -> Separation | None:
        """Returns the pair with the least margin; None without movers.

        Args:
            links: Names of the spheres' links.
            movers: The movers.
        """
        if not len(self.sphere):
            return None
        i = int(self.margin.argmin())
        return Separation(
            links[int(self.sphere[i])],
            movers.movers[int(self.mover[i])].name,
            float(self.distance[i]),
            float(self.needed[i]),
        )


def least_separation(
    links: Sequence[str],
    state: RobotState,
    movers: Movers,
    time: float,
    u: np.ndarray,
    monitoring: Monitoring,
    tube: np.ndarray,
) -> Separation | None:
    """Returns the pair with the least margin; None without movers.

    The margin is the distance minus S_p. The result equals that of
    `ProtectiveSeparation.least`, but this function is compiled, since every
    tick calls it. The first argument is the link of each sphere; all other
    arguments are those of `protective_separation`.
    """
    kept = monitoring
    sphere, mover, distance, needed = least_margin(
        state.robot,
        state.arrays,
        movers.at(time),
        np.array(u, float),
        # The numbers are converted to floats, since Numba would compile the
        # kernel again for integers.
        (
            float(kept.separation),
            float(kept.reaction),
            float(kept.braking),
            float(kept.braking_way),
        ),
        tube,
    )
    if sphere < 0:
        return None
    name = movers.movers[mover].name
    return Separation(links[int(sphere)], name, distance, needed)


def protective_separation(
    state: RobotState,
    movers: Movers,
    time: float,
    u: np.ndarray,
    monitoring: Monitoring,
    tube: np.ndarray,
) -> ProtectiveSeparation:
    """Computes S_p for each pair of a sphere and a mover.

    Let c be the present speed at which a mover approaches, and b a bound of the
    acceleration of its points relative to its prediction. The robot rests after
    the time t from now, which is the time tau after the mover's stamp. Until
    then, the mover approaches by at most

        S_h = min(max(c, 0) t + b tau^2 / 2, V tau + v (tau - t))

    where v is the mover's present speed, and V its speed limit. Z_d is e_p +
    e_v tau, where e_p and e_v are the errors of the mover's position and
    velocity. The sphere approaches at the speed max(n' Jv_WS u, 0).

    Args:
        state: Kinematics at the present configuration.
        movers: The movers.
        time: The present time [s].
        u: The command, shape (n_u,) [rad/s, m/s].
        monitoring: The required separation, and the robot's stopping times.
        tube: Bound Z_r of the position error of each sphere, shape (n,) [m].
    """
    spheres, seen = state.spheres, movers.at(time)
    sphere, mover, distance, direction_W, closing = near_movers(
        seen,
        np.array(spheres.p_WS, float),
        np.array(spheres.radius, float),
        np.inf,
        0.0,
    )
    far = np.linalg.norm(seen.half_extents, axis=1)
    turn = np.linalg.norm(seen.w_WM, axis=1)
    speed = np.linalg.norm(seen.v_WM, axis=1) + turn * far
    most_speed, most_push, e_v, e_p = seen.bounds.T
    push, age = most_push + turn**2 * far, seen.age
    # The distance excludes the mover's uncertainty, which is the separate term
    # Z_d.
    grown = np.minimum(
        (e_v + 0.5 * push * age) * age, (most_speed + speed) * age
    )
    now = monitoring.reaction + monitoring.braking
    since = now + age
    soon = np.maximum(closing, 0.0) * now + 0.5 * push[mover] * since**2
    late = most_speed * since + speed * age
    approach = np.einsum("mi,mi->m", direction_W, (state.Jv_WS @ u)[sphere])
    approach = np.maximum(approach, 0.0)
    return ProtectiveSeparation(
        sphere,
        mover,
        distance + (grown + e_p)[mover],
        np.minimum(soon, late[mover]),
        approach * monitoring.reaction,
        approach * monitoring.braking_way,
        monitoring.separation,
        (e_p + e_v * since)[mover],
        tube[sphere],
    )
