"""`LivePlots`: plots clearance and velocity of the last seconds."""

from collections import deque
from collections.abc import Callable
from functools import partial

import numpy as np
from pydrake.common.value import Value
from pydrake.systems.framework import (
    Context,
    DiagramBuilder,
    LeafSystem,
    OutputPort,
)

from remosplat_drake.controller.deviation import (
    deviation,
    end_effector_velocities,
)
from remosplat_drake.robot.robot_model import RobotModel
from remosplat_drake.signals.tick_report import TickReport
from remosplat_drake.visualization.clearance_plot import clearance_plot
from remosplat_drake.visualization.page import MeshcatPage
from remosplat_drake.visualization.svg_plot import SvgPlot

SPAN = 20.0
"""Length of the time axes [s]."""

_BIN = 0.1
_REDRAW = 0.25  # Of either plot; they take turns.


class LivePlots(LeafSystem):
    """Plots clearance and velocity deviation, as in the paper's figure 5.

    .. pydrake_system::

        name: LivePlots
        input_ports:
        - report
        - executed

    The upper plot shows the smallest clearance in the controller's reports. The
    lower one shows the difference between the end effector's velocity and the
    desired velocity of the controller's servo. `report` takes the controller's
    `TickReport`, and `executed` the velocity u that the station gets. Each
    point of a curve is the worst value of the ticks in an interval of 0.1 s.

    Args:
        page: The page to draw on.
        robot: The robot, for its kinematics.
        gain: Gain of the controller's servo [1/s].
        max_speed: Largest speed that the controller's servo commands [m/s].
        stopping: Clearance at which the controller stops approaching [m].
        influence: Influence distance: larger clearances are not measured [m].
        period: Time between two updates, the control period [s].
    """

    def __init__(
        self,
        *,
        page: MeshcatPage,
        robot: RobotModel,
        gain: float,
        max_speed: float,
        stopping: float,
        influence: float,
        period: float,
    ):
        super().__init__()
        self.set_name("live_plots")
        self._page = page
        self._robot = robot
        self._servo = gain, max_speed
        self._plots = (
            clearance_plot(stopping, influence),
            SvgPlot(
                title="Desired and executed velocity differ by",
                unit="m/s",
                lower=0.0,
                upper=1.25 * max_speed,
                color="#7a4fb0",
            ),
        )
        self._clearance = RollingTrace(SPAN, _BIN, min)
        self._deviation = RollingTrace(SPAN, _BIN, max)
        self._report_input = self.DeclareAbstractInputPort(
            "report", Value(TickReport.before_first(robot.n_q, robot.n_u))
        )
        self._executed_input = self.DeclareVectorInputPort(
            "executed", robot.n_u
        )
        self.DeclarePeriodicPublishEvent(period, 0.0, self._sample)
        for place in (0, 1):
            self.DeclarePeriodicPublishEvent(
                _REDRAW, place * _REDRAW / 2, partial(self._draw, place)
            )
        self.DeclareForcedPublishEvent(self._publish)

    @staticmethod
    def AddToBuilder(
        builder: DiagramBuilder,
        *,
        report: OutputPort,
        executed: OutputPort,
        **arguments,
    ) -> "LivePlots":
        """Adds the plots to a diagram, and connects them.

        Args:
            builder: Builder of the diagram.
            report: Output port of the controller's `TickReport`.
            executed: Output port of the command u that the station gets.
            **arguments: The arguments of `LivePlots`.
        """
        plots = builder.AddSystem(LivePlots(**arguments))
        builder.Connect(report, plots.GetInputPort("report"))
        builder.Connect(executed, plots.GetInputPort("executed"))
        return plots

    def _publish(self, context: Context):
        self._sample(context)
        for place in (0, 1):
            self._draw(place, context)

    def _sample(self, context: Context):
        report = self._report_input.Eval(context)
        if np.isnan(report.time):
            return
        executed = self._executed_input.Eval(context)
        time = context.get_time()
        self._clearance.add(time, report.clearances.minimum())
        velocities = end_effector_velocities(
            report, executed, self._robot, *self._servo
        )
        self._deviation.add(time, deviation(*velocities))

    def _draw(self, place: int, context: Context):
        trace = (self._clearance, self._deviation)[place]
        svg = self._plots[place].draw(*trace.ages(context.get_time()))
        self._page.set_plot(str(place), svg)


class RollingTrace:
    """Keeps the extreme value of each short interval of the last seconds.

    Args:
        span: Time for which values are kept [s].
        interval: Length of an interval [s].
        worse: Function that chooses the worse of two values, `min` or `max`.
            NaN counts as worst.
    """

    def __init__(
        self,
        span: float,
        interval: float,
        worse: Callable[[float, float], float],
    ):
        self._interval = interval
        self._worse = worse
        self._points: deque[tuple[int, float]] = deque(
            maxlen=round(span / interval) + 1
        )

    def add(self, time: float, value: float):
        """Adds a value; if time goes backwards, all earlier values are dropped.

        Args:
            time: Time of the value [s].
            value: The value.
        """
        number = int(np.floor(time / self._interval + 1e-9))
        if self._points and number < self._points[-1][0]:
            self._points.clear()
        if self._points and number == self._points[-1][0]:
            before = self._points.pop()[1]
            if not np.isnan(value):
                value = (
                    before if np.isnan(before) else self._worse(before, value)
                )
        self._points.append((number, value))

    def ages(self, now: float) -> tuple[np.ndarray, np.ndarray]:
        """Returns the ages of the values [s], and the values.

        Args:
            now: Present time [s].
        """
        if not self._points:
            return np.zeros(0), np.zeros(0)
        number, value = np.array(self._points).T
        return np.maximum(now - number * self._interval, 0.0), value
