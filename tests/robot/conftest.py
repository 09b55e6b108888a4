"""The robots that kinematics are checked with."""

from pathlib import Path

import pytest

from remosplat_drake.robot.robot_description import shipped_robots
from remosplat_drake.robot.robot_model import RobotModel, load_robot

THREE_LINK = Path(__file__).resolve().parents[1] / "data" / "three_link.yaml"


@pytest.fixture(scope="session", params=[*shipped_robots(), str(THREE_LINK)])
def robot(request) -> RobotModel:
    """All that are shipped, and an arm of three joints that are askew."""
    return load_robot(request.param)
