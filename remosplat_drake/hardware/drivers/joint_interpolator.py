"""`JointInterpolator`: smooths commands at 100 Hz to joint rates at 1 kHz.

Commands are piecewise constant. If libfranka's rate limiter alone smoothed
them, the robot would not abort, but its jerk would be near the limit. So Ruckig
plans from the present rates and accelerations to each new command, within the
bounds on acceleration and jerk in velocity control.
"""

from collections.abc import Sequence

from remosplat_drake.base.errors import MissingExtraError
from remosplat_drake.hardware.drivers.panda_limits import LIMITER, TICK

SMOOTHING = 0.015
"""Least duration of a plan, the motion from the present rates to those of a new
command [s]. It is one and a half periods of 100 Hz, so that each plan is
replaced before its acceleration ends. The motion lags by the same time. A
longer duration would give a smoother motion with more lag."""

_SHARE = 0.99
"""Plans use this fraction of the bound on jerk, so that rounding errors do not
violate the bound.
"""


class JointInterpolator:
    """Joint rates that follow commands with bounded jerk.

    The joints are synchronised: their rates deviate from the straight line
    between two commands only as far as the initial accelerations require.

    Attributes:
        velocity: Latest joint rates, seven [rad/s].
    """

    def __init__(self):
        """Starts at rest.

        Raises:
            MissingExtraError: Ruckig is not installed.
        """
        try:
            import ruckig
        except ImportError as error:
            raise MissingExtraError("the Panda driver", "panda") from error
        joints = len(LIMITER.jerk)
        self._plan = ruckig.Ruckig(joints, TICK)
        self._output = ruckig.OutputParameter(joints)
        self._input = ruckig.InputParameter(joints)
        self._input.control_interface = ruckig.ControlInterface.Velocity
        self._input.synchronization = ruckig.Synchronization.Phase
        self._input.max_acceleration = LIMITER.acceleration.tolist()
        self._input.max_jerk = (_SHARE * LIMITER.jerk).tolist()
        self._input.current_position = [0.0] * joints
        self.resume([0.0] * joints, [0.0] * joints)

    def resume(
        self, velocity: Sequence[float], acceleration: Sequence[float]
    ) -> None:
        """Continues from a given motion of the joints.

        Args:
            velocity: Joint rates, seven [rad/s].
            acceleration: Joint accelerations, seven [rad/s^2].
        """
        self.velocity = list(velocity)
        self._input.current_velocity = self.velocity
        self._input.current_acceleration = list(acceleration)

    def advance(
        self, target: Sequence[float], smoothing: float | None = SMOOTHING
    ) -> list[float]:
        """Returns the joint rates one tick later.

        Args:
            target: Commanded joint rates, seven, finite [rad/s].
            smoothing: Least duration of a plan to a new target [s]; None for
                the shortest that the bounds allow.

        Raises:
            ValueError: Ruckig finds no plan.
        """
        self._input.target_velocity = target
        self._input.minimum_duration = smoothing
        result = self._plan.update(self._input, self._output)
        if result.value < 0:
            raise ValueError(f"ruckig: {result.name}")
        self.velocity = self._output.new_velocity
        self._output.pass_to_input(self._input)
        return self.velocity
