"""A page for each test, and eyes and a finger for it."""

import struct
from collections.abc import Callable

import numpy as np
import page_messages
import pytest
from pydrake.geometry import Meshcat

from remosplat_drake.robot.robot_model import RobotModel, load_robot
from remosplat_drake.visualization import drawn_plant
from remosplat_drake.visualization.page import MeshcatPage


@pytest.fixture
def page() -> MeshcatPage:
    return MeshcatPage()


@pytest.fixture
def without_meshes(monkeypatch):
    """As where neither the meshes nor the extra are installed."""
    monkeypatch.setattr(drawn_plant, "link_meshes", lambda visuals: {})
    drawn_plant.drawn_plant.cache_clear()
    yield
    drawn_plant.drawn_plant.cache_clear()


@pytest.fixture(scope="session")
def frankie() -> RobotModel:
    return load_robot("frankie")


@pytest.fixture
def click() -> Callable[[Meshcat, str], None]:
    """Clicks a button as the browser would."""
    return page_messages.click


@pytest.fixture
def is_visible(page) -> Callable[[Meshcat, str], bool]:
    """Reads a path's own visibility (true unless set)."""

    def _is_visible(meshcat: Meshcat, path: str) -> bool:
        page.scene.settle()
        packed = meshcat._GetPackedProperty(path, "visible")
        assert packed[-1:] in (b"", b"\xc2", b"\xc3")
        return packed[-1:] != b"\xc2"

    return _is_visible


@pytest.fixture
def pose_of(page) -> Callable[[Meshcat, str], np.ndarray]:
    """Reads a path's transform in its parent, a 4x4 matrix."""

    def _pose_of(meshcat: Meshcat, path: str) -> np.ndarray:
        page.scene.settle()
        packed = meshcat._GetPackedTransform(path)
        # MessagePack: 16 doubles of 9 bytes each, column by column, at the end.
        numbers = struct.unpack(">" + 16 * "xd", packed[-16 * 9 :])
        return np.array(numbers).reshape(4, 4).T

    return _pose_of
