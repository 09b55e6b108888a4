"""`CockpitPlots`: plots the last half minute, for all clients."""

import dataclasses as dc
from collections.abc import Callable
from time import monotonic

import numpy as np
import viser

from remosplat_drake.cockpit.messages import CockpitJob, PageContent
from remosplat_drake.visualization.clearance_plot import AMBER, clearance_plot
from remosplat_drake.visualization.live_plots import RollingTrace
from remosplat_drake.visualization.svg_plot import Mark, SvgPlot

SPAN = 30.0
"""Length of the time axes [s]."""

PERIOD = 0.5
"""Time between two updates of the plots [s]."""

_BIN = 0.2
"""A curve shows the worst value of each time interval of this length [s]."""

_SIZE = {"span": SPAN, "width": 290, "height": 116}
_STYLE = "<style>.remosplat-plot svg{width:100%;height:auto}</style>"


@dc.dataclass(eq=False)
class _Curve:
    """A plot of the cockpit, and its values.

    Attributes:
        plot: The look of the plot.
        trace: The latest values.
        picture: Element of the page that shows the plot.
        grows: Whether the value axis grows with the values.
    """

    plot: SvgPlot
    trace: RollingTrace
    picture: viser.GuiHtmlHandle
    grows: bool

    def draw(self, now: float) -> None:
        age, value = self.trace.ages(now)
        plot = with_room_for(self.plot, value) if self.grows else self.plot
        svg = plot.draw(age, value)
        self.picture.content = f'<div class="remosplat-plot">{svg}</div>'


class CockpitPlots:
    """Draws plots of clearance, distance to the target and tick time.

    The plots are folded at first. They have no controls, so that all clients
    can share them. The server sends some kilobytes twice a second.

    Args:
        server: The page's server.
        job: The settings of the cockpit's process.
    """

    def __init__(self, server: viser.ViserServer, job: CockpitJob):
        self._server = server
        self._now, self._drawn_at = 0.0, -np.inf
        with server.gui.add_folder("Plots", order=3.0, expand_by_default=False):
            server.gui.add_html(_STYLE)
            # The plot shows only clearances below the influence distance.
            self._clearance = self._add(
                clearance_plot(job.stopping, job.influence, **_SIZE),
                min,
                grows=False,
            )
            self._distance = self._add(
                SvgPlot("Distance to the target", "m", 0.0, 0.1, **_SIZE), max
            )
            self._duration = self._add(_duration_plot(job.control_period), max)
        self.draw()

    def _add(
        self,
        plot: SvgPlot,
        worse: Callable[[float, float], float],
        *,
        grows: bool = True,
    ) -> _Curve:
        picture = self._server.gui.add_html("")
        return _Curve(plot, RollingTrace(SPAN, _BIN, worse), picture, grows)

    def add(self, content: PageContent) -> None:
        """Adds the values of one moment.

        Args:
            content: The page's content at that moment.
        """
        self._now = content.time
        distance = np.linalg.norm(content.X_WT[:3, 3] - content.X_WE[:3, 3])
        self._distance.trace.add(content.time, float(distance))
        if content.worst is not None:
            self._clearance.trace.add(content.time, content.worst.clearance)
            self._duration.trace.add(content.time, 1e3 * content.worst.duration)

    def draw(self) -> None:
        """Draws the plots, unless they were drawn less than `PERIOD` ago."""
        if monotonic() - self._drawn_at < PERIOD:
            return
        self._drawn_at = monotonic()
        with self._server.atomic():
            for curve in (self._clearance, self._distance, self._duration):
                curve.draw(self._now)


def with_room_for(plot: SvgPlot, value: np.ndarray) -> SvgPlot:
    """Returns a plot whose value axis ends at a round number above all values.

    Args:
        plot: The plot. Its value axis becomes longer or remains unchanged.
        value: The values, shape (n,); infinite values are ignored.
    """
    most = float(np.max(value[np.isfinite(value)], initial=0.0))
    if most <= plot.upper:
        return plot
    power = 10.0 ** np.floor(np.log10(most))
    upper = next(power * m for m in (1, 2, 5, 10) if power * m >= most)
    return dc.replace(plot, upper=upper)


def _duration_plot(control_period: float) -> SvgPlot:
    period = 1e3 * control_period
    return SvgPlot(
        title="A control tick takes",
        unit="ms",
        lower=0.0,
        upper=1.25 * period,
        marks=(Mark(period, f"control period {period:g} ms", AMBER),),
        color="#7a4fb0",
        digits=1,
        **_SIZE,
    )
