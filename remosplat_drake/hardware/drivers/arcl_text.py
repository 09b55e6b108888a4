"""Parses the ARCL messages of an Omron base, line by line.

ARCL is a text protocol over TCP. It consists of a password, then commands and
answers, with messages of the robot in between. This module uses the following
parts of the Advanced Robotics Command Language Reference Guide (18448-000) and
of OmronAPAC's ROS packages:

    queryMotors     Motors enabled | Motors disabled | EStop pressed |
                    EStop relieved but motors still disabled
    status          ExtendedStatusForHumans: ..., Status: ...,
                    StateOfCharge: 86.0, Location: 36467 13659 93,
                    LocalizationScore: 0.37, Temperature: 40

ARCL has no command for a velocity, so another driver moves the base.
"""

import dataclasses as dc
import math

from remosplat_drake.hardware.drivers.base_stops import FREE, BaseStops

QUERY = "queryMotors"
"""Command that queries whether the motors may turn."""

STATUS = "status"
"""Command that queries the state of charge and other values."""

PROMPT = "enter password"
"""Password prompt of the robot, in lower case."""

WELCOME = "end of commands"
"""End of the list of commands that the robot sends after a valid password."""

_MOTORS = {
    "motors enabled": FREE,
    "motors disabled": BaseStops(motors_off=True),
    "estop pressed": BaseStops(emergency=True),
    # A person has to press the ON button.
    "estop relieved": BaseStops(emergency=True),
}
"""Beginnings of lines about the motors, in lower case, and their meanings."""


@dc.dataclass(frozen=True)
class ArclState:
    """The base's state according to the lines that have come so far.

    Attributes:
        stops: The base's stops, by the latest line about them.
        heard: Time of that line, by a monotonic clock [s]; -inf before the
            first line.
    """

    stops: BaseStops = FREE
    heard: float = -math.inf

    def stops_at(self, t: float, expiry: float) -> BaseStops:
        """Returns the base's stops, unknown if the latest line is stale.

        Args:
            t: Time now, by the same clock [s].
            expiry: Age beyond which a line is ignored [s].
        """
        is_old = not t - self.heard <= expiry
        return dc.replace(self.stops, is_unknown=is_old)


def with_line(state: ArclState, line: str, t: float) -> ArclState:
    """Returns the state after a line, which may not change it.

    Args:
        state: The previous state.
        line: The line, without its end.
        t: Time of its arrival, by a monotonic clock [s].
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
    """Converts a charge in percent to a fraction; -1 for no valid number."""
    try:
        charge = 0.01 * float(percent)
    except ValueError:
        return -1.0
    return charge if 0.0 <= charge <= 1.0 else -1.0
