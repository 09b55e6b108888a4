"""A planner of guidance: only ever to the right."""

import dataclasses as dc

from remosplat_drake.base.ranges import Config
from remosplat_drake.controller.program.guidance import Guidance


@dc.dataclass
class RightOnly(Config):
    """Passing on the left is forbidden."""

    def propose(self, situation) -> list[list[Guidance]]:
        """One candidate a tier."""
        return [
            [Guidance("keep right", -1.0, 0.8, 0.5, tier)]
            for tier in situation.tiers
        ]
