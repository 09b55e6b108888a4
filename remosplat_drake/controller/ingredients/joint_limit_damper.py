"""Slow down before a joint limit."""

import dataclasses as dc
import math
from collections.abc import Iterator
from typing import Annotated

import numpy as np
from annotated_types import Interval

from remosplat_drake.base.ranges import Config
from remosplat_drake.controller.reactive_program import ReactiveProgram, Tick


@dc.dataclass
class JointLimitDamperConfig(Config):
    """Where the damping starts and where motion towards the limit ends."""

    # Largest approach speed at the edge of the influence [rad/s].
    gain: Annotated[float, Interval(gt=0, le=100)] = 1.0
    # Distance to the limit within which the damper acts [deg].
    influence: Annotated[float, Interval(gt=0, le=180)] = 50.0
    # Distance to the limit that is kept [deg].
    stop: Annotated[float, Interval(ge=0, le=90)] = 10.0

    def check(self) -> Iterator[tuple[str, str]]:
        """See `Config`."""
        if not self.influence > self.stop:
            yield (
                "influence",
                f"must exceed the stopping distance {self.stop},"
                f" got {self.influence}",
            )


class JointLimitDamper:
    """+-u_j <= gain (rho_j - stop) / (influence - stop), rho to the limit.

    The velocity damper of Faverjon and Tournassoud as the paper's QP uses
    it for joint limits.
    """

    def __init__(self, config: JointLimitDamperConfig):
        self._config = config

    def AddToProgram(self, program: ReactiveProgram, tick: Tick) -> None:
        """Adds a row for each joint near its upper or lower limit."""
        robot, config = tick.robot, self._config
        arm = slice(robot.n_q - (robot.n_u - robot.n_base), robot.n_q)
        q = tick.state.q[arm]
        rho = np.concatenate(
            [robot.position_upper[arm] - q, q - robot.position_lower[arm]]
        )
        influence = math.radians(config.influence)
        stop = math.radians(config.stop)
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
        program.add_rows("joint limit", A, b, lambda i: names[near[i] % n_arm])
