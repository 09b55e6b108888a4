"""Jobs on a map that is built from frames of the same run."""

import numpy as np
import pytest
from job_rig import JobRig
from pydrake.math import RotationMatrix

from remosplat_drake.robot.sphere_model import Spheres
from remosplat_drake.task.task import DONE

pytestmark = [pytest.mark.slow, pytest.mark.usefixtures("open3d")]

TEXT = """
scene: {splat: "", unknown: obstacle}
mapping: {enabled: true, latency: 4}
robot: {base_pose: [0.1, 0.5, 0.0]}
"""
"""Nothing is known at first, and unseen space is an obstacle."""

STOOD = np.array([1.12, 0.5, 0.6158])
"""Where the can stands at first [m]."""

RADIUS = 0.033
"""Radius of the can [m]."""

VIEWS = (([0.6, 0.5, 1.05], 1.0), ([0.65, 0.6, 0.95], 0.8), ([0.93, 0.5, 1], 0))
"""Positions of the hand [m] and its angle to the vertical [rad], from which the
wrist camera sees the can and the space around it."""


OF_TRAY = (([0.6, 0.8, 1.05], 1.0), ([0.8, 0.8, 0.95], 0.3))
"""The same for the tray."""


def look(rig: JobRig, p_WE: list[float], angle: float) -> None:
    """Adds a frame to the map, from a pose that the robot reaches."""
    X_WT = np.eye(4)
    X_WT[:3, 3] = p_WE
    tilt = RotationMatrix.MakeYRotation(-angle).matrix()
    X_WT[:3, :3] = tilt @ np.diag([1.0, -1.0, -1.0])
    rig.ask("moves", X_WT=X_WT)
    rig.until(lambda: np.linalg.norm(rig.X_WE[:3, 3] - X_WT[:3, 3]) < 0.05)
    rig.ask("holds")
    rig.until(lambda: not rig.u.any())
    new_map(rig, rig.person.take_frame)


def new_map(rig: JobRig, request) -> None:
    """Requests a map, and waits until it is in use."""
    version = rig.live_map.scene_map.version
    request()
    rig.until(lambda: rig.live_map.scene_map.version > version)


def room(rig: JobRig, p_W: np.ndarray) -> float:
    """Distance of a point from the live map, which has no objects [m]."""
    field = rig.live_map.scene_map.field
    return field.clearances(Spheres.at(p_W)).minimum()


def held_at(rig: JobRig) -> np.ndarray:
    """Position of the carried object [m]."""
    X_OE = rig.jobs.state.X_OE
    assert X_OE is not None
    return (rig.X_WE @ np.linalg.inv(X_OE))[:3, 3]


@pytest.mark.slow
def test_a_can_is_taken_and_placed_in_a_map_of_the_run(tmp_path):
    rig = JobRig(tmp_path / "session", text=TEXT)
    new_map(rig, lambda: rig.ask("scans"))
    for view in (*VIEWS, *OF_TRAY):
        look(rig, *view)
    # Frames show the can, but the map does not contain it.
    assert room(rig, STOOD) > RADIUS + 0.01
    beside = STOOD + np.array([0.0, RADIUS + 0.03, 0.0])
    assert room(rig, beside) > 0.03
    rig.ask("takes", thing="soup can")
    rig.until_idle()
    assert rig.jobs.state.outcome == DONE, rig.jobs.state.failures
    assert rig.jobs.state.held == "soup can"
    # Frames show the can in the hand, and the place where it stood.
    new_map(rig, rig.person.take_frame)
    look(rig, [0.8, 0.5, 1.0], 0.3)
    assert room(rig, held_at(rig)) > RADIUS + 0.1
    assert room(rig, STOOD) > RADIUS + 0.1
    rig.ask("places", support="tray")
    rig.until_idle()
    assert rig.jobs.state.outcome == DONE, rig.jobs.state.failures
    for view in OF_TRAY:
        look(rig, *view)
    assert room(rig, rig.p_WO["soup can"]) > RADIUS + 0.01
    assert not rig.supervision.is_latched
    assert rig.closest > 0.021 - 0.004
