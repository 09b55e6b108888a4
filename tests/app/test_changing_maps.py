"""A driving robot, and a map that leaves it no way to stop."""

import dataclasses as dc
from pathlib import Path

import numpy as np
import pytest
from pydrake.math import RigidTransform

from apps.studies.live_map.session import LiveSession
from remosplat_drake.app.run_readings import supervision_of
from remosplat_drake.app.scenario import load_scenario
from remosplat_drake.app.world import load_world
from remosplat_drake.controller.map_change import NO_WAY_TO_STOP, objection
from remosplat_drake.mapping.live_map_memory import (
    LiveMapMemory,
    changed,
    located,
    taken_back,
)
from remosplat_drake.mapping.map_status import first_status
from remosplat_drake.oracle.signed_distance import SignedDistanceField
from remosplat_drake.scene.primitive_scene import Box, PrimitiveScene
from remosplat_drake.signals.base_correction import BaseCorrection
from remosplat_drake.signals.base_estimate import BaseEstimate, Drift
from remosplat_drake.signals.scene_map import SceneMap
from remosplat_drake.signals.supervisor_state import STOPPED

ALONE = "{controller: {guidance: {enabled: false}}, mapping: {latency: 0.5}}"
"""What the mapping process says of its start, and when, changes nothing."""

ROOM = 0.03
"""From the foremost sphere to the wall [m]: more than the robot keeps, and less
than it needs to stop."""


@pytest.mark.usefixtures("open3d")
def test_the_robot_brakes_before_such_a_map_counts(tmp_path: Path):
    scenario = load_scenario("TableTeleop", ALONE)
    world = load_world(scenario)
    with LiveSession(scenario, world, tmp_path / "session") as live:
        application, root = live._application, live._root
        live_map = application.live_map
        assert live_map is not None
        context = live_map.GetMyMutableContextFromRoot(root)
        while not (live.reports and live.reports[-1].command[0] > 0.15):
            live.time += 4.0  # The next pose, at once.
            live.move_on()
            live.tick()
            assert live.time < 20
        q, u = live.reports[-1].q, live.reports[-1].command
        spheres = world.robot.spheres_at(q)
        front = (spheres.p_WS[:, 0] + spheres.radius).max()
        middle = RigidTransform([front + ROOM + 0.5, 0, 1])
        wall = Box(middle, np.array([0.5, 4.0, 4.0]))
        field = SignedDistanceField(PrimitiveScene(boxes=(wall,)))
        assert objection(application.law, field, q, u)

        before = live.status.scene_map
        new = SceneMap(before.version + 1, 0, (), 0.0, field)
        cell = context.get_mutable_abstract_state(int(live_map._memory_index))
        memory = dc.replace(
            cell.get_value(), candidate=(new, BaseCorrection(version=1))
        )
        cell.set_value(memory)
        held = 0
        while live.status.scene_map is before and held < 200:
            live.tick()
            held += 1
        assert held > 2
        executed = application.executed
        system = executed.get_system().GetMyContextFromRoot(root)
        assert np.abs(executed.Eval(system)).max() < 0.02
        live.tick()
        supervision = supervision_of(application, root)
        assert supervision is not None and supervision.mode == STOPPED
        assert supervision.reason.startswith(NO_WAY_TO_STOP)
        assert live.status.scene_map is new
        # The ramp led nearer to the wall than the way had been to it, and the
        # old map had nothing against that.
        q = live.reports[-1].q
        distance = field.clearances(world.robot.spheres_at(q)).minimum()
        assert 0 < distance < ROOM


def estimate(x: float, time: float) -> BaseEstimate:
    """A base that is ahead of its odometry."""
    first = BaseEstimate.first(time, np.zeros(3), Drift(0.0, 0.0))
    return dc.replace(first, X_WB=np.array([x, 0, 0]))


def test_map_and_pose_change_together():
    old = SceneMap(1, 0, (), 0.0, SignedDistanceField(PrimitiveScene()))
    new = dc.replace(old, version=2)
    status = first_status(old)
    there = BaseCorrection(estimate(0.1, 1.0), version=2)
    memory = LiveMapMemory(status, candidate=(new, there))
    # While it waits, a look at the base counts for the new map only.
    later = BaseCorrection(estimate(0.2, 2.0))
    waiting = changed(located(memory, later), "no room")
    assert waiting.status.scene_map is old
    assert (waiting.hold, waiting.status.trouble) == ("no room", "no room")
    assert waiting.correction.version == 0
    now = changed(waiting, "")
    assert now.status.scene_map is new and now.hold == ""
    assert now.correction.pose[0] == 0.2 and now.correction.version == 2
    assert now.status.swaps == 1 and now.candidate is None


def test_a_map_that_is_taken_back_holds_no_robot():
    """The process says that the map that counts is the newest again."""
    old = SceneMap(1, 0, (), 0.0, SignedDistanceField(PrimitiveScene()))
    new = dc.replace(old, version=2)
    candidate = new, BaseCorrection(version=2)
    memory = LiveMapMemory(first_status(old), candidate=candidate)
    waiting = changed(memory, "no room")
    alone = taken_back(waiting)
    assert alone.candidate is None and alone.hold == ""
    assert changed(alone, "no room") is alone
