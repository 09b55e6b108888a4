"""Numbers about runs that were made by hand."""

import numpy as np
import pytest
from pydrake.math import RigidTransform

from remosplat_drake.oracle.signed_distance import SignedDistanceField
from remosplat_drake.recording.metrics import path_length, run_metrics
from remosplat_drake.recording.trajectory import Trajectory
from remosplat_drake.scene.primitive_scene import Box, PrimitiveScene

DT = 0.1


def trajectory_of(q, *, n_u: int, **fields) -> Trajectory:
    q = np.array(q, float)
    ticks = len(q) - 1
    values = {
        "time": DT * np.arange(ticks),
        "q": q,
        "u": np.zeros((ticks, n_u)),
        "status": np.full(ticks, "optimal"),
        "scale": np.ones(ticks),
        "clearance": np.full(ticks, np.inf),
        "timings": {},
    }
    return Trajectory(**{**values, **fields})


def drive_forward(robot, distance: float) -> list:
    """Straight ahead in two equal steps."""
    return [[x, 0, 0, *robot.home] for x in distance * np.array([0, 0.5, 1])]


def test_the_length_of_a_polyline():
    assert path_length(np.array([[0, 0], [3, 4], [3, 5.0]])) == 6
    assert path_length(np.zeros((1, 2))) == 0


def test_a_straight_drive(frankie):
    q = drive_forward(frankie, 0.4)
    metrics = run_metrics(trajectory_of(q, n_u=9), frankie, DT, None)
    assert metrics.ticks == 2
    assert metrics.duration == pytest.approx(0.2)
    assert metrics.path_length == pytest.approx(0.4)
    assert metrics.base_path_length == pytest.approx(0.4)


def test_turning_on_the_spot_moves_the_hand_alone(frankie):
    q = [[0, 0, yaw, *frankie.home] for yaw in np.linspace(0, 0.5, 101)]
    metrics = run_metrics(trajectory_of(q, n_u=9), frankie, DT, None)
    p_WE = frankie.end_effector_pose(np.array(q[0]))[:3, 3]
    arc = 0.5 * np.hypot(p_WE[0], p_WE[1])
    assert metrics.base_path_length == 0
    assert metrics.path_length == pytest.approx(arc, rel=1e-4)


def test_an_arm_without_base_drives_nowhere(three_link):
    q = [[0, 0, 0], [0.1, 0, 0]]
    metrics = run_metrics(trajectory_of(q, n_u=3), three_link, DT, None)
    assert metrics.base_path_length == 0
    assert metrics.path_length > 0


def test_true_clearances_include_where_the_run_ended(frankie):
    # A wall 2 m ahead: what is foremost at home stays foremost.
    wall = Box(RigidTransform([2.5, 0, 1]), np.array([0.5, 3, 3]))
    truth = SignedDistanceField(PrimitiveScene(boxes=(wall,)))
    q = drive_forward(frankie, 0.4)
    start = truth.clearances(frankie.spheres_at(np.array(q[0]))).minimum()
    metrics = run_metrics(trajectory_of(q, n_u=9), frankie, DT, truth)
    assert metrics.truth_clearance_min == pytest.approx(start - 0.4)
    assert metrics.truth_clearance_mean == pytest.approx(start - 0.2)


def test_without_truth_nothing_is_claimed(frankie):
    q = drive_forward(frankie, 0.4)
    metrics = run_metrics(trajectory_of(q, n_u=9), frankie, DT, None)
    assert metrics.truth_clearance_min is None
    assert metrics.truth_clearance_mean is None


def test_clearances_beyond_the_influence_do_not_count(frankie):
    q = drive_forward(frankie, 0.4)
    seen = np.array([0.3, np.inf])
    metrics = run_metrics(
        trajectory_of(q, n_u=9, clearance=seen), frankie, DT, None
    )
    assert metrics.clearance_min == metrics.clearance_mean == 0.3
    metrics = run_metrics(trajectory_of(q, n_u=9), frankie, DT, None)
    assert metrics.clearance_min is None


def test_times_and_fallbacks_are_counted(frankie):
    q = [[0, 0, 0, *frankie.home]] * 5
    metrics = run_metrics(
        trajectory_of(
            q,
            n_u=9,
            status=np.array(["optimal", "relaxed", "optimal", "braking"]),
            scale=np.array([1.0, 0.5, 0.0, 1.0]),
            timings={"total": np.array([0.001, 0.002, 0.003, 0.002])},
        ),
        frankie,
        DT,
        None,
    )
    assert metrics.statuses == {"braking": 1, "optimal": 2, "relaxed": 1}
    assert metrics.scaled_ticks == 2
    assert metrics.tick_p50 == pytest.approx(0.002)
    assert 0.0029 < metrics.tick_p99 <= 0.003
    assert metrics.control_rate == pytest.approx(500)


def test_a_run_without_a_tick_has_numbers_too(frankie):
    q = [[0, 0, 0, *frankie.home]]
    metrics = run_metrics(trajectory_of(q, n_u=9), frankie, DT, None)
    assert metrics.ticks == 0
    assert metrics.duration == metrics.path_length == metrics.tick_p50 == 0
    assert metrics.control_rate == 0
    assert metrics.clearance_mean is None


def test_only_ticks_on_a_line_can_be_beside_it(frankie):
    q = [[0, 0, 0, *frankie.home]] * 4
    trajectory = trajectory_of(q, n_u=9)
    beside = [np.nan, 0.001, 0.003]
    metrics = run_metrics(trajectory, frankie, DT, None, line_deviation=beside)
    assert metrics.line_deviation_max == 0.003
    assert metrics.line_deviation_mean == 0.002
    metrics = run_metrics(trajectory, frankie, DT, None)
    assert metrics.line_deviation_max is None


def test_the_least_margin_counts_of_what_was_known_to_move(frankie):
    trajectory = trajectory_of([[0, 0, 0, *frankie.home]] * 3, n_u=9)
    margins = [np.nan, 0.1, -0.05]
    metrics = run_metrics(
        trajectory, frankie, DT, None, separation_margin=margins
    )
    assert metrics.separation_margin_min == -0.05
    metrics = run_metrics(
        trajectory, frankie, DT, None, separation_margin=[np.nan] * 3
    )
    assert metrics.separation_margin_min is None
