"""The two robots that kinematics are checked with."""

from pathlib import Path

import pytest

from remosplat_drake.robot.robot_model import RobotModel, load_robot

THREE_LINK = Path(__file__).resolve().parents[1] / "data" / "three_link.yaml"


@pytest.fixture(scope="session", params=["frankie", str(THREE_LINK)])
def robot(request) -> RobotModel:
    """Frankie (mobile, with hand) and an arm on a fixed base without hand."""
    return load_robot(request.param)
