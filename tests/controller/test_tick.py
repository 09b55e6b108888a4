"""One tick: what it reports, and what it does with unusable measurements."""

import dataclasses as dc

import numpy as np
import pytest
from pydrake.math import RigidTransform

from remosplat_drake.controller.controller_config import gain_set
from remosplat_drake.controller.tick.reactive_law import ReactiveLaw
from remosplat_drake.controller.tick.run_tick import run_tick
from remosplat_drake.oracle.signed_distance import SignedDistanceField
from remosplat_drake.scene.primitive_scene import Box, PrimitiveScene
from remosplat_drake.signals import tick_report
from remosplat_drake.signals.distance_field import Clearances
from remosplat_drake.signals.tick_report import TickReport

DT = 0.02
WALL = PrimitiveScene(
    boxes=(Box(RigidTransform([1.2, 0, 1]), np.array([0.1, 2, 1])),)
)


@pytest.fixture(scope="module")
def law(frankie) -> ReactiveLaw:
    return ReactiveLaw.make(gain_set("tuned"), frankie, DT)


@pytest.fixture
def inputs(frankie) -> dict:
    """Frankie at home, 1.1 m before a wall, with a target on the way."""
    q = np.array([0, 0, 0, *frankie.home])
    field = SignedDistanceField(WALL)
    X_WT = frankie.end_effector_pose(q)
    X_WT[0, 3] += 0.2
    return {
        "time": 1.5,
        "q": q,
        "aim": X_WT,
        "clearances": field.clearances(frankie.spheres_at(q), 0.5),
        "field": field,
        "u_previous": np.zeros(frankie.n_u),
    }


def test_the_report_says_what_was_seen_and_decided(law, inputs):
    report = run_tick(law, **inputs)
    assert report.status == tick_report.OPTIMAL
    assert report.reason == ""
    assert report.scale == 1.0
    assert report.time == 1.5
    assert report.clearances is inputs["clearances"]
    assert len(report.kept) == len(report.tight) == len(report.clearances) > 0
    assert not (report.tight & ~report.kept).any()
    assert set(report.timings) == {"solve", "tick"}
    step = law.robot.acceleration_limit * DT
    assert (np.abs(report.command) <= step + 1e-7).all()
    assert report.command[0] > 0


def test_equal_inputs_give_equal_commands(law, inputs):
    first, second = (run_tick(law, **inputs).command for _ in range(2))
    np.testing.assert_array_equal(first, second)


def test_rows_beyond_the_influence_are_not_used(law, inputs, frankie):
    field = inputs["field"]
    everything = field.clearances(frankie.spheres_at(inputs["q"]))
    near = run_tick(law, **inputs)
    far = run_tick(law, **{**inputs, "clearances": everything})
    assert len(everything) > len(inputs["clearances"])
    assert len(far.clearances) == len(near.clearances)
    np.testing.assert_array_equal(near.command, far.command)


def test_tight_rows_are_the_ones_that_stop_the_robot(law, inputs, frankie):
    # The target is inside the wall; pushing on ends with tight rows.
    inputs["aim"][0, 3] = 1.2
    field = inputs["field"]
    for _ in range(200):
        inputs["clearances"] = field.clearances(
            frankie.spheres_at(inputs["q"]), 0.5
        )
        report = run_tick(law, **inputs)
        inputs["q"] = frankie.advance(inputs["q"], report.command, DT)
        inputs["u_previous"] = report.command
    assert report.tight.any()
    assert report.clearances.minimum() >= law.collision.stopping
    assert report.clearances.distance[report.tight].min() < 0.03


def bad_clearances(name: str, value: float) -> Clearances:
    arrays = {
        "sphere": np.array([0, 1]),
        "distance": np.array([0.3, 0.3]),
        "direction_W": np.array([[1.0, 0, 0], [1.0, 0, 0]]),
        "p_WC": np.zeros((2, 3)),
    }
    arrays[name][1] = value
    return Clearances(**arrays)


@pytest.mark.parametrize(
    ("name", "value", "reason"),
    [
        ("q", np.full(10, np.nan), "measured configuration"),
        ("q", np.array([np.inf] + [0.0] * 9), "measured configuration"),
        ("aim", np.full((4, 4), np.nan), "target"),
        ("aim", np.diag([1.0, 1, np.inf, 1]), "target"),
        ("clearances", bad_clearances("distance", np.nan), "clearances"),
        ("clearances", bad_clearances("distance", -np.inf), "clearances"),
        ("clearances", bad_clearances("direction_W", np.nan), "clearances"),
        ("clearances", Clearances.unknown(5), "clearances"),
    ],
)
def test_unusable_measurements_brake_with_a_reason(
    law, inputs, name, value, reason
):
    u = np.array([0.4, 0.1, *[0.1] * 7])
    report = run_tick(law, **{**inputs, name: value, "u_previous": u})
    assert report.status == tick_report.BRAKING
    assert report.reason.startswith(reason)
    assert report.reason.endswith("not finite")
    # The base needs longest: 1 m/s^2 from 0.4 m/s.
    np.testing.assert_allclose(report.command, u * (0.4 - DT) / 0.4)


def test_the_braking_ramp_ends_at_a_standstill(law, inputs):
    u = np.array([0.1, -0.5, *[0.3] * 7])
    inputs["aim"] = np.full((4, 4), np.nan)
    step = law.robot.acceleration_limit * DT
    for _ in range(100):
        report = run_tick(law, **{**inputs, "u_previous": u})
        assert (np.abs(report.command - u) <= step + 1e-12).all()
        u = report.command
        if not u.any():
            break
    np.testing.assert_array_equal(u, 0)
    assert report.status == tick_report.BRAKING


def test_a_bad_target_ends_at_a_standstill_before_the_wall(
    law, inputs, frankie
):
    """From full speed, with just the room that verification had left."""
    field, q = inputs["field"], inputs["q"]
    stopping = law.collision.stopping
    gap = field.clearances(frankie.spheres_at(q)).minimum()
    # The ramp from 0.5 m/s at 1 m/s^2 takes less than 0.125 m.
    q[0] += gap - stopping - 0.125
    u = np.array([0.5] + [0.0] * 8)
    while u.any():
        clearances = field.clearances(frankie.spheres_at(q), 0.5)
        nowhere = np.full((4, 4), np.nan)
        report = run_tick(law, 0.0, q, nowhere, clearances, field, u)
        assert report.status == tick_report.BRAKING
        u = report.command
        q = frankie.advance(q, u, DT)
        assert field.clearances(frankie.spheres_at(q)).minimum() >= stopping


def test_verification_can_be_switched_off(frankie, inputs):
    config = dc.replace(gain_set("tuned"), verify=False)
    law = ReactiveLaw.make(config, frankie, DT)

    class Untouchable(SignedDistanceField):
        def clearances(self, spheres, max_distance=np.inf):
            raise AssertionError("asked although verification is off")

    inputs["field"] = Untouchable(WALL)
    assert run_tick(law, **inputs).scale == 1.0


def test_before_the_first_tick_the_robot_is_told_to_stand(frankie):
    report = TickReport.before_first(frankie.n_q, frankie.n_u)
    assert np.isnan(report.time)
    assert report.status == tick_report.BRAKING
    np.testing.assert_array_equal(report.command, np.zeros(frankie.n_u))
