"""`MoverSensingConfig`: settings of a source of movers (moving objects)."""

import dataclasses as dc
from typing import Annotated

from annotated_types import Interval

from remosplat_drake.base.ranges import Config


@dc.dataclass
class MoverSensingConfig(Config):
    """Settings of movers that are received over LCM.

    If the movers are older than `supervisor.max_movers_age`, the supervisor
    stops the robot.
    """

    # Greatest time by which a stamp may be ahead of our clock [s]; messages
    # with a later stamp are rejected.
    max_ahead: Annotated[float, Interval(ge=0, le=0.1)] = 0.02
