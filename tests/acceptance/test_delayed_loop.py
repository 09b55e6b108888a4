"""With a model of its actuators a late robot keeps its distance."""

import dataclasses as dc

import numpy as np
import pytest
from pydrake.math import RigidTransform

from remosplat_drake.acceptance.delayed_loop import DelayedRobot, run_delayed
from remosplat_drake.controller.controller_config import (
    ReactiveControllerConfig,
)
from remosplat_drake.controller.guidance.guidance_config import GuidanceConfig
from remosplat_drake.controller.reactive_law import ReactiveLaw
from remosplat_drake.oracle.signed_distance import SignedDistanceField
from remosplat_drake.robot.actuators import (
    Actuator,
    ActuatorModel,
    panda_py_actuators,
)
from remosplat_drake.scene.primitive_scene import Box, PrimitiveScene

WALL = PrimitiveScene(
    boxes=(Box(RigidTransform([1.6, 0.3, 0.5]), np.array([0.4, 1.0, 1.0])),)
)
CASES = {
    "150/50": ([Actuator(delay=0.15)] * 2 + [Actuator()] * 7, 0.05),
    "250/100": ([Actuator(delay=0.25)] * 2 + [Actuator()] * 7, 0.1),
    "panda-py": ([Actuator()] * 2 + panda_py_actuators(), 0.0),
}


@pytest.mark.parametrize("case", sorted(CASES))
def test_a_late_robot_stays_15_mm_away(frankie, case):
    actuators, late = CASES[case]
    law = ReactiveLaw.make(
        ReactiveControllerConfig(
            solver="active_set", guidance=GuidanceConfig(enabled=False)
        ),
        frankie,
        0.02,
    )
    q0 = np.array([0.0, 0, 0, *frankie.home])
    X_WT = frankie.end_effector_pose(q0)
    X_WT[0, 3] += 1.0  # Within the wall.
    known = [dc.replace(a, tube=0.005, noise=0.002) for a in actuators]
    run = run_delayed(
        law,
        DelayedRobot(
            frankie,
            ActuatorModel.make(actuators),
            q0,
            np.array([late] * 2 + [0.0] * 7),
        ),
        SignedDistanceField(WALL, rows="per_primitive"),
        X_WT,
        ActuatorModel.make(known),
        3.0,
    )
    assert law.collision.stopping == 0.021
    assert 0.015 <= run.clearance < 0.2
    # The model is exact, and so is the prediction.
    assert run.share < 0.05
