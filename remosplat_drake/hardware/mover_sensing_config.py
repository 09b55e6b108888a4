"""`MoverSensingConfig`: the source of movers, and trust in it."""

import dataclasses as dc
from typing import Annotated

from annotated_types import Interval

from remosplat_drake.base.ranges import Config


@dc.dataclass
class MoverSensingConfig(Config):
    """Movers come by LCM, and the robot moves only while they do.

    How old they may be is said by `supervisor.max_movers_age`.
    """

    # How far ahead of our clock a stamp may be [s]; one that is farther is
    # refused.
    max_ahead: Annotated[float, Interval(ge=0, le=0.1)] = 0.02
