"""Movers as simulated cameras around a robot see them."""

import numpy as np
import pytest
from room import CONFIG, FRAME, LEFT, RIGHT, ball, camera, known_room

from remosplat_drake.detection.simulated.simulated_detection import (
    PlacedCamera,
    SimulatedDetection,
)
from remosplat_drake.robot.robot_model import load_robot
from remosplat_drake.scene.mover import Movers

LATE = 0.04


@pytest.fixture(scope="module")
def robot():
    return load_robot("frankie")


def cameras():
    return [
        PlacedCamera(camera("left", 1), lambda q: LEFT, FRAME, LATE),
        PlacedCamera(camera("right", 2), lambda q: RIGHT, FRAME, LATE),
    ]


def test_images_count_after_their_latency(robot):
    detection = SimulatedDetection(cameras(), robot, known_room(), CONFIG)
    q = robot.q_home.copy()
    q[0] -= 0.5
    stamps = []
    for tick in range(60):
        time = 0.01 * tick
        truth = ball([0.3, 0.7 - 0.8 * time, 1.0], [0, -0.8, 0], time=time)
        movers = detection.at(time, q, truth)
        stamps.append(time - movers.stamp)
    assert len(movers)
    assert max(stamps[10:]) < LATE + FRAME / 2 + 0.021
    assert min(stamps[10:]) >= LATE - 1e-9
    assert len(movers.cameras) == 2


def test_the_robot_is_not_among_what_is_seen(robot):
    detection = SimulatedDetection(cameras(), robot, known_room(), CONFIG)
    for tick in range(80):
        time = 0.01 * tick
        q = robot.q_home.copy()
        q[0] += 0.3 * time - 0.4
        q[4] += 0.5 * np.sin(3 * time)
        movers = detection.at(time, q, Movers(time))
        assert not len(movers)
