"""`MoverSensingConfig`: settings of a source of movers (moving objects)."""

import dataclasses as dc
from typing import Annotated

from annotated_types import Interval

from remosplat_drake.base.ranges import Config


@dc.dataclass
class MoverSensingConfig(Config):
    """Movers are received by LCM; without messages, the robot is stopped.

    `supervisor.max_movers_age` is their greatest age.
    """

    # Greatest time by which a stamp may be ahead of our clock [s]; messages
    # with a later stamp are rejected.
    max_ahead: Annotated[float, Interval(ge=0, le=0.1)] = 0.02
