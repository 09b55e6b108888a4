"""Runs of the closed loop on a planned path."""

import dataclasses as dc

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st
from pydrake.math import RigidTransform

from remosplat_drake.controller.guidance.rollout import REACHED
from remosplat_drake.controller.guidance.selection import (
    Selection,
    start_selection,
)
from remosplat_drake.controller.guidance.selection_round import (
    advance_selection,
)
from remosplat_drake.controller.guidance.selection_rule import SelectionRule
from remosplat_drake.controller.tick.run_tick import run_tick
from remosplat_drake.controller.verification.kernels.between_samples import (
    TOLERANCE,
)
from remosplat_drake.oracle.signed_distance import SignedDistanceField
from remosplat_drake.robot.pose_error import pose_error
from remosplat_drake.scene.primitive_scene import Box, PrimitiveScene

STOPPING = 0.02
DT = 0.02


@dc.dataclass
class Run:
    """A closed loop in the maze, tick by tick.

    Attributes:
        rule: The selector's rule.
        q: Where the arm is.
        u: The command being executed.
        selection: The guidance, and how it was chosen.
        time: Time since the start [s].
        least: Smallest clearance so far, between ticks, too [m].
    """

    rule: SelectionRule
    q: np.ndarray
    u: np.ndarray
    selection: Selection
    time: float = 0.0
    least: float = np.inf

    def tick(self, X_WT, field) -> None:
        law = self.rule.law.with_step(DT)
        self.selection = advance_selection(
            self.rule,
            self.selection,
            time=self.time,
            q=self.q,
            u=self.u,
            aim=X_WT,
            field=field,
            budget=200,
        )
        clearances = field.clearances(law.robot.spheres_at(self.q))
        report = run_tick(
            law,
            self.time,
            self.q,
            X_WT,
            clearances,
            field,
            self.u,
            self.selection.guidance,
        )
        self.u = report.command
        for share in (0.2, 0.4, 0.6, 0.8, 1.0):
            q = law.robot.advance(self.q, self.u, share * DT)
            found = field.clearances(law.robot.spheres_at(q)).minimum()
            self.least = min(self.least, found)
        self.q = q
        self.time += DT

    def arrived(self, X_WT) -> bool:
        X_WE = self.rule.law.robot.end_effector_pose(self.q)
        return self.rule.arrived(pose_error(X_WE, X_WT))


def start(maze, q=None, **settings) -> Run:
    rule = maze.rule(**settings)
    q = maze.q if q is None else q
    return Run(rule, q, np.zeros(3), start_selection(rule))


def drive(run: Run, X_WT, field, seconds: float = 20.0) -> bool:
    end = run.time + seconds
    while run.time < end and not run.arrived(X_WT):
        run.tick(X_WT, field)
    return run.arrived(X_WT)


def test_without_a_plan_the_arm_stays_stuck(maze):
    run = start(maze, enabled=False)
    assert not drive(run, maze.X_WT, maze.field, 5.0)
    assert "stalled" in run.selection.reason


@settings(max_examples=6)
@given(shoulder=st.floats(-1.5, -0.5), elbow=st.floats(-0.5, 0.5))
def test_a_planned_run_arrives_and_keeps_its_distance(maze, shoulder, elbow):
    run = start(maze, np.array([shoulder, elbow, 0.0]))
    assert drive(run, maze.X_WT, maze.field)
    assert run.least >= STOPPING - TOLERANCE
    assert run.selection.guidance.name == "plan"
    assert "plan" in run.selection.reason


def test_what_arrives_directly_waits_for_no_planner(maze):
    q = maze.q_target + np.array([0.3, 0.2, 0.1])
    with_planner, without = start(maze, q), start(maze, q, enabled=False)
    for run in (with_planner, without):
        assert drive(run, maze.X_WT, maze.field)
    assert np.array_equal(with_planner.q, without.q)
    assert with_planner.selection.plans == ()


def test_a_wall_that_appears_starts_a_new_search(maze):
    run = start(maze)
    while run.q[0] < -0.4:
        run.tick(maze.X_WT, maze.field)
    path = run.selection.guidance.path
    assert path is not None
    # Below, where the old path unfolds the forearm; the elbow may still bend
    # the other way.
    wall = Box(RigidTransform([0.25, 0, 0.45]), np.array([0.05, 0.5, 0.05]))
    solids = (*maze.field.scene.boxes, wall)
    walled = SignedDistanceField(PrimitiveScene(boxes=solids))
    arrived = drive(run, maze.X_WT, walled)
    assert run.least >= STOPPING - TOLERANCE
    assert arrived
    assert run.selection.guidance.path is not path


def test_why_nothing_arrives_is_said_once_and_for_all(maze):
    sealed = Box(RigidTransform([0.9, 0, 0.45]), np.array([0.25, 0.5, 0.2]))
    field = SignedDistanceField(
        PrimitiveScene(boxes=(*maze.field.scene.boxes, sealed))
    )
    run = start(maze, attempts=2, seeds=50)
    for _ in range(200):
        run.tick(maze.X_WT, field)
    assert not any(r.status == REACHED for r in run.selection.latest)
    assert run.selection.failures == 2
    assert "too near" in run.selection.unreachable
    assert "20 mm" in run.selection.unreachable
