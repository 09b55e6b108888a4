"""Ticks and rollouts run one tick, and what it asks Python changes nothing."""

import dataclasses as dc
import itertools
from collections import Counter

import numpy as np
import pytest
from asked_in_python import AskedInPython
from effort import effort
from random_ticks import some_tick

from remosplat_drake.controller.controller_config import (
    default_ingredients,
    gain_set,
)
from remosplat_drake.controller.guidance.rollout import (
    Rollout,
    advance_rollout,
)
from remosplat_drake.controller.prediction.history import History
from remosplat_drake.controller.prediction.predict import predict
from remosplat_drake.controller.program.guidance import Guidance
from remosplat_drake.controller.program.tick import Tick
from remosplat_drake.controller.tick.reactive_law import ReactiveLaw
from remosplat_drake.controller.tick.run_tick import run_tick
from remosplat_drake.generation.primitive_surfels import surfel_splat
from remosplat_drake.generation.scene_generators import generate
from remosplat_drake.oracle.composite import CompositeDistanceField
from remosplat_drake.oracle.signed_distance import SignedDistanceField
from remosplat_drake.oracle.sphere_to_ellipsoid import SphereToEllipsoidField
from remosplat_drake.oracle.uncertain_placement import UncertainPlacement
from remosplat_drake.oracle.unknown_space import UnknownSpaceField
from remosplat_drake.robot.actuators import Actuator, ActuatorModel
from remosplat_drake.robot.braking import braking_command
from remosplat_drake.robot.robot_model import RobotModel
from remosplat_drake.signals.binding import COLLISION, SELF_COLLISION
from remosplat_drake.signals.distance_field import Clearances, DistanceField
from remosplat_drake.signals.motion import Motion
from remosplat_drake.signals.side_rows import with_side_rows
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


def report_of(law: ReactiveLaw, field: DistanceField, tick: Tick) -> TickReport:
    return run_tick(
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


def with_sides(tick: Tick, law: ReactiveLaw, field: DistanceField) -> Tick:
    """The rows to all near surfaces that only compiled maps are asked for."""
    near = tick.clearances.within(law.collision.influence)
    stopping = tick.guidance.stopping
    if stopping is None:
        stopping = law.collision.stopping
    near = with_side_rows(near, field, tick.robot, tick.state.q, stopping)
    return dc.replace(tick, clearances=near)


class Nothing:
    """An ingredient from outside that adds nothing."""

    def AddToProgram(self, program, tick) -> None:
        del program, tick


QUICK = {
    ("frankie", False, "splat"),
    ("frankie", True, "boxes"),
    ("frankie", True, "uncertain"),
    ("two_arms", True, "splat"),
}
"""Robots, limits and maps of which few ticks show all that can happen."""


@pytest.mark.parametrize(
    ("name", "strict", "kind"),
    [
        pytest.param(*case, marks=[pytest.mark.slow] * (case not in QUICK))
        for case in itertools.product(
            ("frankie", "two_arms"),
            (False, True),
            ("boxes", "splat", "uncertain"),
        )
    ],
)
def test_it_makes_no_difference_who_is_asked(request, kind, strict, name):
    """Python is asked for the map, and for terms."""
    robot = request.getfixturevalue(name)
    config = gain_set("tuned")
    config.velocity_limits.strict = strict
    parts = default_ingredients(robot, config)
    law = ReactiveLaw(robot, parts, solver="active_set")
    more = ReactiveLaw(robot, [*parts, Nothing()], solver="active_set")
    field = some_map(kind)
    seen = Counter()
    few = 60 if (name, strict, kind) in QUICK else 150
    for seed in range(effort(few, 150)):
        tick = some_tick_of(robot, field, seed)
        ours = report_of(law, field, tick)
        if kind == "uncertain" and ours.status == RELAXED and not ours.scale:
            # Eased programs may want to stand still where something is too
            # near. Whether it is as near as it was depends on rounding.
            continue
        same = with_sides(tick, law, field)
        theirs = report_of(law, AskedInPython(field), same)
        assert_equal_reports(ours, theirs)
        joined = report_of(more, field, tick)
        np.testing.assert_array_equal(joined.command, ours.command)
        assert_equal_reports(ours, joined)
        seen[ours.status] += 1
        seen[ours.objection] += 1
        seen["binds"] += bool(ours.binding.rows)
    wanted = {OPTIMAL, RELAXED, "binds"}
    if name == "frankie" or not strict:
        wanted.add(SELF_COLLISION)
    if name == "frankie" and kind != "boxes":
        wanted |= {COLLISION, BRAKING if strict else ACCELERATION_DROPPED}
    assert wanted <= set(seen)


def test_solvers_come_to_the_same(frankie):
    """But for programs that are so flat that their optimum says little."""
    parts = default_ingredients(frankie, gain_set("tuned"))
    laws = [
        ReactiveLaw(frankie, parts, solver=solver, verify=False)
        for solver in ("active_set", "clarabel")
    ]
    field, near, seen = some_map("splat"), 0, Counter()
    tries = effort(80, 200)
    for seed in range(tries):
        tick = some_tick_of(frankie, field, seed)
        quick, slow = (report_of(law, field, tick) for law in laws)
        assert quick.status == slow.status
        near += np.abs(quick.command - slow.command).max() < 1e-6
        # What a missed twist costs is next to nothing while rows are eased.
        if quick.status != RELAXED:
            np.testing.assert_allclose(quick.command, slow.command, atol=2e-4)
        seen[quick.status] += 1
    assert near > 0.8 * tries
    assert {OPTIMAL, ACCELERATION_DROPPED, RELAXED} <= set(seen)


@pytest.mark.parametrize("late", [False, True])
@pytest.mark.parametrize("outside", [False, True])
def test_a_rollout_s_step_is_the_tick_to_the_last_bit(frankie, late, outside):
    """Of robots that obey at once, and of those that are late."""
    parts = [*default_ingredients(frankie), *[Nothing()] * outside]
    law = ReactiveLaw(frankie, parts, solver="active_set")
    field, statuses = some_map("splat"), Counter()
    for seed in range(effort(40, 100)):
        tick = some_tick_of(frankie, field, seed)
        rng, motion = np.random.default_rng(seed), None
        if late:
            motion = some_motion(frankie, rng, tick.state.q)
            q = motion.q_planned
        else:
            q = tick.state.q
        found = field.clearances(frankie.spheres_at(q), law.collision.influence)
        report = run_tick(
            law,
            tick.time,
            q,
            tick.aim,
            found,
            field,
            tick.u_previous,
            tick.guidance,
            motion,
            tick.movers,
        )
        rollout = Rollout(
            tick.guidance,
            q,
            tick.u_previous,
            movers=tick.movers,
            start=tick.time,
            motion=None if motion is None else motion.arrays,
        )
        after = advance_rollout(
            law, rollout, field, tick.aim, lambda error: False, 99.0
        )
        np.testing.assert_array_equal(after.u, report.command)
        statuses[report.status] += 1
        statuses[report.objection] += 1
        statuses[report.scale] += 1
    assert len(statuses) > 6


class NotesTube:
    """An ingredient from outside that notes how far spheres may be off."""

    def __init__(self):
        self.tubes = []

    def AddToProgram(self, program, tick) -> None:
        self.tubes.append(tick.sphere_tube)


def test_rollouts_tell_how_far_a_late_robot_may_be_off(frankie):
    notes = NotesTube()
    parts = [*default_ingredients(frankie), notes]
    law = ReactiveLaw(frankie, parts, solver="active_set")
    field, q, u = some_map("splat"), frankie.q_home, np.full(9, 0.1)
    X_WT = frankie.end_effector_pose(q)
    motion = some_motion(frankie, np.random.default_rng(0), q)
    run_tick(law, 0.08, q, X_WT, Clearances.none(), field, u, motion=motion)
    start = Rollout(Guidance(), q, u, start=0.08, motion=motion.arrays)
    advance_rollout(law, start, field, X_WT, lambda error: False, 99.0)
    in_tick, in_rollout = notes.tubes
    assert in_tick.max() > 0
    np.testing.assert_array_equal(in_rollout, in_tick)


def some_motion(robot: RobotModel, rng, q: np.ndarray) -> Motion:
    """A robot whose axes are late, after some commands."""
    axes = [Actuator(delay=0.06, tube=0.01)] * robot.n_base
    axes += [
        Actuator(delay=0.01, time_constant=0.05, tube=0.005)
        for _ in range(robot.n_u - robot.n_base)
    ]
    model, history = ActuatorModel.make(axes), History.at_rest(robot.n_u)
    for k in range(8):
        u = rng.uniform(-0.3, 0.3, robot.n_u) * robot.velocity_limit
        history = history.with_command(model, 0.01 * k, u)
    stamp = np.full(robot.n_u, 0.07)
    return predict(robot, model, history, q, stamp, 0.08)


def test_a_rollout_of_a_late_robot_is_what_comes(frankie):
    """Its later motions are those that the predictor would find."""
    law = ReactiveLaw(
        frankie, default_ingredients(frankie), 0.05, solver="active_set"
    )
    field = some_map("boxes")
    q0 = frankie.q_home
    X_WT = frankie.end_effector_pose(q0)
    X_WT[0, 3] += 0.4
    axes = [Actuator(delay=0.052, tube=0.01)] * 2
    axes += [Actuator(delay=0.01, time_constant=0.05, tube=0.005)] * 7
    model, history = ActuatorModel.make(axes), History.at_rest(9)
    still = np.zeros(9)
    motion = predict(frankie, model, history, q0, np.zeros(9), 0.0)
    rollout = Rollout(Guidance(), q0, still, motion=motion.arrays)
    measured = q0
    for k in range(10):
        rollout = advance_rollout(
            law, rollout, field, X_WT, lambda error: False, 99.0
        )
        now = 0.05 * (k + 1)
        history = history.with_command(model, now - 0.05, rollout.u)
        # What is measured is what the model says, from the beginning on.
        motion = predict(frankie, model, history, measured, np.zeros(9), now)
        later = rollout.motion.values
        assert later.start == pytest.approx(motion.start)
        np.testing.assert_allclose(later.v_start, motion.v_start, atol=1e-9)
        np.testing.assert_allclose(later.q_start, motion.q_start, atol=2e-3)
        np.testing.assert_allclose(rollout.q, motion.q_planned, atol=2e-3)
    assert np.abs(rollout.q - q0).max() > 0.02


def test_what_is_not_known_makes_the_robot_brake(frankie):
    law = ReactiveLaw.make(gain_set("tuned"), frankie, 0.01)
    field, u = some_map("boxes"), np.full(9, 0.1)
    q, X_WT = frankie.q_home, frankie.end_effector_pose(frankie.q_home)
    lost = np.full((4, 4), np.nan)
    unknown = Clearances.unknown(len(frankie.spheres))
    for given, reason in (
        ((q * np.nan, X_WT, Clearances.none()), "configuration"),
        ((q, X_WT, unknown), "clearances"),
        ((q, lost, Clearances.none()), "target"),
    ):
        report = run_tick(law, 0.0, *given, field, u)
        assert report.status == BRAKING
        assert reason in report.reason and "not finite" in report.reason
        ramp = braking_command(u, frankie.acceleration_limit, 0.01)
        np.testing.assert_array_equal(report.command, ramp)
