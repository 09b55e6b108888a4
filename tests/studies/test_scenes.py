"""The picture of scenes: one picture of a suite, or one line of refusal."""

import pytest
from PIL import Image

from apps.studies.scenes.__main__ import main
from remosplat_drake.benchmark.suites import PUBLISHED_FOLDERS
from remosplat_drake.generation.scene_generators import generate
from remosplat_drake.scene.rmmi import write_rmmi


def test_a_suite_is_drawn(tmp_path):
    for family, stem in PUBLISHED_FOLDERS.items():
        write_rmmi(tmp_path / stem / f"{stem}_0000.json", generate(family, 0))
    sheet = tmp_path / "out" / "sheet.png"
    flags = ["--columns", "1", "--width", "120", "--output", str(sheet)]
    assert main(["--suite", f"published:{tmp_path}", *flags]) == 0
    with Image.open(sheet) as picture:
        assert picture.width > 120 and picture.height > 2 * 90


@pytest.mark.parametrize(
    ("flags", "problem"),
    [
        (["--scenes", "0"], "--scenes: must be at least 1"),
        (["--output", "sheet.jpg"], "must end in .png"),
        (["--suite", "generated:tabel"], "did you mean 'table'"),
        (["--suite", "others"], "unknown suite"),
    ],
)
def test_bad_flags_end_in_one_line(
    flags, problem, tmp_path, capsys, monkeypatch
):
    monkeypatch.chdir(tmp_path)
    assert main(flags) == 2
    error = capsys.readouterr().err.strip()
    assert problem in error and "\n" not in error
