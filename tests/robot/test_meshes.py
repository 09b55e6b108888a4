"""The robot's look: table, conversion, cache, and life without all that."""

import base64
import importlib.util
import json

import numpy as np
import pytest
from own_cache import use_cache
from pydrake.geometry import Mesh, Role, SceneGraph
from pydrake.multibody.plant import MultibodyPlant
from pydrake.multibody.tree import SpatialInertia

from remosplat_drake.base import resources
from remosplat_drake.base.errors import FieldError
from remosplat_drake.robot import meshes
from remosplat_drake.robot.visuals import load_visuals

FRANKIE = resources.models_dir() / "frankie" / "visuals.yaml"
FINGER = """
links:
  finger:
  - mesh: xacro/qut_frankie_description/meshes/visual/finger.dae
    translation: [0, 0, 1]
    rpy_deg: [0, 0, 180]
    colour: [1, 0, 0, 1]
"""
needs_meshes = pytest.mark.skipif(
    importlib.util.find_spec("rtbdata") is None
    or importlib.util.find_spec("trimesh") is None,
    reason="needs the extra `meshes` (rtb-data, trimesh, ...)",
)


@pytest.fixture
def cache(tmp_path, monkeypatch):
    use_cache(monkeypatch, tmp_path / "cache")
    return tmp_path / "cache"


@pytest.fixture
def finger(tmp_path):
    path = tmp_path / "visuals.yaml"
    path.write_text(FINGER)
    return path


@pytest.fixture
def without_extra(monkeypatch):
    find = importlib.util.find_spec
    monkeypatch.setattr(
        importlib.util,
        "find_spec",
        lambda name, *a: None if name == "rtbdata" else find(name, *a),
    )


def test_table_places_the_mesh_in_its_link(finger):
    (visual,) = load_visuals(finger)["finger"]
    # Turned by half a turn about z, one metre up.
    np.testing.assert_allclose(
        visual.X_LV @ np.array([1.0, 2, 3]), [-1, -2, 4], atol=1e-12
    )


def test_frankies_table_has_all_twelve_links():
    links = load_visuals(FRANKIE)
    assert len(links) == 12
    assert "base_link" in links


@pytest.mark.parametrize(
    ("line", "field"),
    [
        ("colour: [1, 0, 0]", "colour"),
        ("rpy_deg: [1]", "rpy_deg"),
        ("meshes: x", "meshes"),
        ("mesh: ''", "mesh"),
    ],
)
def test_bad_entry_is_named(tmp_path, line, field):
    path = tmp_path / "visuals.yaml"
    path.write_text(f"links:\n  finger:\n  - {line}\n")
    with pytest.raises(FieldError, match=field):
        load_visuals(path)


def test_without_extra_and_cache_there_are_no_meshes(
    finger, cache, without_extra
):
    assert meshes.link_meshes(finger) == {}
    assert not cache.exists()


@needs_meshes
def test_converts_once_and_then_needs_nothing(finger, cache, monkeypatch):
    (first,) = meshes.link_meshes(finger)["finger"]
    assert first.path.is_relative_to(cache)
    assert first.path.suffix == ".gltf"
    monkeypatch.setattr(meshes, "_source_path", lambda mesh: None)
    (second,) = meshes.link_meshes(finger)["finger"]
    assert second.path == first.path
    assert [p.name for p in first.path.parent.iterdir()] == [first.path.name]


@needs_meshes
def test_converted_mesh_keeps_size_and_place(finger, cache):
    (entry,) = load_visuals(finger)["finger"]
    source = meshes.source_mesh(entry.mesh)
    assert source is not None
    (mesh,) = meshes.link_meshes(finger)["finger"]
    hull = Mesh(str(mesh.path)).GetConvexHull()
    vertices = np.array([hull.vertex(i) for i in range(hull.num_vertices())])
    # Drake has turned the y-up file back: same axes as the z-up source.
    box = np.array([vertices.min(0), vertices.max(0)])
    np.testing.assert_allclose(box, source.bounds, atol=2e-4)


@needs_meshes
def test_registers_for_viewers_and_cameras(finger, cache):
    scene_graph = SceneGraph()
    plant = MultibodyPlant(time_step=0.0)
    plant.RegisterAsSourceForSceneGraph(scene_graph)
    body = plant.AddRigidBody("finger", SpatialInertia.NaN())
    meshes.register_link_meshes(meshes.link_meshes(finger), plant)
    frame = plant.GetBodyFrameIdOrThrow(body.index())
    inspector = scene_graph.model_inspector()
    for role in (Role.kIllustration, Role.kPerception):
        (geometry,) = inspector.GetGeometries(frame, role)
        X_LV = inspector.GetPoseInFrame(geometry)
        np.testing.assert_allclose(X_LV.translation(), [0, 0, 1])


def test_what_is_rounded_off_is_not_seen():
    """A position and a normal, and nothing else, in a glTF by hand."""
    values = np.array([[0.1234567, -0.5, 1.0], [0.6, 0.0, 0.8]], "<f4")
    index = np.array([7, 8], "<u2").tobytes()
    data = values.tobytes() + index
    uri = "data:application/octet-stream;base64,"
    views = [(0, 12), (12, 12), (24, 4)]
    document = {
        "buffers": [{"uri": uri + base64.b64encode(data).decode()}],
        "bufferViews": [
            {"buffer": 0, "byteOffset": at, "byteLength": size}
            for at, size in views
        ],
        "accessors": [{"bufferView": k, "count": 1} for k in range(3)],
        "meshes": [
            {
                "primitives": [
                    {"attributes": {"POSITION": 0, "NORMAL": 1}, "indices": 2}
                ]
            }
        ],
    }
    after = json.loads(meshes.rounded(json.dumps(document).encode()))
    data = base64.b64decode(after["buffers"][0]["uri"].removeprefix(uri))
    found = np.frombuffer(data[:24], "<f4").reshape(2, 3)
    np.testing.assert_allclose(found[0], values[0], atol=2**-17)
    np.testing.assert_allclose(found[1], values[1], atol=2**-9)
    assert (found * 2**16 == np.rint(found * 2**16)).all()
    assert data[24:] == index
