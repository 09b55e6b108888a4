"""An import notices links that do not meet, and no link that does."""

from pathlib import Path

import numpy as np
import pytest

pytest.importorskip("trimesh")

from remosplat_drake.base import resources
from remosplat_drake.robot.importing.findings import Findings
from remosplat_drake.robot.importing.link_gaps import LinkGap, find_link_gaps
from remosplat_drake.robot.importing.packages import Packages
from remosplat_drake.robot.importing.sources import read_robot
from remosplat_drake.robot.importing.urdf import Urdf
from remosplat_drake.robot.robot_description import shipped_robots
from remosplat_drake.robot.robot_model import load_robot

LENGTH, RADIUS = 0.4, 0.05
DIAGONAL = np.hypot(LENGTH, 2 * RADIUS * np.sqrt(2))

SHAPE = (
    f'<collision><origin xyz="0 0 {LENGTH / 2}"/><geometry>'
    f'<cylinder radius="{RADIUS}" length="{LENGTH}"/></geometry></collision>'
)


def joint(name: str, parent: str, child: str, z: float, kind: str) -> str:
    return (
        f'<joint name="{name}" type="{kind}"><parent link="{parent}"/>'
        f'<child link="{child}"/><origin xyz="0 0 {z}"/><axis xyz="0 0 1"/>'
        '<limit lower="-0.3" upper="0.1"/></joint>'
    )


def gaps(folder: Path, *parts: str) -> list[LinkGap]:
    path = folder / "arm.urdf"
    path.write_text(f'<robot name="arm">{"".join(parts)}</robot>')
    urdf = Urdf(path, path.read_text())
    (folder / "spheres.yaml").write_text("spheres: {b: [[0, 0, 0.2, 0.3]]}")
    moving = [joint.name for joint in urdf.joints.values() if joint.moves]
    (folder / "arm.yaml").write_text(
        f"{{name: arm, model: arm.urdf, end_effector_frame: b,"
        f" arm: {{name: arm, joints: {moving}, mount: a}},"
        f" velocity_limits: {[1] * len(moving)},"
        f" acceleration_limits: {[1] * len(moving)},"
        f" home: {[0] * len(moving)}, spheres: {{covering: spheres.yaml}}}}"
    )
    return find_link_gaps(urdf, load_robot(folder / "arm.yaml"))


def link(name: str, inner: str = SHAPE) -> str:
    return f'<link name="{name}">{inner}</link>'


def test_links_that_touch_or_nearly_do_meet(tmp_path):
    links = link("a") + link("b") + link("c")
    for beyond in (-0.3, 0.0, 0.05):
        z = LENGTH + beyond
        above = joint("j", "a", "b", z, "revolute")
        assert not gaps(
            tmp_path, links, above, joint("k", "b", "c", z, "continuous")
        )


def test_origins_that_are_four_times_too_large_are_noticed(tmp_path):
    links = link("a") + link("b") + link("c")
    found = gaps(
        tmp_path,
        links,
        joint("j", "a", "b", 4 * LENGTH, "revolute"),
        joint("k", "b", "c", LENGTH, "revolute"),
    )
    (gap,) = found
    assert (gap.joint, gap.link, gap.carrier) == ("j", "b", "a")
    assert gap.distance == pytest.approx(3 * LENGTH)
    assert gap.size == pytest.approx(DIAGONAL, rel=0.02)
    assert str(gap).startswith("b is 1200 mm away from a")


def test_what_a_slide_can_close_is_no_gap(tmp_path):
    links = link("a") + link("b")
    slide = (tmp_path, links, joint("j", "a", "b", LENGTH + 0.3, "prismatic"))
    assert not gaps(*slide)
    (gap,) = gaps(
        tmp_path, links, joint("j", "a", "b", LENGTH + 0.6, "prismatic")
    )
    assert gap.distance == pytest.approx(0.3)


def test_links_without_shapes_are_passed_over(tmp_path):
    # The frame in the middle is far from both; what is fixed to `a` is not.
    links = link("a") + link("frame", "") + link("b") + link("mast")
    fixed = joint("f", "a", "mast", LENGTH, "fixed")
    near = joint("k", "frame", "b", 2 * LENGTH, "revolute")
    far = joint("k", "frame", "b", 4 * LENGTH, "revolute")
    bare = joint("j", "a", "frame", 0, "revolute")
    assert not gaps(tmp_path, links, fixed, bare, near)
    (gap,) = gaps(tmp_path, links, fixed, bare, far)
    assert (gap.joint, gap.link, gap.carrier) == ("k", "b", "a")
    assert not gaps(
        tmp_path, link("a", ""), link("b"), far.replace("frame", "a")
    )


@pytest.mark.parametrize("name", shipped_robots())
def test_the_links_of_shipped_robots_meet(name):
    robot = load_robot(name)
    path = robot.description.model_path
    ours = {"remosplat_drake": resources.models_dir().parent}
    urdf, _ = read_robot(path, Packages(path, ours), {}, Findings())
    assert not find_link_gaps(urdf, robot)
