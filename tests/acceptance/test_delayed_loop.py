"""With a model of its actuators a late robot keeps its distance."""

import dataclasses as dc
import math

import numpy as np
import pytest
from pydrake.math import RigidTransform

from remosplat_drake.acceptance.delayed_loop import DelayedRobot, run_delayed
from remosplat_drake.app.hardware_limits import HARDWARE_SPEED
from remosplat_drake.app.scenario import load_scenario
from remosplat_drake.app.world import load_world, scenario_targets
from remosplat_drake.controller.controller_config import (
    ReactiveControllerConfig,
)
from remosplat_drake.controller.guidance.guidance_config import GuidanceConfig
from remosplat_drake.controller.tick.reactive_law import ReactiveLaw
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


UNMEASURED = {
    "at once": [Actuator()] * 9,
    "late": [Actuator(delay=0.08)] * 2 + [Actuator(delay=0.02)] * 7,
}


def drive(robot, actuators, late, known):
    """Drives a robot towards a target within the wall, true as it is late.

    It is as fast as a real robot is by default.
    """
    config = ReactiveControllerConfig(
        solver="active_set", guidance=GuidanceConfig(enabled=False)
    )
    config.servo.max_speed = HARDWARE_SPEED
    config.velocity_limits.strict = True
    law = ReactiveLaw.make(config, robot, 0.02)
    assert law.collision.stopping == 0.021
    q0 = np.array([0.0, 0, 0, *robot.home])
    X_WT = robot.end_effector_pose(q0)
    X_WT[0, 3] += 1.0  # Within the wall.
    return run_delayed(
        law,
        DelayedRobot(
            robot,
            ActuatorModel.make(actuators),
            q0,
            np.array([late] * 2 + [0.0] * 7),
        ),
        SignedDistanceField(WALL, rows="per_primitive"),
        X_WT,
        ActuatorModel.make(known),
        3.0,
    )


@pytest.mark.parametrize("case", sorted(CASES))
def test_a_late_robot_stays_15_mm_away(frankie, case):
    actuators, late = CASES[case]
    known = [dc.replace(a, tube=0.005, noise=0.002) for a in actuators]
    run = drive(frankie, actuators, late, known)
    assert 0.015 <= run.clearance < 0.2
    # The model is exact, and so is the prediction.
    assert run.share < 0.05


@pytest.mark.parametrize("case", sorted(UNMEASURED))
def test_the_defaults_hold_an_unmeasured_robot(frankie, case):
    assert not frankie.description.actuators
    known = frankie.assumed_actuators
    run = drive(frankie, UNMEASURED[case], 0.0, known)
    assert 0.015 <= run.clearance < 0.2
    assert run.share <= 1


def test_with_wide_tubes_a_robot_still_slides_along_a_table(frankie):
    """A slow base that has to follow the arm around the table's edge."""
    scenario = load_scenario(
        "TableReach",
        "controller: {solver: active_set, guidance: {enabled: false},"
        " servo: {max_speed: 0.35},"
        " velocity_limits: {max_forward: 0.03, strict: true}}",
    )
    world = load_world(scenario)
    law = ReactiveLaw.make(scenario.controller, frankie, 0.02)
    run = run_delayed(
        law,
        DelayedRobot(
            frankie,
            ActuatorModel.make(UNMEASURED["at once"]),
            world.q0,
            np.zeros(9),
        ),
        world.field,
        scenario_targets(scenario, world.truth, [""])[""][0].X_WT,
        ActuatorModel.make(frankie.assumed_actuators),
        20.0,
    )
    assert math.isfinite(run.time)
    assert run.clearance >= law.collision.stopping
