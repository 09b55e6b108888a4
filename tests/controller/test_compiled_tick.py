"""A tick in one compiled call is the tick that is run step by step."""

import dataclasses as dc
from collections import Counter

import numpy as np
import pytest
from asked_in_python import AskedInPython
from random_ticks import some_tick

from remosplat_drake.controller import run_tick as run_tick_module
from remosplat_drake.controller.compiled_tick import settled_tick
from remosplat_drake.controller.controller_config import (
    default_ingredients,
    gain_set,
)
from remosplat_drake.controller.reactive_law import ReactiveLaw
from remosplat_drake.controller.run_tick import run_tick
from remosplat_drake.controller.tick import Tick
from remosplat_drake.controller.tick_inputs import TickInputs
from remosplat_drake.controller.verification.kernels.verified import OBJECTIONS
from remosplat_drake.generation.primitive_surfels import surfel_splat
from remosplat_drake.generation.scene_generators import generate
from remosplat_drake.oracle.composite import CompositeDistanceField
from remosplat_drake.oracle.signed_distance import SignedDistanceField
from remosplat_drake.oracle.sphere_to_ellipsoid import SphereToEllipsoidField
from remosplat_drake.oracle.uncertain_placement import UncertainPlacement
from remosplat_drake.oracle.unknown_space import UnknownSpaceField
from remosplat_drake.robot.robot_model import RobotModel, load_robot
from remosplat_drake.signals.aim import Aim
from remosplat_drake.signals.binding import COLLISION, SELF_COLLISION
from remosplat_drake.signals.distance_field import Clearances, DistanceField
from remosplat_drake.signals.tick_report import (
    ACCELERATION_DROPPED,
    BRAKING,
    OPTIMAL,
    RELAXED,
    TickReport,
)


def some_map(kind: str) -> DistanceField:
    scene = generate("table", 3)
    if kind == "boxes":
        return SignedDistanceField(scene)
    splats = SphereToEllipsoidField(surfel_splat(scene, 3000))
    if kind == "splat":
        return splats
    unseen = np.zeros((16, 16, 16), bool)
    unseen[:, :, 13:] = True
    around = UnknownSpaceField(unseen, np.array([-5.0, -5, -5]), 0.5)
    both = CompositeDistanceField([splats, around])
    return UncertainPlacement(both, np.zeros(2), 0.01, 0.02)


def assert_equal_reports(ours: TickReport, theirs: TickReport):
    np.testing.assert_allclose(ours.command, theirs.command, atol=1e-7)
    for name in ("status", "reason", "scale", "objection"):
        assert getattr(ours, name) == getattr(theirs, name), name
    assert (ours.separation is None) == (theirs.separation is None)
    if ours.separation is not None and theirs.separation is not None:
        least, margins = ours.separation.margin, theirs.separation.margin
        assert least == pytest.approx(margins, abs=1e-6)
    np.testing.assert_array_equal(ours.kept, theirs.kept)
    np.testing.assert_array_equal(ours.tight, theirs.tight)
    np.testing.assert_equal(ours.line_deviation, theirs.line_deviation)
    assert ours.binding.rows == theirs.binding.rows
    np.testing.assert_allclose(ours.binding.A, theirs.binding.A, atol=1e-9)
    np.testing.assert_allclose(
        ours.binding.push, theirs.binding.push, rtol=1e-6, atol=1e-5
    )


def some_tick_of(robot: RobotModel, field: DistanceField, seed: int) -> Tick:
    """Ticks near the scene, ticks without room, and impossible commands."""
    tick = some_tick(robot, seed)
    rng = np.random.default_rng(seed)
    if seed % 3:
        q = robot.q_home + 0.2 * rng.normal(size=robot.n_q)
        q[0] += 0.3 * (seed % 3)
        state = robot.state(q)
        found = field.clearances(state.spheres, 0.5)
        u = np.clip(tick.u_previous, -1, 1)
        tick = dc.replace(tick, state=state, clearances=found, u_previous=u)
    else:
        found = tick.clearances
        less = (0.0, 0.0, 0.05, 0.3)[seed % 4]
        closer = dc.replace(found, distance=found.distance - less)
        tick = dc.replace(tick, clearances=closer)
    if seed % 8 == 7:
        tick = dc.replace(tick, u_previous=np.full(robot.n_u, 50.0))
    return dc.replace(tick, sphere_tube=None)


def reports(
    law: ReactiveLaw, field: DistanceField, tick: Tick
) -> tuple[TickReport | None, TickReport]:
    """The report of the compiled tick, if there is one, and the readable's."""
    given = (tick.time, tick.state.q, tick.aim, tick.clearances)
    also = (tick.u_previous, tick.guidance)
    rest = {"movers": tick.movers}
    compiled = settled_tick(law, TickInputs(*given, field, *also, **rest))
    readable = run_tick(law, *given, AskedInPython(field), *also, **rest)
    if compiled is not None:
        compiled = run_tick(law, *given, field, *also, **rest)
    return compiled, readable


@pytest.mark.parametrize("kind", ["boxes", "splat", "uncertain"])
@pytest.mark.parametrize("strict", [False, True])
@pytest.mark.parametrize("name", ["frankie", "two_arms"])
def test_both_report_the_same(request, kind, strict, name):
    robot = request.getfixturevalue(name)
    config = gain_set("tuned")
    config.velocity_limits.strict = strict
    parts = default_ingredients(robot, config)
    law = ReactiveLaw(robot, parts, solver="active_set")
    field = some_map(kind)
    seen, undecided = Counter(), 0
    for seed in range(150):
        tick = some_tick_of(robot, field, seed)
        ours, theirs = reports(law, field, tick)
        if ours is None:
            undecided += 1
            continue
        assert_equal_reports(ours, theirs)
        seen[theirs.status] += 1
        seen[theirs.objection] += 1
        seen["binds"] += bool(theirs.binding.rows)
    assert undecided < 10
    wanted = {OPTIMAL, RELAXED, "binds", SELF_COLLISION}
    if name == "frankie" and kind != "boxes":
        wanted |= {COLLISION, BRAKING if strict else ACCELERATION_DROPPED}
    assert wanted <= set(seen)


def test_verification_in_one_call_is_that_in_many(frankie):
    """Clarabel's commands are verified so; the law is no kernel's whole."""
    law = ReactiveLaw.make(gain_set("tuned"), frankie, 0.01)
    field, scales = some_map("splat"), Counter()
    for seed in range(200):
        tick = some_tick_of(frankie, field, seed)
        ours, theirs = reports(law, field, tick)
        assert ours is None
        ours = run_tick(
            law,
            tick.time,
            tick.state.q,
            tick.aim,
            tick.clearances,
            field,
            tick.u_previous,
            tick.guidance,
            movers=tick.movers,
        )
        assert_equal_reports(ours, theirs)
        scales[theirs.scale] += 1
        scales[theirs.objection] += 1
    assert set(OBJECTIONS) <= set(scales)
    assert {0.0, 1.0} < set(scales) and len(scales) > len(OBJECTIONS) + 2


def test_a_run_of_ticks_takes_one_call_each(frankie, monkeypatch):
    def refused(*arguments):
        raise AssertionError("a tick was run step by step")

    monkeypatch.setattr(run_tick_module, "tick_by_steps", refused)
    law = ReactiveLaw.make(gain_set("tuned"), frankie, 0.01)
    law = law.with_step(0.01, solver="active_set")
    field, q, u = some_map("splat"), frankie.q_home, np.zeros(frankie.n_u)
    X_WT = frankie.end_effector_pose(q)
    X_WT[0, 3] += 0.5
    for k in range(100):
        found = field.clearances(frankie.spheres_at(q), 0.5)
        u = run_tick(law, 0.01 * k, q, X_WT, found, field, u).command
        q = frankie.advance(q, u, 0.01)
    assert frankie.end_effector_pose(q)[0, 3] > X_WT[0, 3] - 0.45


def test_it_is_left_to_the_steps_what_kernels_do_not_know():
    robot = load_robot("panda")
    law = ReactiveLaw.make(gain_set("tuned"), robot, 0.01)
    fast = law.with_step(0.01, solver="active_set")
    field = some_map("boxes")
    aim = some_tick(robot, 0).aim
    given = (0.0, robot.q_home, aim, Clearances.none())
    still = np.zeros(robot.n_u)
    known = TickInputs(*given, field, still)
    assert settled_tick(fast, known) is not None
    assert settled_tick(law, known) is None
    unknown = TickInputs(*given, AskedInPython(field), still)
    assert settled_tick(fast, unknown) is None
    lost = dc.replace(known, aim=Aim.of(np.full((4, 4), np.nan)))
    assert settled_tick(fast, lost) is None
