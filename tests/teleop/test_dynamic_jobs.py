"""An operator's jobs on the dynamic station: only friction holds an object."""

import numpy as np
import pytest
from job_rig import JobRig

from remosplat_drake.station.station_config import DynamicStation
from remosplat_drake.task.task import DONE, FAILED

STANDS = 0.6158
"""Height of the can's middle on the table [m]."""


def rig_with(folder, **station) -> JobRig:
    def change(scenario):
        scenario.station = DynamicStation(**station)

    return JobRig(folder / "session", change=change)


@pytest.mark.slow
def test_friction_holds_a_can_from_the_table_to_the_tray(tmp_path):
    rig = rig_with(tmp_path)
    rig.ask("takes", thing="soup can")
    rig.until_idle()
    state = rig.jobs.state
    assert state.outcome == DONE, state.failures
    assert rig.true_object("soup can").X_WO.translation()[2] > STANDS + 0.05
    rig.ask("places", support="tray")
    rig.until_idle()
    state = rig.jobs.state
    assert state.outcome == DONE, state.failures
    assert state.held == "" and state.lost == frozenset()
    # It stands upright on the tray, where the program has it in its map.
    X_WO = rig.true_object("soup can").X_WO
    assert X_WO.rotation().matrix()[2, 2] > np.cos(np.radians(2.0))
    p_WO = X_WO.translation()
    assert p_WO[2] == pytest.approx(0.5958 + 0.06, abs=0.003)
    assert p_WO == pytest.approx(rig.p_WO["soup can"], abs=0.01)
    assert rig.closest > 0.021 - 0.004


@pytest.mark.slow
def test_a_can_that_slips_is_lost_and_an_obstacle(tmp_path):
    rig = rig_with(tmp_path, object_friction=0.02)
    rig.ask("takes", thing="soup can")
    rig.until_idle()
    state = rig.jobs.state
    assert state.outcome == FAILED
    assert state.failures[-1] == "the soup can has slipped out of the hand"
    assert state.held == "" and state.lost == {"soup can"}
    # The true can is in the space that is an obstacle now.
    lower, upper = state.named("soup can").corners
    column = state.named("soup can").X_WO
    true = rig.true_object("soup can").X_WO
    off = column.InvertAndCompose(true).translation()
    assert (lower - 0.01 < off).all() and (off < upper + 0.01).all()
    # The hand may leave it; then it must not touch it any more.
    X_WT = rig.X_WE.copy()
    X_WT[2, 3] += 0.25
    rig.ask("moves", X_WT=X_WT)
    rig.until(lambda: not rig.jobs.state.rules)
    assert not rig.supervision.is_latched
