"""Reads the joint positions and rates of an arm from ROS messages."""

import math
from collections.abc import Sequence

import numpy as np

from remosplat_drake.hardware.drivers.arm_driver import ArmReport
from remosplat_drake.hardware.drivers.ros_conversion import stamp_utime
from remosplat_drake.hardware.wire.packets import BrokenMessage, from_utime

_LONGEST_STEP = 0.5
"""No rate is computed from two positions with more time between them [s]."""


class JointStates:
    """Converts JointState messages of ROS 1 or ROS 2 to reports of an arm."""

    def __init__(self, joints: Sequence[str], cutoff: float | None = None):
        """Starts without a message.

        Args:
            joints: Names of the joints, in the order of the result.
            cutoff: Cutoff frequency of the low-pass filter for differentiated
                positions [Hz]. None uses the messages' velocities.
        """
        self._joints = list(joints)
        self._rates = None if cutoff is None else _Differentiator(cutoff)

    def read(self, message) -> ArmReport | None:
        """Reads a message.

        Args:
            message: A JointState.

        Returns:
            The report. It is None if a joint is absent, since several
            broadcasters may share a topic, or if no rate can be computed yet.

        Raises:
            BrokenMessage: A joint has no position or no velocity, or the
                message has no stamp, without which its age is unknown.
        """
        row = {name: i for i, name in enumerate(message.name)}
        if not set(self._joints) <= set(row):
            return None
        utime = stamp_utime(message.header.stamp)
        if not utime:
            raise BrokenMessage("header.stamp is 0, so that its age is unknown")
        rows, stamp = [row[name] for name in self._joints], from_utime(utime)
        q = self._numbers("position", message, rows)
        if self._rates is None:
            v = self._numbers("velocity", message, rows)
        else:
            v = self._rates.after(q, stamp)
        return None if v is None else ArmReport(q, v, stamp, utime=utime)

    def _numbers(self, field: str, message, rows: Sequence[int]) -> np.ndarray:
        """Reads a field of all joints; NaN for absent numbers."""
        values = np.array(getattr(message, field), float)
        if len(values) != len(message.name):
            values = np.full(len(message.name), np.nan)
        values = values[rows]
        absent = np.flatnonzero(~np.isfinite(values))
        if len(absent):
            names = ", ".join(self._joints[int(i)] for i in absent)
            otherwise = ""
            if field == "velocity":
                otherwise = ", or the driver to `differentiate`"
            raise BrokenMessage(
                f"no {field} of {names}: the hardware interface of the arm has"
                f" to export the state interface `{field}`{otherwise}"
            )
        return values


class _Differentiator:
    """Computes rates from positions, with a first-order low-pass filter."""

    def __init__(self, cutoff: float):
        self._cutoff = cutoff
        self._q: np.ndarray | None = None
        self._v: np.ndarray | None = None
        self._stamp = -math.inf

    def after(self, q: np.ndarray, stamp: float) -> np.ndarray | None:
        """Returns the rates after a position [rad/s]; None at the first one.

        Args:
            q: The position, shape (n,) [rad].
            stamp: Time at which the position was measured [s].
        """
        step, before = stamp - self._stamp, self._q
        if step == 0:
            return self._v
        self._q, self._stamp = q, stamp
        if before is None or not 0 < step <= _LONGEST_STEP:
            self._v = None
            return None
        rates = (q - before) / step
        share = -math.expm1(-2 * math.pi * self._cutoff * step)
        last = rates if self._v is None else self._v
        self._v = last + share * (rates - last)
        return self._v
