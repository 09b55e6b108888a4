"""Tests of the view of a running controller."""

import dataclasses as dc
import json
from pathlib import Path

import numpy as np
import pytest
from pydrake.common.value import AbstractValue
from pydrake.geometry import Mesh
from pydrake.math import RigidTransform
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import DiagramBuilder

from remosplat_drake.oracle.signed_distance import SignedDistanceField
from remosplat_drake.robot.robot_model import load_robot
from remosplat_drake.scene.primitive_scene import Box, PrimitiveScene
from remosplat_drake.signals.aim import Aim
from remosplat_drake.signals.tick_report import OPTIMAL, RELAXED, TickReport
from remosplat_drake.visualization.clearance_lines import TIGHT
from remosplat_drake.visualization.drawn_plant import drawn_plant
from remosplat_drake.visualization.hand_ghost import translucent
from remosplat_drake.visualization.legend import legend
from remosplat_drake.visualization.run_view import GHOST, PATHS, TARGET, RunView

THREE_LINK = Path(__file__).parents[1] / "data" / "three_link.yaml"
SCENE = PrimitiveScene(
    boxes=(Box(RigidTransform([1.0, 0.0, 0.5]), np.array([0.3, 0.3, 0.02])),)
)


class CountingField(SignedDistanceField):
    queries = 0

    def clearances(self, spheres, max_distance=np.inf):
        self.queries += 1
        return super().clearances(spheres, max_distance)


@pytest.fixture
def q(frankie) -> np.ndarray:
    return np.array([0.0, 0.0, 0.0, *frankie.home])


def make_report(robot, field, q, time=0.0):
    clearances = field.clearances(robot.spheres_at(q), 0.5)
    return dc.replace(
        TickReport.before_first(robot.n_q, robot.n_u),
        time=time,
        q=q,
        status=OPTIMAL,
        clearances=clearances,
        kept=np.ones(len(clearances), bool),
        tight=clearances.distance == clearances.minimum(),
        aim=Aim.of(RigidTransform([1.1, 0.0, 0.7])),
    )


def make_dut(page, robot, q, report):
    """A view on its own, with a function that feeds it."""
    dut = RunView(page=page, robot=robot)
    context = dut.CreateDefaultContext()

    def show(q, report, time):
        context.SetTime(time)
        dut.GetInputPort("configuration").FixValue(context, q)
        dut.GetInputPort("report").FixValue(context, AbstractValue.Make(report))
        dut.ForcedPublish(context)

    show(q, report, 0.0)
    return show


def test_shows_what_the_report_says(page, frankie, q, pose_of, is_visible):
    report = make_report(frankie, SignedDistanceField(SCENE), q)
    show = make_dut(page, frankie, q, report)
    np.testing.assert_allclose(pose_of(page.meshcat, TARGET), report.X_WT)
    assert is_visible(page.meshcat, TARGET)
    assert is_visible(page.meshcat, f"{TIGHT}/0")
    assert page.status["controller"] == "optimal"

    show(q, dc.replace(report, status=RELAXED), 0.1)
    assert page.status["controller"] == "relaxed"


def test_a_ghost_of_the_hand_stands_at_the_target_until_it_is_reached(
    page, frankie, q, pose_of, is_visible
):
    report = make_report(frankie, SignedDistanceField(SCENE), q)
    show = make_dut(page, frankie, q, report)
    np.testing.assert_allclose(
        pose_of(page.meshcat, GHOST), report.X_WT, atol=1e-12
    )
    assert is_visible(page.meshcat, GHOST)
    # The hand's links are where they are at the end effector.
    X_WE = frankie.end_effector_pose(q)
    X_WL = frankie.body_poses(q)[frankie.tree.index("panda_hand")]
    X_EG = pose_of(page.meshcat, f"{GHOST}/panda_hand/0")
    np.testing.assert_allclose(X_WE @ X_EG, X_WL, atol=1e-9)

    X_WT = X_WE.copy()
    X_WT[2, 3] += 0.02
    show(q, dc.replace(report, aim=Aim.of(X_WT)), 0.1)
    assert not is_visible(page.meshcat, GHOST)
    X_WT[2, 3] += 0.02
    show(q, dc.replace(report, aim=Aim.of(X_WT)), 0.2)
    assert is_visible(page.meshcat, GHOST)


def test_the_legend_names_each_of_several_end_effectors():
    alone, both = legend(("",)), legend(("left", "right"))
    assert alone[0] == ("#ffdb00", "path of the end effector")
    assert [text for _, text in both[:2]] == ["path of left", "path of right"]
    assert both[0][0] != both[1][0] and both[2:] == alone[1:]


def test_before_the_first_tick_there_is_no_target(page, frankie, q, is_visible):
    make_dut(
        page, frankie, q, TickReport.before_first(frankie.n_q, frankie.n_u)
    )
    assert not is_visible(page.meshcat, TARGET)


def test_what_a_target_leaves_free_is_drawn_as_long_as_it_does(
    page, frankie, q, is_visible
):
    def shown(target) -> set[str]:
        show(q, dc.replace(report, aim=Aim.of(target)), 0.1)
        marks = ("rx", "rz", "ball", "x", "50mm")
        return {
            mark
            for mark in marks
            if page.meshcat.HasPath(f"{TARGET}/marks/{mark}")
            and is_visible(page.meshcat, f"{TARGET}/marks/{mark}")
        }

    report = make_report(frankie, SignedDistanceField(SCENE), q)
    show = make_dut(page, frankie, q, report)
    target = report.target
    assert shown(target) == set()
    assert shown(target.without("rz", "x")) == {"rz", "x"}
    assert shown(target.without("rx", "ry", "rz")) == {"ball"}
    passed = target.passed(0.05)
    assert shown(passed) == {"50mm"}
    line = target.on_line(np.eye(4), 0.1)
    assert shown(line) == set()
    assert is_visible(page.meshcat, f"{TARGET}_lines/1")
    assert shown(target) == set()
    assert not is_visible(page.meshcat, f"{TARGET}_lines/1")


def test_looking_asks_no_oracle(page, frankie, q):
    field = CountingField(SCENE)
    report = make_report(frankie, field, q)
    show = make_dut(page, frankie, q, report)
    for k in range(20):
        show(q, report, 0.01 * k)
    assert field.queries == 1


def test_traces_grow_and_restart_when_time_does(page, frankie, q):
    report = make_report(frankie, SignedDistanceField(SCENE), q)
    show = make_dut(page, frankie, q, report)
    for k in range(1, 4):
        q[0] += 0.05
        show(q, report, 0.1 * k)
    for trace in ("end_effector", "base"):
        assert page.meshcat.HasPath(f"{PATHS}/{trace}/0")
    show(q, report, 0.0)
    assert not page.meshcat.HasPath(f"{PATHS}/base/0")


def test_publishes_at_its_own_rate_in_a_diagram(page, monkeypatch):
    beats = []
    monkeypatch.setattr(page, "beat", lambda: beats.append(None))
    robot = load_robot(THREE_LINK)  # No base, so no trace of it.
    builder = DiagramBuilder()
    dut = RunView.AddToBuilder(builder, page=page, robot=robot)
    for port in ("configuration", "report"):
        builder.ExportInput(dut.GetInputPort(port), port)
    diagram = builder.Build()
    simulator = Simulator(diagram)
    context = simulator.get_mutable_context()
    diagram.GetInputPort("configuration").FixValue(context, robot.home)
    diagram.GetInputPort("report").FixValue(
        context,
        AbstractValue.Make(TickReport.before_first(robot.n_q, robot.n_u)),
    )
    simulator.AdvanceTo(0.99)
    assert len(beats) == 32
    assert not page.meshcat.HasPath(f"{PATHS}/base/0")


def test_a_ghost_is_translucent_in_each_of_its_materials(frankie):
    drawn = drawn_plant(frankie)
    (look,) = drawn.looks(drawn.plant.GetBodyByName("panda_hand"))
    shape = look.shape
    ghost = translucent(shape)
    if not isinstance(shape, Mesh):  # Without the `meshes` extra.
        assert ghost is shape
        return
    assert isinstance(ghost, Mesh)
    contents = ghost.source().in_memory().mesh_file.contents()
    materials = json.loads(contents)["materials"]
    assert materials
    for material in materials:
        assert material["alphaMode"] == "BLEND"
        assert material["pbrMetallicRoughness"]["baseColorFactor"][3] < 0.6
