"""RMMI files: what is read, and how bad ones are refused."""

import copy
import json

import numpy as np
import pytest
from pydrake.math import RigidTransform, RollPitchYaw

from remosplat_drake.base.errors import FieldError, FileError, RemoSplatError
from remosplat_drake.scene.primitive_scene import Box, Cylinder, PrimitiveScene
from remosplat_drake.scene.rmmi import read_scene, write_rmmi

DOCUMENT = {
    "cubes": [{"position": [1.5, 0.0, 0.5], "scale": [0.5, 2.0, 0.03]}],
    "cylinders": [{"position": [1.1, 0.2, 0.5], "radius": 0.05, "heigth": 0.3}],
    "target": np.diag([1.0, -1.0, -1.0, 1.0]).tolist(),
    "robot_base": np.eye(4).tolist(),
}


def _write(path, document):
    path.write_text(json.dumps(document))
    return path


def test_reads_every_field(tmp_path):
    scene = read_scene(_write(tmp_path / "toy.json", DOCUMENT))
    assert scene.name == "toy"
    assert scene.boxes[0].X_WP.translation().tolist() == [1.5, 0, 0.5]
    assert scene.boxes[0].half_extents.tolist() == [0.5, 2.0, 0.03]
    assert scene.cylinders[0].radius == 0.05
    assert scene.cylinders[0].half_height == 0.3
    assert scene.X_WE_target.rotation().matrix()[2, 2] == -1
    assert scene.X_WB_start == (0, 0, 0)


def test_round_trip(tmp_path):
    scene = PrimitiveScene(
        boxes=(Box(RigidTransform([1, 2, 3]), np.array([0.1, 0.2, 0.3])),),
        cylinders=(Cylinder(RigidTransform([3, 2, 1]), 0.1, 0.2),),
        X_WE_target=RigidTransform(RollPitchYaw(1, 2, 3), [1, 2, 3]),
        X_WB_start=(0.5, -0.5, 2.0),
    )
    write_rmmi(tmp_path / "a.json", scene)
    again = read_scene(tmp_path / "a.json")
    assert again.content_hash == scene.content_hash
    assert again.X_WB_start == pytest.approx(scene.X_WB_start)
    assert again.X_WE_target.IsNearlyEqualTo(scene.X_WE_target, 1e-15)
    assert list(tmp_path.iterdir()) == [tmp_path / "a.json"]


def test_task_may_be_absent(tmp_path):
    document = {"cubes": [], "cylinders": []}
    scene = read_scene(_write(tmp_path / "a.json", document))
    assert scene.X_WE_target is None
    assert scene.X_WB_start is None


def test_rounded_rotation_is_made_orthonormal(tmp_path):
    document = copy.deepcopy(DOCUMENT)
    document["target"][0][:2] = [1.0, 0.0047]
    document["target"][1][:2] = [0.0047, -1.0]
    scene = read_scene(_write(tmp_path / "a.json", document))
    R = scene.X_WE_target.rotation().matrix()
    np.testing.assert_allclose(R @ R.T, np.eye(3), atol=1e-15)


def _set(keys, value):
    def edit(document):
        *path, last = keys
        for key in path:
            document = document[key]
        document[last] = value

    return edit


@pytest.mark.parametrize(
    ("edit", "field"),
    [
        (_set(["cubes"], 3), "cubes"),
        (_set(["cubes", 0], 3), r"cubes\[0\]"),
        (_set(["cubes", 0, "scale"], [1, 1]), r"cubes\[0\]\.scale"),
        (_set(["cubes", 0, "scale"], [1, 1, 0]), r"cubes\[0\]\.scale"),
        (_set(["cubes", 0, "scale"], ["a", 1, 1]), r"cubes\[0\]\.scale"),
        (_set(["cubes", 0, "scale"], [[1], 1, 1]), r"cubes\[0\]\.scale"),
        (_set(["cubes", 0, "position"], [0, 0, np.nan]), r"\.position: not f"),
        (_set(["cylinders", 0, "radius"], True), r"cylinders\[0\]\.radius"),
        (_set(["cylinders", 0, "radius"], -1), r"cylinders\[0\]\.radius"),
        (_set(["cylinders", 0, "height"], 1), "did you mean 'heigth'"),
        (_set(["target"], np.zeros((4, 4)).tolist()), "target: .*rotation"),
        (_set(["target"], (-np.eye(4)).tolist()), "target: .*rotation"),
        (_set(["target", 3], [0, 0, 1, 1]), "target: .*last row"),
        (_set(["target"], np.eye(3).tolist()), "target: expected numbers"),
        (_set(["target", 0, 0], 1e308), "target: must be at most 1e\\+06"),
        (_set(["target", 0, 3], 10**400), "target: not finite"),
        (_set(["cubes", 0, "position"], [[[]]] * 999), r"cubes\[0\]\.position"),
        (_set(["robot_base", 2, 3], 0.5), "robot_base: .*upright"),
        (lambda d: d.pop("cubes"), "cubes: is missing"),
        (lambda d: d["cylinders"][0].pop("heigth"), "heigth: is missing"),
    ],
)
def test_names_the_bad_field_in_one_line(tmp_path, edit, field):
    document = copy.deepcopy(DOCUMENT)
    edit(document)
    path = _write(tmp_path / "bad.json", document)
    with pytest.raises(FieldError, match=f"bad.json: .*{field}") as caught:
        read_scene(path)
    assert "\n" not in str(caught.value)
    assert len(str(caught.value)) < 500


@pytest.mark.parametrize(
    "text", ["", "{", "[1]", "\xff", "[" * 10**5, '{"cubes": ' + "[" * 10**5]
)
def test_rejects_what_is_not_a_json_object(tmp_path, text):
    path = tmp_path / "bad.json"
    path.write_bytes(text.encode("latin-1"))
    with pytest.raises(FileError, match=r"bad\.json"):
        read_scene(path)


def test_names_a_missing_file(tmp_path):
    with pytest.raises(FileError, match=r"none\.json"):
        read_scene(tmp_path / "none.json")


def test_refuses_to_write_what_the_format_cannot_say(tmp_path):
    X_WP = RigidTransform(RollPitchYaw(0, 0, 1), [0, 0, 0])
    scene = PrimitiveScene(boxes=(Box(X_WP, np.ones(3)),))
    with pytest.raises(RemoSplatError, match="axis-aligned"):
        write_rmmi(tmp_path / "a.json", scene)
    assert not list(tmp_path.iterdir())


def test_reads_all_published_scenes(shared_data):
    paths = sorted((shared_data / "rmmi_scenes").glob("*/*_[0-9]*.json"))
    assert len(paths) == 1000
    sizes = {len(read_scene(path)) for path in paths}
    assert sizes == {5, 7}
