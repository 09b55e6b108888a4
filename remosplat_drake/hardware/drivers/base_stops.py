"""`BaseStops`: the causes that stop a mobile base."""

import dataclasses as dc
from collections.abc import Iterable
from typing import Protocol

from remosplat_drake.hardware.wire.messages.base_status import base_status


@dc.dataclass(frozen=True)
class BaseStops:
    """The causes that stop a base.

    Attributes:
        emergency: Whether an emergency stop is latched.
        protective: Whether the safety scanner has stopped the motors.
        motors_off: Whether the motors are off for another reason.
        is_unknown: Whether a configured source sends nothing.
        battery: State of charge, 0 to 1; negative if unknown.
    """

    emergency: bool = False
    protective: bool = False
    motors_off: bool = False
    is_unknown: bool = False
    battery: float = -1.0


FREE = BaseStops()
"""State of a base without a known stop."""


class StopSource(Protocol):
    """Protocol of a source of a base's stops."""

    def stops(self, t: float) -> BaseStops:
        """Returns the base's stops.

        Args:
            t: Time now, by a monotonic clock [s].
        """
        ...


def merged(stops: Iterable[BaseStops]) -> BaseStops:
    """Combines the stops of several sources; any of them can stop the base."""
    every = [FREE, *stops]
    return BaseStops(
        emergency=any(s.emergency for s in every),
        protective=any(s.protective for s in every),
        motors_off=any(s.motors_off for s in every),
        is_unknown=any(s.is_unknown for s in every),
        battery=max(s.battery for s in every),
    )


def tell(status: base_status, stops: BaseStops) -> None:
    """Writes stops into a status message, in place.

    If a configured source sends nothing, the status reports a fault.
    """
    status.emergency_stop = int(stops.emergency)
    status.protective_stop = int(stops.protective)
    status.battery = stops.battery
    if stops.is_unknown:
        status.mode = base_status.FAULT
    elif stops.emergency or stops.protective or stops.motors_off:
        status.mode = base_status.STOPPED
