"""`TrajectoryLog`: writes a run's ticks and events to files."""

import math
from pathlib import Path

from pydrake.common.value import AbstractValue, Value
from pydrake.systems.framework import (
    Context,
    DiagramBuilder,
    InputPort,
    LeafSystem,
    OutputPort,
)

from remosplat_drake.recording.events import EventWriter
from remosplat_drake.recording.mcap.mcap_recorder import McapRecorder
from remosplat_drake.recording.mcap.tick_record import TickRecord
from remosplat_drake.recording.run_log import NO_MAP, RunLogWriter
from remosplat_drake.recording.tick_events import LoggedSignals, events_between
from remosplat_drake.signals.optional_input import value_or_none
from remosplat_drake.signals.tick_report import TickReport

LOG, EVENTS = "trajectory.log", "events.jsonl"
"""Names of the two files in a run's folder: the log and the events."""


class TrajectoryLog(LeafSystem):
    """Appends each control tick and each event to files.

    .. pydrake_system::

        name: TrajectoryLog
        input_ports:
        - report
        - velocity_executed (optional)
        - supervision (optional)
        - map_status (optional)
        - target_state (optional)
        - map_requests (optional)
        - station_status (optional)
        - motion_status (optional)
        output_ports:
        - trouble

    The system writes once per control period. It also sends each tick to a
    `McapRecorder`, if there is one. Ticks are passed to the operating system
    once per second, and events at once. A full disk does not end the run. The
    output `trouble` states in one line what the files lack, and is empty if
    they are complete. If another simulation runs with the same diagram, its
    ticks are appended to the same files.

    The input `report` is a `TickReport`, and `velocity_executed` the command u
    that the station received. If `velocity_executed` is not connected, the
    command of the report is used. `supervision` is a `SupervisorState`,
    `map_status` a `MapStatus`, `target_state` a `TargetState`, `map_requests`
    the `MapRequests`, `station_status` a `StationStatus`, and `motion_status` a
    `MotionStatus`.

    Attributes:
        is_paused: Whether writing is paused, for example during a trial
            simulation before the run.

    Args:
        folder: Folder of the run, in which the two files must not exist yet.
            None writes no files.
        n_q: Length of the configuration.
        n_u: Length of the command.
        period: Control period [s].
        recorder: Recorder that writes the run as an MCAP file; None for no such
            file.

    Raises:
        FileError: The files cannot be created.
    """

    def __init__(
        self,
        *,
        folder: Path | None,
        n_q: int,
        n_u: int,
        period: float,
        recorder: McapRecorder | None = None,
    ):
        super().__init__()
        self.set_name("trajectory_log")
        self._log = self._events = None
        if folder is not None:
            self._log = RunLogWriter(
                folder / LOG, n_q=n_q, n_u=n_u, period=period
            )
            self._events = EventWriter(folder / EVENTS)
        self._recorder = recorder
        self._known = LoggedSignals()
        self._map_version = NO_MAP
        self._time = -math.inf
        self.is_paused = False
        self._report_input = self.DeclareAbstractInputPort(
            "report", Value(TickReport.before_first(n_q, n_u))
        )
        self._executed_input = self.DeclareVectorInputPort(
            "velocity_executed", n_u
        )
        self._supervision_input = self._declare_optional("supervision")
        self._map_input = self._declare_optional("map_status")
        self._target_input = self._declare_optional("target_state")
        self._requests_input = self._declare_optional("map_requests")
        self._station_input = self._declare_optional("station_status")
        self._motion_status_input = self._declare_optional("motion_status")
        self.DeclareAbstractOutputPort(
            "trouble", Value("").Clone, self._calc_trouble, {self.time_ticket()}
        )
        self.DeclarePeriodicPublishEvent(period, 0.0, self._record)

    @staticmethod
    def AddToBuilder(
        builder: DiagramBuilder,
        *,
        inputs: dict[str, OutputPort],
        **arguments,
    ) -> "TrajectoryLog":
        """Adds a log to a diagram, and connects its inputs.

        Args:
            builder: Builder of the diagram.
            inputs: Output ports to connect, keyed by the name of the log's
                input port.
            **arguments: The arguments of `TrajectoryLog`.
        """
        log = builder.AddSystem(TrajectoryLog(**arguments))
        for name, port in inputs.items():
            builder.Connect(port, log.GetInputPort(name))
        return log

    @property
    def trouble(self) -> str:
        """Sentence about what the files lack; empty if they are complete."""
        writers = self._log, self._events, self._recorder
        return next((w.trouble for w in writers if w and w.trouble), "")

    def close(self) -> None:
        """Writes the last rows and closes the files."""
        for writer in (self._log, self._events, self._recorder):
            if writer is not None:
                writer.close()

    def _declare_optional(self, name: str) -> InputPort:
        return self.DeclareAbstractInputPort(name, Value[object]())

    def _calc_trouble(self, context: Context, output: AbstractValue):
        output.set_value(self.trouble)

    def _record(self, context: Context):
        if self.is_paused:
            return
        report = self._report_input.Eval(context)
        now = LoggedSignals(
            value_or_none(self._supervision_input, context),
            value_or_none(self._map_input, context),
            value_or_none(self._target_input, context),
            value_or_none(self._requests_input, context),
            value_or_none(self._station_input, context),
            value_or_none(self._motion_status_input, context),
        )
        # A tick uses the map of the last update before this tick.
        map_version, self._map_version = self._map_version, now.map_version
        if not report.time > self._time:
            return
        self._time = report.time
        events = tuple(events_between(self._known, now, report.time))
        self._known = now
        executed = report.command
        if self._executed_input.HasValue(context):
            executed = self._executed_input.Eval(context)
        if self._events is not None:
            for event in events:
                self._events.append(event)
        if self._log is not None:
            self._log.append(
                report, executed, mode=now.mode, map_version=map_version
            )
        if self._recorder is not None:
            self._recorder.append(TickRecord.of(report, executed, now, events))
