"""Whose fault a contact is where cameras tell what moves, by hand."""

import numpy as np
import pytest
from pydrake.math import RigidTransform

from remosplat_drake.benchmark.watched_run import WatchedRun
from remosplat_drake.detection.detection_camera_config import (
    DetectionCameraConfig,
)
from remosplat_drake.detection.simulated.camera_detection import placed_cameras
from remosplat_drake.recording.mover_contacts import (
    TOWARDS,
    UNSEEN,
    judge_movers,
)
from remosplat_drake.recording.trajectory import Trajectory
from remosplat_drake.scene.mover import Mover, Movers
from remosplat_drake.scene.primitive_scene import Box, PrimitiveScene

DT = 0.1
CONFIG = DetectionCameraConfig(
    translation=[-1.5, 0, 1.3], look_at=[0.6, 0, 1.3]
)


def judged(robot, start: float, wall: tuple[float, float] | None = None):
    """The forearm rises for 3 s to a ball that comes down to 1.4 m.

    Args:
        robot: An arm on a lift.
        start: Height of the ball at first; it comes at 1 m/s [m].
        wall: Lower and upper edge of a wall before the camera; None for none.
    """
    heights = np.linspace(0.0, 0.3, 31)
    q = np.zeros((31, 4))
    q[:, 0] = heights
    u = np.zeros((30, robot.n_u))
    u[:, 0] = 0.1
    time = DT * np.arange(30)

    def movers(at: float) -> Movers:
        z = max(start - at, 1.4)
        v = np.array([0, 0, -1.0 if z > 1.4 else 0.0])
        bounds = {"v_WM": v, "max_speed": 1.0, "max_acceleration": 2.0}
        return Movers(at, [Mover.sphere("ball", [0.6, 0, z], 0.05, **bounds)])

    scene = PrimitiveScene()
    if wall is not None:
        middle, half = 0.5 * (wall[0] + wall[1]), 0.5 * (wall[1] - wall[0])
        X_WP = RigidTransform([-0.5, 0, middle])
        scene = PrimitiveScene(boxes=(Box(X_WP, np.array([0.01, 2, half])),))
    run = WatchedRun(
        robot,
        Trajectory(time, q, u, *3 * [np.ones(30)], timings={}),
        movers,
        placed_cameras([CONFIG], robot, scene, 0),
        least_pixels=3,
        separation=0.05,
        dt=DT,
    )
    found = judge_movers(robot, time, q, movers, DT)
    assert found.worst == TOWARDS
    return run.judged(found).worst


@pytest.mark.parametrize(
    ("wall", "kind"),
    [
        (None, TOWARDS),
        # All of its way is hidden, or its last stretch is.
        ((0.5, 3.0), UNSEEN),
        ((0.5, 1.37), UNSEEN),
        # It has come from behind the wall, but long before it was near.
        ((1.8, 3.0), TOWARDS),
    ],
)
def test_who_could_be_seen_in_time_is_the_robots_fault(lift_arm, wall, kind):
    assert judged(lift_arm, 2.2, wall) == kind
