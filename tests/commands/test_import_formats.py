"""`remosplat import-robot` on SDFormat, MJCF and model directives."""

import shutil
from pathlib import Path

import numpy as np
import pytest

trimesh = pytest.importorskip("trimesh")

from toy_robot import write_toy

from remosplat_drake.app.diagram import build
from remosplat_drake.app.scenario import load_scenario
from remosplat_drake.app.simulation import run
from remosplat_drake.commands.main import USER_ERROR, main
from remosplat_drake.robot.robot_model import load_robot

LENGTHS = (0.1, 0.1, 0.35, 0.3, 0.1, 0.1, 0.08)
"""Lengths of the pedestal and of six links, along z."""

AXES = ("0 0 1", "0 1 0", "0 1 0", "0 1 0", "0 0 1", "0 1 0")


def write_mjcf(folder: Path) -> Path:
    """Links within each other, with what MuJoCo takes from classes."""
    inner = '<site name="attachment_site" pos="0 0 0.08"/>'
    for i in reversed(range(6)):
        inner = (
            f'<body name="link_{i}" pos="0 0 {LENGTHS[i]}">'
            f'<joint name="joint_{i}" axis="{AXES[i]}"/>'
            f'<geom class="shape" mesh="link_{i}"/>{inner}</body>'
        )
        mesh = trimesh.creation.cylinder(0.04, LENGTHS[i + 1])
        mesh.apply_translation([0, 0, LENGTHS[i + 1] / 2])
        (folder / "meshes").mkdir(exist_ok=True)
        mesh.apply_scale(1000).export(folder / f"meshes/link_{i}.stl")
    meshes = "".join(f'<mesh file="link_{i}.stl"/>' for i in range(6))
    path = folder / "toy.xml"
    path.write_text(
        '<mujoco model="toy"><compiler meshdir="meshes" autolimits="true"/>'
        '<default><mesh scale="0.001 0.001 0.001"/>'
        '<joint range="-150 150"/>'
        '<default class="shape"><geom type="mesh"/></default></default>'
        f'<asset>{meshes}</asset><worldbody><geom type="plane" size="1 1 1"/>'
        '<body name="pedestal"><geom type="cylinder" size="0.04 0.05"'
        f' pos="0 0 0.05"/>{inner}</body></worldbody></mujoco>'
    )
    return path


def write_sdf(folder: Path) -> Path:
    """A model in a folder of its own, which another file includes."""
    links, joints = [], []
    for i, length in enumerate(LENGTHS):
        pose = f'<pose relative_to="joint_{i - 1}"/>' if i else ""
        links.append(
            f'<link name="link_{i}">{pose}<inertial><mass>1</mass></inertial>'
            f'<collision name="c"><pose>0 0 {length / 2} 0 0 0</pose><geometry>'
            f"<cylinder><radius>0.04</radius><length>{length}</length>"
            "</cylinder></geometry></collision></link>"
        )
    for i, axis in enumerate(AXES):
        joints.append(
            f'<joint name="joint_{i}" type="revolute">'
            f'<pose relative_to="link_{i}">0 0 {LENGTHS[i]} 0 0 0</pose>'
            f"<parent>link_{i}</parent><child>link_{i + 1}</child>"
            f"<axis><xyz>{axis}</xyz><limit><lower>-2.6</lower>"
            "<upper>2.6</upper><velocity>2</velocity></limit></axis></joint>"
        )
    model = folder / "toy_arm"
    model.mkdir()
    (model / "model.sdf").write_text(
        f'<sdf version="1.9"><model name="toy">{"".join([*links, *joints])}'
        '<frame name="tool0" attached_to="link_6"><pose>0 0 0.08 0 0 0</pose>'
        "</frame></model></sdf>"
    )
    (model / "model.config").write_text("<model><sdf>model.sdf</sdf></model>")
    path = folder / "toy.sdf"
    path.write_text(
        '<sdf version="1.9"><model name="toy"><include merge="true">'
        "<uri>model://toy_arm</uri></include></model></sdf>"
    )
    return path


def write_directives(folder: Path) -> Path:
    """The arm of a URDF on a stand of another one."""
    write_toy(folder)
    (folder / "stand.urdf").write_text(
        '<robot name="stand"><link name="stand"><collision>'
        '<origin xyz="0 0 0.15"/><geometry><box size="0.2 0.2 0.3"/>'
        "</geometry></collision></link></robot>"
    )
    path = folder / "toy.dmd.yaml"
    path.write_text(
        "directives:\n"
        "- add_model: {name: stand, file: stand.urdf}\n"
        "- add_model:\n"
        "    name: arm\n"
        "    file: package://toy_description/urdf/toy.urdf\n"
        "- add_weld: {parent: world, child: stand::stand}\n"
        "- add_weld:\n"
        "    parent: stand::stand\n"
        "    child: arm::pedestal\n"
        "    X_PC: {translation: [0, 0, 0.3]}\n"
    )
    return path


WRITERS = {
    "MJCF": (write_mjcf, "attachment_site", 1.13),
    "SDFormat": (write_sdf, "tool0", 1.13),
    "model directives": (write_directives, "tool0", 1.43),
}


@pytest.mark.slow
@pytest.mark.parametrize(
    ("write", "tool", "height"), WRITERS.values(), ids=WRITERS
)
def test_one_command_leads_to_a_run_that_reaches(
    tmp_path, capsys, write, tool, height
):
    (tmp_path / "source").mkdir()
    source, out = write(tmp_path / "source"), tmp_path / "made"
    flags = ["--out", str(out), "--tolerance", "40"]
    assert main(["import-robot", str(source), *flags]) == 0
    said = capsys.readouterr().out
    assert "as Drake reads it" in said
    assert f"remosplat run {out}/scenario.yaml" in said
    # What was made stands alone, wherever it is.
    shutil.rmtree(source.parent)
    moved = out.rename(tmp_path / "moved")
    robot = load_robot(moved / "toy.yaml")
    assert robot.description.end_effector_frame == tool
    X_WE = robot.end_effector_pose(np.zeros(6))
    np.testing.assert_allclose(X_WE[:3, 3], [0, 0, height], atol=1e-9)
    assert robot.position_upper[0] == pytest.approx(2.6, abs=0.02)
    result = run(build(load_scenario(str(moved / "scenario.yaml"))))
    assert result.outcome == "reached"
    assert result.metrics.truth_clearance_min > 0


def test_things_that_float_are_one_line_and_leave_nothing(tmp_path, capsys):
    source = write_mjcf(tmp_path)
    cube = '<body name="{}"><freejoint/><geom size="0.1"/></body>'
    text = source.read_text().replace(
        "</worldbody>",
        cube.format("red") + cube.format("blue") + "</worldbody>",
    )
    source.write_text(text)
    before = set(tmp_path.iterdir())
    out = tmp_path / "made"
    assert main(["import-robot", str(source), "--out", str(out)]) == USER_ERROR
    said = capsys.readouterr().err
    assert "toy.xml: body 'red' <freejoint>: floats, and so do other" in said
    assert said.count("\n") == 1
    assert set(tmp_path.iterdir()) == before
