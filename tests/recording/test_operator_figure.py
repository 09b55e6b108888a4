"""Figure 5: the curves worked by hand, and that they are drawn."""

import dataclasses as dc

import numpy as np
import pytest
from pydrake.math import RigidTransform

from remosplat_drake.base.errors import FieldError
from remosplat_drake.oracle.signed_distance import SignedDistanceField
from remosplat_drake.recording.events import MAP, SUPERVISOR, Event
from remosplat_drake.recording.operator_figure import (
    draw_operator_figure,
    save_figure,
)
from remosplat_drake.recording.operator_trace import (
    OperatorTrace,
    trace_operator,
)
from remosplat_drake.recording.run_log import RunLogWriter, read_log
from remosplat_drake.scene.primitive_scene import Box, PrimitiveScene
from remosplat_drake.signals.aim import Aim
from remosplat_drake.signals.tick_report import TickReport

GAIN, MAX_SPEED, SPEED = 2.0, 0.3, 0.1


def wall(x: float) -> SignedDistanceField:
    """A wall whose front is at x."""
    box = Box(RigidTransform([x + 0.5, 0, 1]), np.array([0.5, 3, 3]))
    return SignedDistanceField(PrimitiveScene(boxes=(box,)))


@pytest.fixture
def log(frankie, tmp_path):
    """Two ticks of driving ahead, with the target 0.1 m ahead and far up."""
    writer = RunLogWriter(tmp_path / "log", n_q=10, n_u=9, period=0.1)
    u = np.r_[SPEED, np.zeros(8)]
    for k, ahead in enumerate((0.1, 5.0)):
        q = np.r_[0.2 * k, 0, 0, frankie.home]
        X_WT = frankie.end_effector_pose(q).copy()
        X_WT[0, 3] += ahead
        report = dc.replace(
            TickReport.before_first(10, 9),
            time=0.1 * k,
            q=q,
            command=3 * u,
            aim=Aim.of(X_WT),
        )
        writer.append(report, u)
    writer.close()
    return read_log(tmp_path / "log")


def test_deviation_is_of_what_was_executed(log, frankie):
    trace = trace_operator(log, frankie, gain=GAIN, max_speed=MAX_SPEED)
    # The servo wants 2 * 0.1 m/s, then no more than it may.
    np.testing.assert_allclose(
        trace.deviation, [GAIN * 0.1 - SPEED, MAX_SPEED - SPEED]
    )
    np.testing.assert_array_equal(trace.clearance, [np.inf, np.inf])
    assert trace.true_clearance is None


def test_true_clearances_are_of_the_scene_of_the_time(log, frankie):
    fields = wall(2.0), wall(2.5)
    trace = trace_operator(
        log,
        frankie,
        gain=GAIN,
        max_speed=MAX_SPEED,
        truth=lambda time: fields[time > 0.05],
    )
    assert trace.true_clearance is not None
    # The wall has gone 0.5 m ahead, the robot 0.2 m.
    assert np.diff(trace.true_clearance) == pytest.approx(0.3)


@pytest.fixture
def trace() -> OperatorTrace:
    time = np.linspace(0, 2, 50)
    clearance = np.where(time < 1, np.inf, 0.1)
    return OperatorTrace(time, clearance, 0.1 * time, clearance - 0.12)


@pytest.mark.parametrize("ending", ["png", "svg", "pdf"])
def test_a_figure_is_saved_by_its_ending(trace, tmp_path, ending):
    path = tmp_path / f"figure.{ending}"
    events = [
        Event(0.0, MAP, "the first", 0),
        Event(0.5, MAP, "half", 1),
        Event(0.6, MAP, "all", 2),
        Event(1.5, SUPERVISOR, "stopping: too near"),
        Event(9.0, SUPERVISOR, "beyond the end"),
    ]
    figure = draw_operator_figure(trace, stopping=0.02, events=events)
    save_figure(figure, path)
    assert path.stat().st_size > 5000
    above, below = figure.axes
    _, labels = above.get_legend_handles_labels()
    assert labels.count("another map") == labels.count("supervisor") == 1
    assert "true, at least -20.0 mm" in labels
    assert above.get_ylim()[0] < -20
    assert below.get_xlim() == (0, 2)


def test_another_ending_is_an_error_of_the_user(trace, tmp_path):
    figure = draw_operator_figure(trace, stopping=0.02)
    with pytest.raises(FieldError, match="valid: pdf, png, svg"):
        save_figure(figure, tmp_path / "figure.doc")
