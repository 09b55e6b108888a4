"""`TrajectoryRecorder`: stores the numbers of a run's ticks."""

import numpy as np
from pydrake.common.value import Value
from pydrake.systems.framework import (
    Context,
    DiagramBuilder,
    LeafSystem,
    OutputPort,
)

from remosplat_drake.recording.tick_table import BLOCK, TickTable
from remosplat_drake.recording.trajectory import Trajectory
from remosplat_drake.signals.tick_report import TickReport


class TrajectoryRecorder(LeafSystem):
    """Stores the numbers of the controller's reports and executed commands.

    .. pydrake_system::

        name: TrajectoryRecorder
        input_ports:
        - configuration
        - report
        - velocity_executed (optional)
        - movers (optional)

    Once per control period, the system adds the new `TickReport` to a
    `TickTable`, together with the executed command (`velocity_executed`) and
    the `Movers`. Another simulation starts with an empty table. Only the latest
    report is kept as a whole.

    Args:
        n_q: Length of the configuration.
        n_u: Length of the command.
        period: Control period [s].
        keep: Age at which ticks are removed [s]. If it is None, all ticks are
            kept: the latest `BLOCK` ticks in memory, and earlier ticks in a
            temporary file.

    Attributes:
        ticks: All ticks that are kept.
        latest: The latest report; None before the first report.
    """

    def __init__(
        self, *, n_q: int, n_u: int, period: float, keep: float | None = None
    ):
        super().__init__()
        self.set_name("recorder")
        self._keep = np.inf if keep is None else keep
        self._lengths = n_q, n_u
        self._block = BLOCK if keep is None else None
        self.ticks = self._new_table()
        self.latest: TickReport | None = None
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
            executed: The command u that the station executes, if it may differ
                from the controller's command.
            movers: The `Movers`, if there are any.
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

    def trajectory(self, context: Context) -> Trajectory:
        """Returns the trajectory up to the context's configuration.

        Args:
            context: The system's own context.
        """
        self._record(context)
        q_end = np.array(self._configuration_input.Eval(context))
        return self.ticks.trajectory(q_end)

    def _new_table(self) -> TickTable:
        return TickTable(*self._lengths, block=self._block)

    def _forget(self, context: Context):
        self.ticks = self._new_table()
        self.latest = None

    def _record(self, context: Context):
        report = self._report_input.Eval(context)
        if np.isfinite(report.time) and report is not self.latest:
            u, movers = report.command, None
            if self._executed_input.HasValue(context):
                u = np.array(self._executed_input.Eval(context))
            if self._movers_input.HasValue(context):
                movers = self._movers_input.Eval(context)
            self.latest = report
            self.ticks.append(report, u, movers)
            self.ticks.forget_before(report.time - self._keep)
