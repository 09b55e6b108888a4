"""Movers that may come out of hiding, against those that do."""

import numpy as np
import pytest
from room import FRAME, LEFT, RIGHT, ROOM, SIZE, K, Watch, known_room, looking

from remosplat_drake.detection.detection_config import DetectionConfig
from remosplat_drake.detection.simulated.simulated_camera import SimulatedCamera
from remosplat_drake.detection.unseen_space import (
    MOST_BOXES,
    NEAR,
    RADIUS,
    UNSEEN,
    _boxes,
)
from remosplat_drake.robot.sphere_model import Spheres
from remosplat_drake.scene.mover import Mover, Movers

SPEED = 0.8
CONFIG = DetectionConfig(unseen_speed=SPEED)
ROBOT = Spheres.at(np.array([[0.2, 0.0, 1.0]]), 0.1)


def reach_of(movers: Movers, p_W: np.ndarray, time: float) -> float:
    """How far a point is from where hidden balls' centres may be at a time."""
    apart = []
    for mover in movers:
        off = np.abs(p_W - mover.X_WM.translation()) - mover.half_extents
        away = np.linalg.norm(np.maximum(off, 0.0))
        since = SPEED * (time - movers.stamp) + mover.position_error
        apart.append(away - since)
    return min(apart, default=np.inf)


@pytest.mark.parametrize("seed", [0, 1])
def test_whatever_hides_is_where_it_may_be(seed):
    rng = np.random.default_rng(seed)
    watch = Watch([LEFT], known_room(CONFIG), CONFIG, ROBOT)
    eye = SimulatedCamera("eye", K, SIZE, ROOM)
    p_W, near, time = np.array([0.9, 0.6, 0.12]), 0, 0.0
    goal = ROBOT.p_WS[0]

    def is_seen(p_W: np.ndarray) -> bool:
        ball = Movers(time, [Mover.sphere("ball", p_W, RADIUS)])
        return bool(eye.take(LEFT, time, ball, ROBOT).pixels[0])

    assert not is_seen(p_W)
    for tick in range(150):
        time = FRAME * tick
        _, movers = watch.see(time)
        for _ in range(10):
            # It likes to come nearer, and is never seen.
            step = rng.normal(size=3) + (goal - p_W)
            step *= SPEED * FRAME / np.linalg.norm(step)
            inside = np.linalg.norm(p_W + step - goal) < 0.1 + RADIUS
            if not inside and not is_seen(p_W + step):
                p_W = p_W + step
                break
        if np.linalg.norm(p_W - goal) < NEAR and time > 0.2:
            near += 1
            assert reach_of(movers, p_W, time + FRAME) <= 1e-9
    assert near > 20


def test_a_robot_that_is_seen_all_round_hides_no_mover():
    behind = looking([1.6, 0.0, 1.8], [0.2, 0, 1.0])
    above = looking([0.2, 0.01, 2.3], [0.2, 0, 1.0])
    poses = [LEFT, RIGHT, behind, above]
    watch = Watch(poses, known_room(CONFIG), CONFIG, ROBOT)
    for tick in range(80):
        _, movers = watch.see(0.25 * FRAME * tick, which=tick % 4)
    assert reach_of(movers, ROBOT.p_WS[0], movers.stamp) > 0.3
    # With one camera only, a person may stand behind it.
    watch = Watch([LEFT], known_room(CONFIG), CONFIG, ROBOT)
    for tick in range(60):
        _, movers = watch.see(FRAME * tick)
    assert reach_of(movers, ROBOT.p_WS[0], movers.stamp) < 0.2
    assert {mover.name for mover in movers} == {UNSEEN}


def test_nothing_hides_unless_it_is_wanted():
    watch = Watch([LEFT], spheres=ROBOT)
    _, movers = watch.see(0.0)
    assert not len(movers)


@pytest.mark.parametrize("share", [0.0, 0.02, 0.5, 0.97, 1.0])
def test_boxes_hold_the_voxels_and_are_few(share):
    rng = np.random.default_rng(3)
    voxels = np.argwhere(rng.uniform(size=(20, 14, 9)) < share)
    lower, upper = _boxes(voxels)
    assert len(lower) <= MOST_BOXES
    held = (lower[:, None] <= voxels) & (voxels < upper[:, None])
    assert held.all(axis=2).any(axis=0).all()
    if share == 1.0:
        assert len(lower) == 1
    # Few voxels are held by themselves and by nothing larger.
    lower, upper = _boxes(voxels[:50])
    assert np.prod(upper - lower, axis=1).sum() == len(voxels[:50])
