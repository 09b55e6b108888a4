"""The noise experiment: kept results, tables, picture; one tiny world."""

import json

import numpy as np
import pytest
from pydrake.math import RigidTransform

from apps.studies.noise import experiment
from apps.studies.noise.__main__ import main
from apps.studies.noise.experiment import NoisyRun, random_starts
from apps.studies.noise.report import Results, markdown
from remosplat_drake.base.errors import FileError
from remosplat_drake.oracle.signed_distance import SignedDistanceField
from remosplat_drake.scene.primitive_scene import Box, PrimitiveScene
from remosplat_drake.scene.rmmi import write_rmmi
from remosplat_drake.splat.codecs.ply import write_ply
from remosplat_drake.splat.gaussian_splat import GaussianSplat

GOOD = NoisyRun(True, 0.03, 0.3, 0.01, 4.0)
TOUCHED = NoisyRun(True, -0.001, 0.3, 0.01, 4.0)
LOST = NoisyRun(False, 0.05, 0.2, 0.5, 15.0)


def facing_wall(x: float) -> GaussianSplat:
    """Opaque discs in the plane y-z at x."""
    y, z = np.meshgrid(np.linspace(-1.5, 1.5, 31), np.linspace(0, 2, 21))
    n = y.size
    return GaussianSplat(
        p_GK=np.stack([np.full(n, x), y.ravel(), z.ravel()], axis=1),
        quaternions=np.tile([np.sqrt(0.5), 0, np.sqrt(0.5), 0], (n, 1)),
        scales=np.full((n, 2), 0.1),
        opacities=np.full(n, 0.95),
        colors=np.full((n, 3), 0.5),
    )


@pytest.fixture
def folder(tmp_path, frankie):
    """A wall behind a target that is where the robot starts."""
    box = Box(RigidTransform([1.5, 0, 1]), np.array([0.25, 1.5, 1.0]))
    X_WE = frankie.end_effector_pose(np.array([0, 0, 0, *frankie.home]))
    truth = PrimitiveScene(
        boxes=(box,),
        X_WE_target=RigidTransform(X_WE),
        X_WB_start=(0.0, 0.0, 0.0),
    )
    write_rmmi(tmp_path / "truth.json", truth)
    write_ply(tmp_path / "wall.ply", facing_wall(1.25), with_normals=False)
    return tmp_path


def command(folder, *flags: str) -> int:
    return main(
        [
            "--scene",
            str(folder / "wall.ply"),
            str(folder / "truth.json"),
            *("--states", "2", "--starts", "1"),
            *("--output", str(folder / "out")),
            *flags,
        ]
    )


def test_it_leaves_tables_and_a_picture_and_goes_on(folder, capfd, monkeypatch):
    assert command(folder) == 0
    out = folder / "out"
    files = ["noise.md", "noise.png", "results.json"]
    assert sorted(p.name for p in out.iterdir()) == files
    text = (out / "noise.md").read_text()
    assert "| wall | depth rasterisation |" in text
    assert text.count("| 1 of 1 | 1 | 0 |") == len(experiment.METHODS)
    kept = json.loads((out / "results.json").read_text())
    assert len(kept) == 2 * len(experiment.METHODS)
    # What is there is not done again.
    for name in ("run_trial", "measure_accuracy"):
        monkeypatch.delattr(experiment, name)
    assert command(folder) == 0
    assert (out / "noise.md").read_text() == text
    capfd.readouterr()


def test_mistakes_are_told_in_one_line(folder, capfd):
    assert command(folder, "--states", "0") == 2
    assert "--states: must be at least 1" in capfd.readouterr().err
    (folder / "out").mkdir(exist_ok=True)
    (folder / "out" / "results.json").write_text("nonsense")
    assert command(folder) == 2
    assert "results.json: not JSON" in capfd.readouterr().err


def test_starts_are_the_scene_s_own_and_free_ones_about_it(frankie):
    truth = PrimitiveScene(
        boxes=(Box(RigidTransform([0.95, 0, 1]), np.array([0.1, 1, 1])),),
        X_WB_start=(-0.1, 0.2, 0.0),
    )
    starts = random_starts(frankie, truth, 6, seed=2)
    np.testing.assert_array_equal(starts[0, :3], [-0.1, 0.2, 0.0])
    np.testing.assert_array_equal(starts[:, 3:], np.tile(frankie.home, (6, 1)))
    field = SignedDistanceField(truth)
    for q in starts[1:]:
        assert field.clearances(frankie.spheres_at(q)).minimum() > 0.05
    assert len(np.unique(starts, axis=0)) == 6


def test_success_is_to_arrive_without_touching(tmp_path):
    assert [t.success for t in (GOOD, TOUCHED, LOST)] == [True, False, False]
    results = Results(tmp_path / "results.json")
    results.trials["scene", "method"] = [GOOD, TOUCHED, LOST]
    row = ("scene", "method", "1 of 3", "2", "1", "-1", "200")
    assert results.trial_rows() == [row]


def test_results_are_kept_from_run_to_run(tmp_path):
    path = tmp_path / "results.json"
    endless = NoisyRun(False, np.inf, np.inf, 1.0, 15.0)
    Results(path).keep("key", endless)
    again = Results(path)
    assert again.kept_trial("key") == endless
    assert again.kept_trial("other") is None
    path.write_text("[1, 2]")
    with pytest.raises(FileError):
        Results(path)


def test_tables_are_markdown():
    assert markdown(("a", "b", "c"), [("x", "y", "1")]) == (
        "| a | b | c |\n| --- | --- | ---: |\n| x | y | 1 |\n"
    )
