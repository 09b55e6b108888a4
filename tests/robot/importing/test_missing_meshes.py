"""Links without visual meshes, or without collision meshes."""

from pathlib import Path

import pytest

from remosplat_drake.base.errors import RemoSplatError
from remosplat_drake.robot.importing.findings import Findings
from remosplat_drake.robot.importing.link_shapes import convert_shapes
from remosplat_drake.robot.importing.missing_meshes import replace_missing
from remosplat_drake.robot.importing.packages import Packages
from remosplat_drake.robot.importing.sources import read_robot
from remosplat_drake.robot.importing.urdf import Urdf

MESH = (
    '<{0}><origin xyz="0 0 1"/><geometry><mesh filename="{1}"/></geometry>'
    "</{0}>"
)
BOX = '<{0}><geometry><box size="1 1 1"/></geometry></{0}>'


def replaced(folder: Path, *elements: str) -> tuple[Urdf, Packages, Findings]:
    text = f'<robot name="r"><link name="a">{"".join(elements)}</link></robot>'
    urdf, findings = Urdf(folder / "r.urdf", text), Findings()
    packages = Packages(folder / "r.urdf", variables={})
    replace_missing(urdf, packages, findings)
    return urdf, packages, findings


def test_a_missing_picture_is_drawn_from_collision_shapes(tmp_path):
    lost, box = MESH.format("visual", "lost.dae"), BOX.format("collision")
    urdf, _, findings = replaced(tmp_path, lost, BOX.format("visual"), box)
    link = urdf.links["a"]
    assert [x.tag for x in link] == ["collision", "visual"]
    assert link.find("visual/geometry/box").get("size") == "1 1 1"
    said = dict(findings.doubted)["pictures"]
    start = "meshes are missing; collision shapes replace"
    assert said == f"{start} those of a"


def test_missing_collision_shapes_are_what_is_seen(tmp_path):
    lost = MESH.format("collision", "lost.stl")
    urdf, _, findings = replaced(tmp_path, lost, BOX.format("visual"))
    assert urdf.links["a"].find("collision/geometry/box") is not None
    said = dict(findings.doubted)["collision shapes"]
    assert "visual shapes replace those of a" in said


def test_where_both_are_missing_the_mesh_is_named(tmp_path):
    lost = [MESH.format(tag, f"{tag}.stl") for tag in ("visual", "collision")]
    urdf, packages, findings = replaced(tmp_path, *lost)
    assert not findings.doubted
    with pytest.raises(RemoSplatError, match=r"visual.stl: no such file"):
        convert_shapes(urdf, packages, tmp_path, findings)


def test_sdformat_does_without_pictures_too(tmp_path):
    geometry = "<geometry><{0}>{1}</{0}></geometry>"
    lost = geometry.format("mesh", "<uri>lost.dae</uri>")
    box = geometry.format("box", "<size>1 1 1</size>")
    path = tmp_path / "arm.sdf"
    path.write_text(
        "<sdf version='1.9'><model name='arm'><link name='a'>"
        f"<visual name='v'>{lost}</visual>"
        f"<collision name='c'><pose>0 0 1 0 0 0</pose>{box}</collision>"
        "</link></model></sdf>"
    )
    findings = Findings()
    urdf, _ = read_robot(path, Packages(path, variables={}), {}, findings)
    link = urdf.links["a"]
    assert link.find("visual/geometry/box") is not None
    assert link.find("visual/origin").get("xyz") == "0 0 1"
    assert "those of a" in dict(findings.doubted)["pictures"]


def test_a_path_of_its_makers_machine_is_found_by_its_end(tmp_path):
    (tmp_path / "meshes").mkdir()
    mesh = tmp_path / "meshes" / "a.stl"
    mesh.write_text("")
    packages = Packages(tmp_path / "r.urdf", variables={})
    uri = "file:///home/maker/robot/meshes/a.stl"
    assert packages.resolve(uri, "link 'a'") == mesh
    assert packages.guessed == {uri: mesh}
