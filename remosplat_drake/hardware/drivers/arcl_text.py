"""Reads an Omron base's ARCL messages, line by line.

ARCL is text over TCP: a password, then commands and answers, with news of the
robot in between. Of the Advanced Robotics Command Language Reference Guide
(18448-000) and of OmronAPAC's ROS packages this takes:

    queryMotors     Motors enabled | Motors disabled | EStop pressed |
                    EStop relieved but motors still disabled
    status          ExtendedStatusForHumans: ..., Status: ...,
                    StateOfCharge: 86.0, Location: 36467 13659 93,
                    LocalizationScore: 0.37, Temperature: 40

ARCL has no command for a velocity; it is read beside the driver that drives.
"""

import dataclasses as dc
import math

from remosplat_drake.hardware.drivers.base_stops import FREE, BaseStops

QUERY = "queryMotors"
"""Command that queries whether the motors may turn."""

STATUS = "status"
"""Command that queries the state of charge, among others."""

PROMPT = "enter password"
"""Password prompt of the robot, in lower case."""

WELCOME = "end of commands"
"""How the list of commands ends that follows a good password."""

_MOTORS = {
    "motors enabled": FREE,
    "motors disabled": BaseStops(motors_off=True),
    "estop pressed": BaseStops(emergency=True),
    # Someone has to press the ON button.
    "estop relieved": BaseStops(emergency=True),
}
"""Meaning of the beginnings of lines, in lower case, for the motors."""


@dc.dataclass(frozen=True)
class ArclState:
    """The state according to the lines so far.

    Attributes:
        stops: The base's stops, by the latest line about them.
        heard: Time of that line, by a monotonic clock [s]; -inf before the
            first one.
    """

    stops: BaseStops = FREE
    heard: float = -math.inf

    def stops_at(self, t: float, expiry: float) -> BaseStops:
        """Returns the base's stops, unknown if the latest line is old.

        Args:
            t: Time now, by the same clock [s].
            expiry: Age from which on a line says nothing any more [s].
        """
        is_old = not t - self.heard <= expiry
        return dc.replace(self.stops, is_unknown=is_old)


def with_line(state: ArclState, line: str, t: float) -> ArclState:
    """Returns the state after a line; one that says nothing leaves it.

    Args:
        state: The state before.
        line: The line, without its end.
        t: When it came, by a monotonic clock [s].
    """
    words = line.strip().lower()
    for beginning, stops in _MOTORS.items():
        if words.startswith(beginning):
            stops = dc.replace(stops, battery=state.stops.battery)
            return ArclState(stops, t)
    key, _, value = words.partition(":")
    if key == "stateofcharge":
        stops = dc.replace(state.stops, battery=_share(value))
        return dc.replace(state, stops=stops)
    return state


def _share(percent: str) -> float:
    """A charge in percent as a share; -1 where it is not a number."""
    try:
        charge = 0.01 * float(percent)
    except ValueError:
        return -1.0
    return charge if 0.0 <= charge <= 1.0 else -1.0
