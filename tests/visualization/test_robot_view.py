"""Tests of the robot drawn from q alone."""

from pathlib import Path

import numpy as np
from pydrake.systems.framework import DiagramBuilder

from remosplat_drake.robot.robot_model import load_robot
from remosplat_drake.visualization import drawn_plant
from remosplat_drake.visualization.robot_view import AddRobotView

THREE_LINK = Path(__file__).parents[1] / "data" / "three_link.yaml"


def draw(robot, page, q):
    builder = DiagramBuilder()
    builder.ExportInput(AddRobotView(builder, robot, page), "q")
    diagram = builder.Build()
    context = diagram.CreateDefaultContext()
    diagram.GetInputPort("q").FixValue(context, q)
    diagram.ForcedPublish(context)


def test_links_are_where_the_model_has_them(
    page, frankie, pose_of, without_meshes
):
    rng = np.random.default_rng(0)
    q = rng.uniform(-1, 1, frankie.n_q)
    draw(frankie, page, q)
    X_WL = frankie.body_poses(q)
    for path in (
        "base/base_link",
        "panda/panda_link4",
        "hand/panda_hand",
        "hand/panda_leftfinger",  # Moved by a locked joint.
    ):
        link = frankie.tree.index(path.split("/")[1])
        X = pose_of(page.meshcat, f"/remosplat/robot/{path}")
        np.testing.assert_allclose(X, X_WL[link], atol=1e-12)


def test_primitives_stand_in_for_absent_meshes(page, frankie, without_meshes):
    draw(frankie, page, np.zeros(frankie.n_q))
    links = {link for link in frankie.spheres.links if "hand" not in link}
    drawn = {
        link
        for link in links
        for model in ("base", "panda", "hand")
        if page.meshcat.HasPath(f"/remosplat/robot/{model}/{link}")
    }
    assert drawn == links


def test_arm_on_a_fixed_base_without_visuals(page):
    robot = load_robot(THREE_LINK)
    draw(robot, page, robot.home)
    assert page.meshcat.HasPath("/remosplat/robot/three_link/forearm")


def test_a_robot_s_look_is_made_once(frankie):
    drawn = drawn_plant.drawn_plant(frankie)
    assert drawn_plant.drawn_plant(frankie) is drawn
    hand = drawn.plant.GetBodyByName("panda_hand")
    assert drawn.looks(hand)
