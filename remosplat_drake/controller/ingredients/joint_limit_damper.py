"""Slow down before a joint limit."""

import dataclasses as dc
import math
from collections.abc import Iterator
from typing import Annotated

import numpy as np
from annotated_types import Interval

from remosplat_drake.base.ranges import Config
from remosplat_drake.controller.reactive_program import ReactiveProgram, Tick
from remosplat_drake.signals.binding import JOINT_LIMIT


@dc.dataclass
class JointLimitDamperConfig(Config):
    """How close to its limits a joint may come, and how fast."""

    # Largest speed of approach at the influence distance [rad/s].
    gain: Annotated[float, Interval(gt=0, le=100)] = 1.0
    # Influence distance: nearer to a limit than this the damper acts [deg].
    influence: Annotated[float, Interval(gt=0, le=180)] = 50.0
    # Stopping distance, which a joint keeps from its limits [deg].
    stop: Annotated[float, Interval(ge=0, le=90)] = 10.0

    def check(self) -> Iterator[tuple[str, str]]:
        """Checks that the influence distance exceeds the stopping distance.

        Yields:
            The name of a field and what is wrong with it.
        """
        if not self.influence > self.stop:
            yield (
                "influence",
                f"must exceed the stopping distance {self.stop},"
                f" got {self.influence}",
            )


class JointLimitDamper:
    """A velocity damper before the limits of the arm's joints.

    With rho_j the distance of joint j to its upper or lower limit,

        +-u_j <= gain (rho_j - stop) / (influence - stop)

    (Faverjon and Tournassoud 1987, as the paper's program uses it).

    Args:
        config: Gain and distances of the damper.
    """

    def __init__(self, config: JointLimitDamperConfig):
        self._config = config

    def AddToProgram(self, program: ReactiveProgram, tick: Tick) -> None:
        """Adds a row for each joint of the arm near one of its limits.

        Args:
            program: The program of the tick.
            tick: What is known at the tick; the configuration matters here.
        """
        robot, config = tick.robot, self._config
        arm = slice(robot.n_q - (robot.n_u - robot.n_base), robot.n_q)
        q = tick.state.q[arm]
        rho = np.concatenate(
            [robot.position_upper[arm] - q, q - robot.position_lower[arm]]
        )
        influence = math.radians(config.influence)
        stop = tick.guidance.joint_stop
        stop = math.radians(config.stop if stop is None else stop)
        near = np.flatnonzero(rho < influence)
        if not len(near):
            return
        n_arm = len(q)
        A = np.zeros((len(near), robot.n_u))
        A[np.arange(len(near)), robot.n_base + near % n_arm] = np.where(
            near < n_arm, 1.0, -1.0
        )
        b = config.gain * (rho[near] - stop) / (influence - stop)
        names = robot.description.arm.joints
        program.add_rows(JOINT_LIMIT, A, b, lambda i: names[near[i] % n_arm])
