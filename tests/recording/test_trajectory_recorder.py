"""A recorder that forgets: as much memory after an hour as after a minute."""

import dataclasses as dc
import gc

import numpy as np
import pytest
from pydrake.common.value import AbstractValue, Value
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import Context, DiagramBuilder, LeafSystem
from pydrake.systems.primitives import ConstantVectorSource

from remosplat_drake.recording.trajectory_recorder import TrajectoryRecorder
from remosplat_drake.signals.tick_report import TickReport

PERIOD = 0.125


class Ticks(LeafSystem):
    """Reports the number of its tick as configuration."""

    def __init__(self):
        super().__init__()
        none = TickReport.before_first(1, 1)
        index = self.DeclareAbstractState(Value(none))
        self.DeclareStateOutputPort("report", index)
        self.DeclarePeriodicUnrestrictedUpdateEvent(PERIOD, 0.0, self._tick)

    def _tick(self, context: Context, state: AbstractValue):
        time = context.get_time()
        report = dc.replace(
            TickReport.before_first(1, 1),
            time=time,
            q=np.array([time / PERIOD]),
        )
        state.get_mutable_abstract_state(0).set_value(report)


def recorded(
    simulator_end: float, keep: float | None
) -> tuple[TrajectoryRecorder, Simulator]:
    """A recorder after a while, in a simulation that may go on."""
    builder = DiagramBuilder()
    q = builder.AddSystem(ConstantVectorSource([0.0]))
    ticks = builder.AddSystem(Ticks())
    recorder = TrajectoryRecorder.AddToBuilder(
        builder,
        configuration=q.get_output_port(),
        report=ticks.GetOutputPort("report"),
        n_q=1,
        n_u=1,
        period=PERIOD,
        keep=keep,
    )
    simulator = Simulator(builder.Build())
    simulator.AdvanceTo(simulator_end)
    return recorder, simulator


@pytest.mark.parametrize(
    ("keep", "kept"), [(None, 24), (1.0, 9), (0.0, 1), (60.0, 24)]
)
def test_only_the_latest_ticks_are_kept(keep, kept):
    recorder, simulator = recorded(3.0, keep)
    trajectory = recorder.trajectory(
        recorder.GetMyContextFromRoot(simulator.get_context())
    )
    assert len(recorder.ticks) == len(trajectory) == kept
    np.testing.assert_array_equal(trajectory.q[:-1, 0], np.arange(24)[-kept:])
    assert recorder.latest is not None
    assert recorder.latest.time == trajectory.time[-1]


def alive() -> int:
    """The number of reports in memory."""
    gc.collect()
    # By their types: what weak references stand for may have gone.
    return sum(type(each) is TickReport for each in gc.get_objects())


def test_a_run_that_keeps_all_ticks_keeps_no_reports():
    _, simulator = recorded(10.0, None)
    before = alive()
    simulator.AdvanceTo(20.0)
    assert alive() == before
    simulator.AdvanceTo(1000.0)
    assert alive() == before
