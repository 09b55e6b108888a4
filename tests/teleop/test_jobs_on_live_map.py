"""Jobs on a map that is built from frames of the same run."""

import numpy as np
import pytest
from job_rig import JobRig

from remosplat_drake.robot.sphere_model import Spheres
from remosplat_drake.task.task import DONE

pytest.importorskip("open3d")

TEXT = """
scene: {splat: "", unknown: obstacle}
mapping: {enabled: true, latency: 4, frames: 8}
"""
"""Nothing is known at first, and unseen space is an obstacle."""

STOOD = np.array([1.12, 0.5, 0.6158])
"""Where the can stands at first [m]."""


def room_at(rig: JobRig, p_W: np.ndarray) -> float:
    """Distance of a point from the live map, which has no objects [m]."""
    field = rig.live_map.scene_map.field
    return field.clearances(Spheres.at(p_W)).minimum()


def map_after(rig: JobRig, ask) -> None:
    """Waits until a requested map is in use."""
    version = rig.live_map.scene_map.version
    ask()
    rig.until(lambda: rig.live_map.scene_map.version > version)


@pytest.mark.slow
def test_a_can_is_carried_in_a_map_of_the_run(tmp_path):
    rig = JobRig(tmp_path / "session", text=TEXT)
    map_after(rig, lambda: rig.ask("scans"))
    # The can is not in the map, although frames show it; only the lowest 15 mm
    # may be, since they may also show the table.
    assert room_at(rig, STOOD) > 0.04
    rig.ask("takes", thing="soup can")
    rig.until_idle()
    assert rig.jobs.state.outcome == DONE, rig.jobs.state.failures
    print(rig.time, "taken")
    map_after(rig, lambda: rig.ask("scans"))
    print(rig.time, "scanned")
    # Frames of the wrist camera show the can in the hand, and the place where
    # it stood.
    assert room_at(rig, rig.p_WO["soup can"]) > 0.04
    assert room_at(rig, STOOD) > 0.055
    rig.ask("places", support="tray")
    rig.until_idle()
    assert rig.jobs.state.outcome == DONE, rig.jobs.state.failures
    print(rig.time, "placed")
    map_after(rig, lambda: rig.ask("scans"))
    print(rig.time, "scanned")
    assert room_at(rig, rig.p_WO["soup can"]) > 0.04
    assert rig.closest > 0.021 - 0.004
