"""`WorstTick`: the worst of several control ticks, for plots."""

import dataclasses as dc

import numpy as np

from remosplat_drake.signals.tick_report import TickReport


@dc.dataclass(frozen=True)
class WorstTick:
    """The worst of several control ticks.

    Attributes:
        clearance: Smallest distance from the robot to the scene that the
            controller measured [m]; inf if all distances exceeded the influence
            distance.
        duration: Longest time that a tick took [s]; NaN if it was not
            measured.
    """

    clearance: float
    duration: float

    @staticmethod
    def of(report: TickReport) -> "WorstTick":
        """Makes a `WorstTick` of a single tick.

        Args:
            report: The report of the tick.
        """
        duration = report.timings.get("total", np.nan)
        return WorstTick(report.clearances.minimum(), duration)

    def or_of(self, others: "WorstTick | None") -> "WorstTick":
        """Returns the worst of these ticks and further ticks.

        Args:
            others: The worst of the further ticks; None if there are none.
        """
        if others is None:
            return self
        return WorstTick(
            min(self.clearance, others.clearance),
            float(np.fmax(self.duration, others.duration)),
        )
