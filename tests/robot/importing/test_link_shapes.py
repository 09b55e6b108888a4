"""Meshes become what Drake draws and collides, in the same place and size."""

import json
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import pytest

trimesh = pytest.importorskip("trimesh")

from pydrake.geometry import SceneGraph
from pydrake.multibody.parsing import Parser
from pydrake.multibody.plant import MultibodyPlant

from remosplat_drake.base.errors import RemoSplatError
from remosplat_drake.robot.importing.findings import Findings
from remosplat_drake.robot.importing.link_shapes import convert_shapes
from remosplat_drake.robot.importing.packages import Packages
from remosplat_drake.robot.importing.urdf import Urdf


def link(mesh: str, kinds: tuple[str, ...] = ("visual", "collision")) -> str:
    shapes = "".join(
        f'<{kind}><origin xyz="1 2 3"/><geometry>{mesh}</geometry></{kind}>'
        for kind in kinds
    )
    return f'<robot name="arm"><link name="a">{shapes}</link></robot>'


def converted(folder: Path, text: str) -> tuple[Urdf, Findings]:
    file = folder / "arm.urdf"
    urdf, findings = Urdf(file, text), Findings()
    out = folder / "out"
    out.mkdir(exist_ok=True)
    convert_shapes(urdf, Packages(file, {}, {}), out, findings)
    return urdf, findings


def extent_of(gltf: dict) -> np.ndarray:
    """Size of a .gltf's points along x, y, z; its own axes are y-up."""
    accessor = gltf["accessors"][
        gltf["meshes"][0]["primitives"][0]["attributes"]["POSITION"]
    ]
    x, y, z = np.subtract(accessor["max"], accessor["min"])
    return np.array([x, z, y])


@pytest.mark.parametrize("suffix", ["stl", "obj", "dae"])
def test_a_mesh_in_millimetres_comes_out_in_metres(tmp_path, suffix):
    if suffix == "dae":
        pytest.importorskip("collada")
    trimesh.creation.box((100, 200, 300)).export(tmp_path / f"box.{suffix}")
    mesh = f'<mesh filename="box.{suffix}" scale="0.001 0.001 0.001"/>'
    urdf, _ = converted(tmp_path, link(mesh))
    # Where a picture is stays with its element; pieces are in the link's frame.
    kinds = "visual", "collision"
    visual, collision = (urdf.links["a"].find(kind) for kind in kinds)
    assert visual.find("origin").get("xyz") == "1 2 3"
    assert collision.find("origin") is None
    shapes = {}
    for element in (visual, collision):
        file = element.find("geometry/mesh")
        assert file.get("scale") is None
        shapes[element.tag] = tmp_path / "out" / file.get("filename")
    hull = trimesh.load_mesh(shapes["collision"])
    np.testing.assert_allclose(hull.extents, [0.1, 0.2, 0.3], atol=1e-3)
    np.testing.assert_allclose(hull.bounds.mean(axis=0), [1, 2, 3], atol=2e-4)
    gltf = json.loads(shapes["visual"].read_text())
    np.testing.assert_allclose(extent_of(gltf), [0.1, 0.2, 0.3], atol=1e-4)


def test_the_unit_of_a_collada_file_counts(tmp_path):
    pytest.importorskip("collada")
    path = tmp_path / "box.dae"
    trimesh.creation.box((10, 20, 30)).export(path)
    text = path.read_text()
    assert "<asset>" in text
    unit = '<unit name="centimeter" meter="0.01"/>'
    head, _, tail = text.partition("</asset>")
    if "<unit" in head:
        head = (
            head[: head.index("<unit")]
            + head[head.index("/>", head.index("<unit")) + 2 :]
        )
    path.write_text(f"{head}{unit}</asset>{tail}")
    urdf, _ = converted(tmp_path, link('<mesh filename="box.dae"/>'))
    file = urdf.links["a"].find("collision/geometry/mesh").get("filename")
    hull = trimesh.load_mesh(tmp_path / "out" / file)
    np.testing.assert_allclose(hull.extents, [0.1, 0.2, 0.3], atol=1e-3)


def test_a_link_that_is_only_seen_gets_shapes(tmp_path):
    trimesh.creation.box((1, 1, 1)).export(tmp_path / "box.stl")
    text = link('<mesh filename="box.stl"/>', ("visual",))
    urdf, findings = converted(tmp_path, text)
    assert urdf.links["a"].find("collision/geometry/mesh") is not None
    assert "a" in dict(findings.guessed)["collision shapes"]


def test_a_primitive_hides_nothing_of_what_is_seen(tmp_path):
    trimesh.creation.box((1, 1, 1)).export(tmp_path / "box.stl")
    visual = '<mesh filename="box.stl"/>'
    text = link(visual, ("visual",)).replace(
        "</link>",
        '<collision><geometry><sphere radius="0.1"/></geometry></collision>'
        "</link>",
    )
    urdf, findings = converted(tmp_path, text)
    ball, hull = urdf.links["a"].findall("collision")
    assert ball.find("geometry/sphere") is not None
    assert hull.find("geometry/mesh") is not None
    assert "a" in dict(findings.guessed)["collision shapes"]


@pytest.mark.parametrize(
    ("mesh", "message"),
    [
        ("<mesh/>", "link 'a' <visual> <mesh>: has no filename"),
        ('<mesh filename="no.stl"/>', "<mesh>: no.stl: no such file"),
        ('<mesh filename="box.txt"/>', "box.txt is none of .stl"),
        ('<mesh filename="bad.stl"/>', "bad.stl "),
        ('<mesh filename="box.stl" scale="1 0 1"/>', "scale: expected three"),
        ('<mesh filename="box.stl" scale="big"/>', "got 'big'"),
        (
            '<mesh filename="box.stl" scale="60 60 80"/>',
            "<mesh> scale: box.stl is 80 m large with the scale 60 60 80;",
        ),
    ],
)
def test_a_mesh_that_cannot_be_used_is_told(tmp_path, mesh, message):
    trimesh.creation.box((1, 1, 1)).export(tmp_path / "box.stl")
    (tmp_path / "box.txt").write_text("box")
    (tmp_path / "bad.stl").write_bytes(b"\x00" * 10)
    with pytest.raises(RemoSplatError, match=message) as caught:
        converted(tmp_path, link(mesh))
    assert "\n" not in str(caught.value)


def test_materials_of_one_name_may_differ(tmp_path):
    """As the Kinova arm of example-robot-data has them; Drake refuses it."""
    visual = (
        '<visual><geometry><sphere radius="0.1"/></geometry>'
        '<material name="grey">{}</material></visual>'
    )
    colours = ["0.1 0.1 0.1 1", "0.7 0.7 0.7 1"]
    inner = [visual.format(f'<color rgba="{rgba}"/>') for rgba in colours]
    inner.append(visual.format(""))
    text = f'<robot name="arm"><link name="a">{"".join(inner)}</link></robot>'
    urdf, _ = converted(tmp_path, text)
    painted = [color.get("rgba") for color in urdf.root.iter("color")]
    assert painted == [*colours, colours[0]]
    plant, scene_graph = MultibodyPlant(0.0), SceneGraph()
    plant.RegisterAsSourceForSceneGraph(scene_graph)
    text = ElementTree.tostring(urdf.root).decode()
    assert Parser(plant).AddModelsFromString(text, "urdf")
