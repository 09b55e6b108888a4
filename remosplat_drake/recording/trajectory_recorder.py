"""`TrajectoryRecorder`: keeps the tick reports of a run in memory."""

from collections import deque

import numpy as np
from pydrake.common.value import Value
from pydrake.systems.framework import (
    Context,
    DiagramBuilder,
    LeafSystem,
    OutputPort,
)

from remosplat_drake.recording.trajectory import Trajectory, make_trajectory
from remosplat_drake.scene.mover import Movers
from remosplat_drake.signals.tick_report import TickReport


class TrajectoryRecorder(LeafSystem):
    """Collects the controller's reports and the executed commands.

    .. pydrake_system::

        name: TrajectoryRecorder
        input_ports:
        - configuration
        - report
        - velocity_executed (optional)
        - movers (optional)

    It publishes once a control period and keeps each new `TickReport`, and
    with it what a supervisor made of its command (`velocity_executed`), and
    the `Movers`; another simulation starts over.

    Args:
        n_q: Length of the configuration.
        n_u: Length of the command.
        period: Control period [s].
        keep: Age at which reports are forgotten [s]; None keeps all, and
            memory grows with the run.

    Attributes:
        reports: All reports that are kept, oldest first.
    """

    def __init__(
        self, *, n_q: int, n_u: int, period: float, keep: float | None = None
    ):
        super().__init__()
        self.set_name("recorder")
        self._n_u = n_u
        self._keep = np.inf if keep is None else keep
        self.reports: deque[TickReport] = deque()
        self._executed: deque[np.ndarray] = deque()
        self._movers: deque[Movers] = deque()
        self._configuration_input = self.DeclareVectorInputPort(
            "configuration", n_q
        )
        self._report_input = self.DeclareAbstractInputPort(
            "report", Value(TickReport.before_first(n_q, n_u))
        )
        self._executed_input = self.DeclareVectorInputPort(
            "velocity_executed", n_u
        )
        self._movers_input = self.DeclareAbstractInputPort(
            "movers", Value[object]()
        )
        self.DeclareInitializationPublishEvent(self._forget)
        self.DeclarePeriodicPublishEvent(period, 0.0, self._record)

    @staticmethod
    def AddToBuilder(
        builder: DiagramBuilder,
        *,
        configuration: OutputPort,
        report: OutputPort,
        executed: OutputPort | None = None,
        movers: OutputPort | None = None,
        **arguments,
    ) -> "TrajectoryRecorder":
        """Adds a recorder to a diagram, and connects it.

        Args:
            builder: Builder of the diagram.
            configuration: The measured configuration q.
            report: The controller's `TickReport`.
            executed: The command u that the station gets, where it may
                differ from the controller's.
            movers: The `Movers`, where anything moves.
            **arguments: The arguments of `TrajectoryRecorder`.
        """
        recorder = builder.AddSystem(TrajectoryRecorder(**arguments))
        builder.Connect(configuration, recorder.GetInputPort("configuration"))
        builder.Connect(report, recorder.GetInputPort("report"))
        if movers is not None:
            builder.Connect(movers, recorder.GetInputPort("movers"))
        if executed is not None:
            builder.Connect(
                executed, recorder.GetInputPort("velocity_executed")
            )
        return recorder

    @property
    def latest(self) -> TickReport | None:
        """The latest report; None before the first."""
        return self.reports[-1] if self.reports else None

    def trajectory(self, context: Context) -> Trajectory:
        """Returns the trajectory up to the context's configuration.

        Args:
            context: The system's own context.
        """
        self._record(context)
        q_end = np.array(self._configuration_input.Eval(context))
        return make_trajectory(
            self.reports, q_end, self._n_u, self._executed, self._movers
        )

    def _forget(self, context: Context):
        self.reports.clear()
        self._executed.clear()
        self._movers.clear()

    def _record(self, context: Context):
        report = self._report_input.Eval(context)
        if np.isfinite(report.time) and report is not self.latest:
            u = report.command
            if self._executed_input.HasValue(context):
                u = np.array(self._executed_input.Eval(context))
            self.reports.append(report)
            self._executed.append(u)
            if self._movers_input.HasValue(context):
                self._movers.append(self._movers_input.Eval(context))
            self._forget_older_than(report.time - self._keep)

    def _forget_older_than(self, time: float):
        while self.reports[0].time < time:
            self.reports.popleft()
            self._executed.popleft()
            if self._movers:
                self._movers.popleft()
