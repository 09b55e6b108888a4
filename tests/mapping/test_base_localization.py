"""The base's pose follows what a map says of it, in small steps."""

import dataclasses as dc

import numpy as np
import pytest
from pydrake.common.value import Value
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import DiagramBuilder
from pydrake.systems.primitives import ConstantVectorSource

from remosplat_drake.mapping.localization.base_localization import (
    BaseLocalization,
)
from remosplat_drake.robot.planar_pose import composed
from remosplat_drake.signals.base_correction import BaseCorrection
from remosplat_drake.signals.base_estimate import BaseEstimate, Drift

PERIOD, SPEED = 0.01, 0.05
STILL = Drift(0.0, 0.0)
MEASURED = np.array([2.0, 1.0, 0.5, 0.1, -0.2])


@pytest.fixture
def simulator() -> Simulator:
    builder = DiagramBuilder()
    q = builder.AddSystem(ConstantVectorSource(MEASURED))
    system = BaseLocalization.AddToBuilder(
        builder, q.get_output_port(), n_q=5, period=PERIOD, speed=SPEED
    )
    builder.ExportOutput(system.GetOutputPort("configuration"), "q")
    builder.ExportOutput(system.GetOutputPort("base_uncertainty"), "bound")
    builder.ExportInput(system.GetInputPort("correction"), "correction")
    return Simulator(builder.Build())


def configuration(simulator: Simulator) -> np.ndarray:
    diagram = simulator.get_system()
    return diagram.GetOutputPort("q").Eval(simulator.get_context())


def correct(
    simulator: Simulator, X_WO: list[float], drift: Drift = STILL
) -> None:
    """Tells, at the time 0, where the odometry's frame is."""
    X_OB = MEASURED[:3]
    first = BaseEstimate.first(0.0, X_OB, drift)
    estimate = dc.replace(first, X_WB=composed(np.array(X_WO), X_OB))
    simulator.get_system().GetInputPort("correction").FixValue(
        simulator.get_mutable_context(),
        Value(BaseCorrection(estimate, drift)),
    )


def test_without_a_correction_nothing_changes(simulator):
    simulator.AdvanceTo(1.0)
    np.testing.assert_array_equal(configuration(simulator), MEASURED)


def test_no_tick_sees_the_base_jump(simulator):
    correct(simulator, [0.03, -0.04, 0.0])
    before = MEASURED
    for tick in range(1, 120):
        simulator.AdvanceTo(tick * PERIOD)
        q = configuration(simulator)
        assert np.hypot(*(q - before)[:2]) <= SPEED * PERIOD + 1e-12
        before = q
    # 5 cm at 5 cm/s take a second.
    np.testing.assert_allclose(before - MEASURED, [0.03, -0.04, 0, 0, 0])


def test_a_turn_of_a_far_frame_is_as_slow_at_the_base(simulator):
    correct(simulator, [0.0, 0.0, 0.02])
    simulator.AdvanceTo(10.5 * PERIOD)
    moved = configuration(simulator) - MEASURED
    assert 0 < np.hypot(*moved[:2]) <= 11 * SPEED * PERIOD + 1e-9
    simulator.AdvanceTo(2.0)
    assert configuration(simulator)[2] - 0.5 == pytest.approx(0.02)


def test_between_frames_the_base_is_known_less_and_less(simulator):
    correct(simulator, [0.0, 0.0, 0.0], Drift(0.01, 0.002, memory=1e4))
    bound = []
    for time in (0.0, 1.0, 5.0):
        simulator.AdvanceTo(time)
        port = simulator.get_system().GetOutputPort("bound")
        bound.append(port.Eval(simulator.get_context()))
    # Unknown rates, of 1 cm/s and 2 mrad/s, three deviations of
    # them.
    np.testing.assert_allclose(bound[0], 0.0, atol=0.003)
    np.testing.assert_allclose(bound[1], [0.03, 0.006], rtol=0.02)
    np.testing.assert_allclose(bound[2], [0.15, 0.03], rtol=0.02)
