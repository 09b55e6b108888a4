"""`SafetyPanel`: the page's stop button, and the supervisor's state."""

import numpy as np
from pydrake.common.value import Value
from pydrake.systems.framework import (
    Context,
    DiagramBuilder,
    LeafSystem,
    OutputPort,
)

from remosplat_drake.signals.motion_status import NOT_STARTED
from remosplat_drake.signals.operator_requests import OperatorRequests
from remosplat_drake.signals.station_status import StationStatus
from remosplat_drake.signals.supervisor_state import SupervisorState
from remosplat_drake.signals.tick_report import TickReport
from remosplat_drake.visualization.page import MeshcatPage
from remosplat_drake.visualization.page_state import (
    RELEASE,
    STOP,
    supervised,
)
from remosplat_drake.visualization.robot_view import PUBLISH_PERIOD

_AGES_SHOWN = 0.5
"""Time between two updates of the displayed ages [s]. The panel shows the
largest ages since the previous update."""


class SafetyPanel(LeafSystem):
    """Lets a person stop and release the robot, and shows its state.

    .. pydrake_system::

        name: SafetyPanel
        input_ports:
        - report
        - status
        - supervision
        - motion_status (optional)
        output_ports:
        - operator

    `report` takes the controller's `TickReport`, `status` the `StationStatus`,
    `supervision` the `SupervisorState`, `motion_status` the `MotionStatus`;
    `operator` outputs the `OperatorRequests` so far. The page's bar shows the
    robot's state, and the reason if the supervisor stops the robot. A line of
    text shows the arm's mode, and the largest ages of measurements and commands
    in the last half second.

    Args:
        page: The page that gets bar and buttons.
        n_u: Length of the command.
        releases: Whether the page can also release stops. It must be False for
            a real robot, since Meshcat cannot identify its visitors, and other
            web pages can press its buttons.
    """

    def __init__(self, *, page: MeshcatPage, n_u: int, releases: bool = True):
        super().__init__()
        self.set_name("safety_panel")
        self._page = page
        self._releases = releases
        self._report_input = self.DeclareAbstractInputPort(
            "report", Value(TickReport.before_first(0, n_u))
        )
        self._status_input = self.DeclareAbstractInputPort(
            "status", Value(StationStatus())
        )
        before = SupervisorState(np.zeros(n_u))
        self._supervision_input = self.DeclareAbstractInputPort(
            "supervision", Value(before)
        )
        self._motion_status_input = self.DeclareAbstractInputPort(
            "motion_status", Value(NOT_STARTED)
        )
        page.show(supervised(before, releases=releases))
        self.DeclareAbstractOutputPort(
            "operator",
            Value(OperatorRequests()).Clone,
            self._calc_requests,
            {self.time_ticket()},
        )
        self._ages = np.zeros(2)
        self._ages_shown = -np.inf
        self.DeclarePeriodicPublishEvent(PUBLISH_PERIOD, 0.0, self._publish)

    def ConnectTo(
        self,
        builder: DiagramBuilder,
        *,
        supervisor: LeafSystem,
        report: OutputPort,
        status: OutputPort,
        motion_status: OutputPort,
    ) -> None:
        """Connects the panel with a supervisor, in both directions.

        Add the panel to the diagram before all other controls, so that its stop
        button is above all other buttons of the page.

        Args:
            builder: Builder of the diagram that contains both.
            supervisor: The `SafetySupervisor`.
            report: Output port of the controller's `TickReport`.
            status: Output port of the `StationStatus`.
            motion_status: Output port of the `MotionStatus`.
        """
        for source, sink in (
            (report, self._report_input),
            (status, self._status_input),
            (motion_status, self._motion_status_input),
            (
                supervisor.GetOutputPort("supervision"),
                self._supervision_input,
            ),
            (
                self.GetOutputPort("operator"),
                supervisor.GetInputPort("operator"),
            ),
        ):
            builder.Connect(source, sink)

    def _calc_requests(self, context: Context, output: Value):
        clicks = self._page.clicks
        output.set_value(OperatorRequests(clicks(STOP), clicks(RELEASE)))

    def _publish(self, context: Context):
        status = self._status_input.Eval(context)
        self._show_ages(context.get_time(), status, context)
        supervision = self._supervision_input.Eval(context)
        motion_status = NOT_STARTED
        if self._motion_status_input.HasValue(context):
            motion_status = self._motion_status_input.Eval(context)
        self._page.show(
            supervised(
                supervision,
                releases=self._releases,
                motion_status=motion_status,
            )
        )

    def _show_ages(self, time: float, status: StationStatus, context: Context):
        report = self._report_input.Eval(context)
        ages = [status.age, time - report.time]
        # The panel shows an age of NaN as infinite, so that a person notices
        # it.
        self._ages = np.maximum(self._ages, ages)
        if 0 <= time - self._ages_shown < _AGES_SHOWN:
            return
        self._ages_shown = time
        measured, commanded = map(_milliseconds, self._ages)
        text = f"age of measurement: {measured}, of command: {commanded}"
        self._page.set_status(f"{status.robot_mode}, {text}", "robot")
        self._ages = np.zeros(2)


def _milliseconds(age: float) -> str:
    return f"{1e3 * age:.0f} ms" if np.isfinite(age) else "forever"
