"""A scene that the tests of this folder share."""

import pytest

from remosplat_drake.generation.scene_generators import generate
from remosplat_drake.scene.primitive_scene import PrimitiveScene


@pytest.fixture(scope="session")
def table_scene() -> PrimitiveScene:
    return generate("table", 1)
