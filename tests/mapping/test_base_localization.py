"""The base's pose follows what a map says of it, in small steps."""

import numpy as np
import pytest
from pydrake.common.value import Value
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import DiagramBuilder
from pydrake.systems.primitives import ConstantVectorSource

from remosplat_drake.mapping.localization.base_localization import (
    BaseLocalization,
)
from remosplat_drake.signals.base_correction import BaseCorrection

PERIOD, SPEED = 0.01, 0.05
MEASURED = np.array([2.0, 1.0, 0.5, 0.1, -0.2])


@pytest.fixture
def simulator() -> Simulator:
    builder = DiagramBuilder()
    q = builder.AddSystem(ConstantVectorSource(MEASURED))
    system = BaseLocalization.AddToBuilder(
        builder, q.get_output_port(), n_q=5, period=PERIOD, speed=SPEED
    )
    builder.ExportOutput(system.GetOutputPort("configuration"), "q")
    builder.ExportInput(system.GetInputPort("correction"), "correction")
    return Simulator(builder.Build())


def configuration(simulator: Simulator) -> np.ndarray:
    diagram = simulator.get_system()
    return diagram.GetOutputPort("q").Eval(simulator.get_context())


def correct(simulator: Simulator, pose: list[float]) -> None:
    diagram = simulator.get_system()
    diagram.GetInputPort("correction").FixValue(
        simulator.get_mutable_context(),
        Value(BaseCorrection(np.array(pose), time=1.0)),
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
