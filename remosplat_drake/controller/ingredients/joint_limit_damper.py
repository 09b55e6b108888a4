"""Joint limit damper: limits the approach to joint limits."""

import dataclasses as dc
import math
from collections.abc import Iterator
from typing import Annotated, NamedTuple

import numpy as np
from annotated_types import Interval

from remosplat_drake.base.kernels import kernel
from remosplat_drake.base.kernels.returns import NOTHING
from remosplat_drake.base.ranges import Config
from remosplat_drake.controller.program.compiled_ingredient import (
    CompiledIngredient,
)
from remosplat_drake.controller.program.joint_margins import (
    INFLUENCE_SHARE,
    STOP_SHARE,
    joint_margins,
)
from remosplat_drake.controller.program.kernels.tick_arrays import (
    given_or,
    new_row,
)
from remosplat_drake.robot.robot_model import RobotModel
from remosplat_drake.scene.mover import Movers
from remosplat_drake.signals.binding import JOINT_LIMIT


@dc.dataclass
class JointLimitDamperConfig(Config):
    """Settings of the damper that limits the approach to joint limits.

    The distances of revolute joints are angles, and those of prismatic joints
    are lengths. For joints with a short range, influence distances are reduced
    to a third of the range, and stopping distances to a tenth of the range.
    """

    # Largest speed of approach of a revolute joint at the influence distance
    # [rad/s].
    gain: Annotated[float, Interval(gt=0, le=100)] = 5.0
    # Influence distance: distance of a revolute joint from its limit below
    # which the damper acts [deg].
    influence: Annotated[float, Interval(gt=0, le=180)] = 50.0
    # Stopping distance, which a revolute joint keeps from its limits [deg].
    stop: Annotated[float, Interval(ge=0, le=90)] = 10.0
    # Largest speed of approach of a prismatic joint at the influence distance
    # [m/s].
    slide_gain: Annotated[float, Interval(gt=0, le=10)] = 1.0
    # Influence distance: distance of a prismatic joint from its limit below
    # which the damper acts [m].
    slide_influence: Annotated[float, Interval(gt=0, le=5)] = 0.15
    # Stopping distance, which a prismatic joint keeps from its limits [m].
    slide_stop: Annotated[float, Interval(ge=0, le=1)] = 0.01

    def check(self) -> Iterator[tuple[str, str]]:
        """Checks that the influence distances exceed the stopping distances.

        Yields:
            The name of a field that is invalid, and a description of the
            problem.
        """
        for influence, stop in (
            ("influence", "stop"),
            ("slide_influence", "slide_stop"),
        ):
            if not getattr(self, influence) > getattr(self, stop):
                yield (
                    influence,
                    f"must exceed the stopping distance {getattr(self, stop)},"
                    f" got {getattr(self, influence)}",
                )

    def influence_of(self, robot: RobotModel) -> np.ndarray:
        """Returns the influence distance of each arm joint, (n_arm,) [rad, m].

        Args:
            robot: The robot, for the kinds and ranges of its joints.
        """
        hinge = math.radians(self.influence)
        return joint_margins(
            robot, hinge, self.slide_influence, INFLUENCE_SHARE
        )


class JointLimitDamper(CompiledIngredient):
    """A velocity damper near the limits of the arm's joints.

    `add_joint_limit_damper` computes its rows.

    Args:
        config: Gains and distances of the damper.
    """

    term = JOINT_LIMIT

    def __init__(self, config: JointLimitDamperConfig):
        self._config = config

    def settings(self, robot: RobotModel) -> "JointLimitSettings":
        """Makes the input of the kernel; see `CompiledIngredient`."""
        config, turns = self._config, robot.arm_turns
        return JointLimitSettings(
            turns,
            np.where(turns, config.gain, config.slide_gain),
            config.influence_of(robot),
            math.radians(config.stop),
            config.slide_stop,
            joint_margins(robot, math.inf, math.inf, STOP_SHARE),
        )

    def about(
        self, robot: RobotModel, movers: Movers | None, number: int
    ) -> str:
        """Returns the name of a joint of the arm; see `CompiledIngredient`."""
        return robot.description.arm.joints[number]


class JointLimitSettings(NamedTuple):
    """Settings of a `JointLimitDamper` for kernels."""

    turns: np.ndarray
    gain: np.ndarray
    influence: np.ndarray
    stop: float
    slide_stop: float
    most_stop: np.ndarray


@kernel(returns=NOTHING)
def add_joint_limit_damper(own, k, tick, program):
    """Adds a velocity damper near the limits of the arm's joints.

    For each joint j of the arm, and each limit whose distance rho_j is less
    than `influence`,

        u_j <= gain (rho_j - stop) / (influence - stop)

    for the upper limit, and the same with -u_j for the lower limit (Faverjon
    and Tournassoud 1987, as in the paper). For a revolute joint, the gain is in
    rad/s, and distances are in rad. For a prismatic joint, they are in m/s and
    m. Guidance may set `stop`, which is limited to a fraction of the joint's
    range.

    See `CompiledIngredient` for the arguments.
    """
    robot, q = tick.robot, tick.state.q
    n_arm = len(own.turns)
    hinge = given_or(tick.guidance.joint_stop, own.stop)
    slide = given_or(tick.guidance.slide_stop, own.slide_stop)
    for sign in (1.0, -1.0):
        for joint in range(n_arm):
            i = len(q) - n_arm + joint
            rho = robot.position_upper[i] - q[i]
            if sign < 0.0:
                rho = q[i] - robot.position_lower[i]
            influence = own.influence[joint]
            if not rho < influence:
                continue
            stop = min(
                hinge if own.turns[joint] else slide, own.most_stop[joint]
            )
            b = own.gain[joint] / (influence - stop) * (rho - stop)
            row = new_row(program, k, b, joint)
            program.A[row, robot.n_base + joint] = sign
