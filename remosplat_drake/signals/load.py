"""`Load`: the payload of a robot, as a value that crosses ports."""

import dataclasses as dc

from pydrake.systems.framework import Context, InputPort

from remosplat_drake.robot.payload import Payload


@dc.dataclass(frozen=True)
class Load:
    """The payload of a robot on a port; copying returns the object itself.

    The class contains the payload, since in some versions of Drake the value of
    a port must not be None.

    Attributes:
        payload: The payload; None if the robot carries nothing.
    """

    payload: Payload | None = None

    def __deepcopy__(self, memo) -> "Load":
        return self


EMPTY = Load()
"""The load of a robot that carries nothing."""


def payload_of(port: InputPort, context: Context) -> Payload | None:
    """Reads the robot's payload from an input port.

    Args:
        port: An input port for a `Load`, which may be left unconnected.
        context: The context of its system.

    Returns:
        The payload; None if the robot carries nothing.
    """
    return port.Eval(context).payload if port.HasValue(context) else None
