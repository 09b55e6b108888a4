"""`remosplat render-capture`: scenes of every kind, and clear refusals."""

import numpy as np
import pytest

from remosplat_drake.capture.formats import read_capture
from remosplat_drake.commands.main import main
from remosplat_drake.generation.scene_generators import generate
from remosplat_drake.oracle.signed_distance import SignedDistanceField
from remosplat_drake.robot.sphere_model import Spheres
from remosplat_drake.scene.primitive_scene import PrimitiveScene
from remosplat_drake.scene.rmmi import read_scene, write_rmmi

SMALL = ["--views", "3", "--width", "64", "--height", "48"]

SDF = """<sdf version="1.7"><model name="ball"><static>true</static>
  <link name="ball"><visual name="ball">
    <geometry><sphere><radius>0.2</radius></sphere></geometry>
  </visual></link></model></sdf>"""


def points_of(folder) -> np.ndarray:
    capture = read_capture(folder)
    points = [capture.points_W(v).reshape(-1, 3) for v in range(len(capture))]
    points = np.concatenate(points)
    return points[np.isfinite(points[:, 0])]


def test_a_generated_scene_comes_with_its_truth(tmp_path):
    folder = tmp_path / "capture"
    assert main(["render-capture", "posts:1", str(folder), *SMALL]) == 0
    truth = read_scene(folder / "truth.json")
    assert truth.content_hash == generate("posts", 1).content_hash
    distance = SignedDistanceField(truth).clearances(
        Spheres.at(points_of(folder))
    )
    # Files hold millimetres, and cylinders are drawn as prisms.
    assert np.abs(distance.distance).max() < 2e-3


def test_the_floor_is_part_of_the_truth(tmp_path):
    folder = tmp_path / "capture"
    write_rmmi(tmp_path / "scene.json", generate("table", 0))
    scene = str(tmp_path / "scene.json")
    flags = ["--floor", "--noise", "kinect", "--radius", "1.5"]
    assert main(["render-capture", scene, str(folder), *flags, *SMALL]) == 0
    truth = read_scene(folder / "truth.json")
    assert len(truth.boxes) == 2
    assert truth.boxes[-1].top == 0


def test_a_model_is_captured_where_it_is_placed(tmp_path):
    (tmp_path / "ball.sdf").write_text(SDF)
    folder = tmp_path / "capture"
    ball, place = str(tmp_path / "ball.sdf"), ["--place", "1", "0", "0.5", "0"]
    assert main(["render-capture", ball, str(folder), *place, *SMALL]) == 0
    radius = np.linalg.norm(points_of(folder) - [1, 0, 0.5], axis=1)
    assert np.abs(radius - 0.2).max() < 5e-3
    assert not (folder / "truth.json").exists()


@pytest.mark.parametrize(
    ("arguments", "problem"),
    [
        (["tables:1"], "did you mean 'table'"),
        (["nowhere.stl"], "no such file"),
        (["table:1", "--views", "0"], "--views: must be positive"),
        (["table:1", "--width", "1000000"], "--width: exceeds"),
        (["table:1", "--seed", "-1"], "--seed: must not be negative"),
        (["table:1", "--noise", "lidar"], "unknown noise preset"),
        (
            ["table:1", "--scale", "2"],
            "only on models and meshes",
        ),
        (["table:1", "--around", "1", "nan", "0"], "--around: must be finite"),
        (["bare.json"], "add --around"),
    ],
)
def test_bad_arguments_end_in_one_line(
    arguments, problem, tmp_path, capsys, monkeypatch
):
    monkeypatch.chdir(tmp_path)
    write_rmmi(tmp_path / "bare.json", PrimitiveScene())
    assert main(["render-capture", arguments[0], "out", *arguments[1:]]) == 2
    error = capsys.readouterr().err
    assert problem in error and error.count("\n") == 1
    assert not (tmp_path / "out").exists()
