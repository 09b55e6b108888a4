"""Given velocities go through the gate of every run: verified, supervised."""

import numpy as np
import pytest
from pydrake.systems.analysis import Simulator

from remosplat_drake.app.diagram import Application
from remosplat_drake.app.run_readings import supervision_of
from remosplat_drake.app.scenario import load_scenario
from remosplat_drake.app.velocity_run import (
    LATEST_ARM,
    LATEST_BASE,
    build_velocity_run,
)
from remosplat_drake.app.world import World, load_world
from remosplat_drake.controller.verification.kernels.between_samples import (
    TOLERANCE,
)
from remosplat_drake.controller.verification.self_sweep import SelfClearance
from remosplat_drake.recording.trajectory import Trajectory
from remosplat_drake.signals.supervisor_state import RUNNING

DT = 0.01


def made(scenario_text: str = "") -> tuple[Application, World]:
    """A simulated run, and its world."""
    scenario = load_scenario("TableGroundTruth", scenario_text)
    scenario.controller.velocity_limits.acceleration = True
    scenario.controller.velocity_limits.strict = True
    world = load_world(scenario)
    return build_velocity_run(scenario, world, hardware=False), world


def played(application: Application, u: np.ndarray) -> Trajectory:
    simulator = Simulator(application.diagram)
    root = simulator.get_mutable_context()
    simulator.AdvanceTo(2 * DT)
    profile = application.targets
    profile.play(profile.GetMyMutableContextFromRoot(root), u)
    simulator.AdvanceTo((len(u) + 3) * DT)
    state = supervision_of(application, root)
    assert state is not None and state.mode == RUNNING, state
    recorder = application.recorder
    return recorder.trajectory(recorder.GetMyContextFromRoot(root))


def ramp(n_u: int, axis: int, speed: float, step: float, ticks: int):
    """Up to a speed that is held, shape (ticks, n_u)."""
    u = np.zeros((ticks, n_u))
    line = np.minimum(step * np.arange(1, ticks + 1), abs(speed))
    u[:, axis] = np.copysign(line, speed)
    return u


def test_with_room_around_an_axis_moves_as_told_and_no_other():
    application, world = made()
    robot, axis = world.robot, 8
    step = 0.9 * robot.acceleration_limit[axis] * DT
    u = ramp(robot.n_u, axis, -1.0, step, 40)
    found = played(application, u)
    assert (found.scale == 1.0).all()
    start = int(np.argmax(np.abs(found.u[:, axis]) > 1e-9))
    np.testing.assert_allclose(found.u[start : start + 38], u[:38], atol=1e-6)


@pytest.mark.parametrize("late", [False, True])
def test_a_base_that_is_sent_into_the_table_comes_to_rest_before_it(late):
    """The map stands in the way of velocities as it does of targets."""
    application, world = made()
    robot = world.robot
    if late:
        n_arm = robot.n_u - robot.n_base
        robot.description.actuators = [
            *[LATEST_BASE] * robot.n_base,
            *[LATEST_ARM] * n_arm,
        ]
        scenario = load_scenario("TableGroundTruth")
        scenario.controller.velocity_limits.strict = True
        application = build_velocity_run(scenario, world, hardware=False)
    step = 0.9 * robot.acceleration_limit[0] * DT
    found = played(application, ramp(robot.n_u, 0, 0.5, step, 300))
    assert found.scale.min() < 1.0
    clear = [
        world.truth_field.clearances(robot.spheres_at(q)).minimum()
        for q in found.q
    ]
    stopping = application.law.collision.stopping
    assert min(clear) >= stopping - TOLERANCE
    # It has driven, and far enough to be stopped by nothing else.
    assert np.ptp(found.q[:, 0]) > 0.05
    assert abs(found.u[-1, 0]) < 1e-3


def test_an_elbow_that_is_folded_into_the_arm_comes_to_rest_before_it():
    application, world = made()
    robot = world.robot
    own = SelfClearance.make(robot, application.law.self_clearance.stopping)
    axis = 5
    step = 0.9 * robot.acceleration_limit[axis] * DT
    found = played(application, ramp(robot.n_u, axis, -1.5, step, 300))
    apart = [own.distances(q, own.stopping).min() for q in found.q]
    assert min(apart) >= own.stopping - TOLERANCE
    lower = robot.position_lower[robot.n_q - 7 + 3]
    assert found.q[:, robot.n_q - 7 + 3].min() >= lower
    assert abs(found.u[-1, axis]) < 1e-3
