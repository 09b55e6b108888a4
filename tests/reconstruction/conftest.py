"""A small scene and a capture of it."""

import numpy as np
import pytest
from pydrake.math import RigidTransform

from remosplat_drake.reconstruction.synthetic_capture import (
    render_capture,
    survey_poses,
)
from remosplat_drake.scene.primitive_scene import Box, Cylinder, PrimitiveScene

SCENE = PrimitiveScene(
    boxes=(Box(RigidTransform([1, 0, 0.4]), np.array([0.3, 0.4, 0.03])),),
    cylinders=(Cylinder(RigidTransform([0.8, 0.1, 0.6]), 0.05, 0.2),),
    X_WE_target=RigidTransform([1, 0, 0.6]),
).with_floor()


@pytest.fixture(scope="session")
def scene() -> PrimitiveScene:
    return SCENE


@pytest.fixture(scope="session")
def scene_capture(scene):
    return render_capture(scene, survey_poses(scene, n=12), 120, 90)
