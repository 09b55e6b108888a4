"""Fixtures for the whole suite."""

from pathlib import Path

import pytest

from remosplat_drake.kernel_cache import drop_stale_kernels
from remosplat_drake.robot.robot_model import RobotModel, load_robot_model

THREE_LINK = Path(__file__).resolve().parent / "data" / "three_link.yaml"
_SHARED_DATA = Path(__file__).resolve().parents[2] / "shared" / "data"


@pytest.fixture(scope="session")
def shared_data() -> Path:
    """The team's data folder beside the checkout; skips where it is absent."""
    if not _SHARED_DATA.is_dir():
        pytest.skip("needs the data folder ../shared/data beside the checkout")
    return _SHARED_DATA


@pytest.fixture(scope="session")
def frankie() -> RobotModel:
    """The mobile manipulator with its covering spheres, on the floor."""
    return load_robot_model("frankie", floor_height=0.03)


@pytest.fixture(scope="session")
def three_link() -> RobotModel:
    """An arm in the x-z plane on a fixed base, small enough to work by hand."""
    return load_robot_model(THREE_LINK)


def pytest_configure(config):
    # Only the controller of parallel workers, before any of them starts.
    if not hasattr(config, "workerinput"):
        drop_stale_kernels()
