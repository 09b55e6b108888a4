"""`HeardMovers`: movers (moving objects) that were received over LCM."""

import dataclasses as dc

from remosplat_drake.hardware.mover_sensing_config import MoverSensingConfig
from remosplat_drake.hardware.wire.movers import decode_movers
from remosplat_drake.hardware.wire.packets import BrokenMessage
from remosplat_drake.scene.mover import Movers

NONE_HEARD = Movers(0.0, problem="no message with movers has come")
"""Movers before the first message. They are so old that the supervisor stops
the robot.
"""


@dc.dataclass(frozen=True, eq=False)
class HeardMovers:
    """The latest valid movers; a copy is the object itself.

    After an unusable message, the previous movers are kept. As they become
    older, the robot avoids all positions that they may have reached. When they
    are too old, the supervisor stops the robot and reports the problem.

    Attributes:
        movers: The movers, with the problem of the latest message if it was
            unusable.
        refused: Number of unusable messages.
        count: Number of packets of the mailbox that have been processed.
    """

    movers: Movers = NONE_HEARD
    refused: int = 0
    count: int = 0

    def __deepcopy__(self, memo) -> "HeardMovers":
        return self


def with_movers(
    heard: HeardMovers, data: bytes, received: float, config: MoverSensingConfig
) -> HeardMovers:
    """Returns the state after a message with movers.

    Args:
        heard: The state so far.
        data: The encoded packet.
        received: Time of its arrival, by our wall clock [s].
        config: Settings, with the largest time by which a stamp may be ahead of
            our clock.
    """
    try:
        movers = decode_movers(data)
        ahead = movers.stamp - received
        if ahead > config.max_ahead:
            raise BrokenMessage(f"is stamped {ahead:.3g} s in the future")
        late = heard.movers.stamp - movers.stamp
        if late >= 0.0:
            raise BrokenMessage(f"is {late:.3g} s older than the previous one")
    except BrokenMessage as error:
        known = dc.replace(heard.movers, problem=str(error))
        return dc.replace(heard, movers=known, refused=heard.refused + 1)
    return dc.replace(heard, movers=movers)
