"""From a scene's file to a splat, on the command line."""

import pytest

from remosplat_drake.commands.main import main
from remosplat_drake.resources import models_dir
from remosplat_drake.splat.ply import read_ply

pytest.importorskip("PIL")

SCENE = str(models_dir() / "scenes" / "table" / "scene.json")


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    folder = tmp_path_factory.mktemp("capture")
    size = ["--views", "4", "--width", "80", "--height", "60"]
    assert main(["render-capture", SCENE, str(folder), *size]) == 0
    return folder


def test_untrained_splat(folder, tmp_path):
    output = tmp_path / "splat.ply"
    flags = ["--untrained", "--count", "500", "--focus", "1.1", "0", "0.6"]
    assert main(["reconstruct", str(folder), str(output), *flags]) == 0
    assert 100 < len(read_ply(output)) <= 500


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["reconstruct", "nowhere", "a.ply"], "nowhere: no such file"),
        (["reconstruct", "{folder}", "a.ply", "--count", "0"], "--count"),
        (["render-capture", SCENE, "a", "--views", "0"], "--views"),
    ],
)
def test_one_line_says_what_is_wrong(folder, capsys, arguments, message):
    arguments = [a.format(folder=folder) for a in arguments]
    assert main(arguments) == 2
    error = capsys.readouterr().err
    assert message in error
    assert error.count("\n") == 1


def test_training_without_torch_names_the_extra(folder, capsys, tmp_path):
    try:
        import torch  # noqa: F401
    except ImportError:
        assert main(["reconstruct", str(folder), str(tmp_path / "a.ply")]) == 2
        assert "remosplat-drake[gpu]" in capsys.readouterr().err
    else:
        pytest.skip("torch is installed")
