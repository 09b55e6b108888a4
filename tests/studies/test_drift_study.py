"""A session whose odometry drifts, through the real process."""

from pathlib import Path

import numpy as np
import pytest

from apps.studies.live_map.__main__ import drift_table
from apps.studies.live_map.drift import DRIFT, drifting, measure_drift
from apps.studies.live_map.session import LiveSession
from remosplat_drake.app.world import load_world

QUICKLY = """
control_period: 0.05
wrist_camera: {width: 160, height: 120}
teleop: {scan: {dwell: 0.1, timeout: 1.0}}
mapping: {frames: 3, voxel: 0.1, discs: 2000, latency: 0.5}
controller: {guidance: {enabled: false}}
"""


@pytest.mark.slow
@pytest.mark.usefixtures("open3d")
def test_map_and_base_stay_where_they_are(tmp_path: Path):
    scenario = drifting(QUICKLY)
    world = load_world(scenario, blank=True)
    assert world.truth is not None
    with LiveSession(scenario, world, tmp_path / "session") as session:
        errors = measure_drift(session, world.truth, 8.0)
    assert errors.drift == pytest.approx(0.16)
    assert errors.versions >= 1
    assert errors.base.max < 0.005
    assert errors.surfaces.p99 < 0.005
    assert drift_table(errors).row_count == 2
    with LiveSession(scenario, world, tmp_path / "session") as again:
        for _ in range(60):
            again.tick()
        measured, q = again.configurations
        X_WB = measured[:3] - np.array(DRIFT) * again.time
        assert again.status.trouble == ""
    assert again.status.scene_map.version == errors.versions
    # The other run's odometry began anew, 16 cm from where this one's is.
    assert np.hypot(*(q[:3] - X_WB)[:2]) < 0.005
