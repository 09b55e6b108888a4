"""Studies make the folders for their results, or name the problem at once."""

from pathlib import Path

import pytest

from apps.studies import (
    goal_bounds,
    hours,
    large_splats,
    phone_walk,
    push,
)
from apps.studies.causes import __main__ as causes
from apps.studies.command_line import output_folder
from apps.studies.depth_backends import __main__ as depth_backends
from apps.studies.imports import __main__ as imports
from apps.studies.live_map import __main__ as live_map
from apps.studies.noise import __main__ as noise
from apps.studies.operators import __main__ as operators
from apps.studies.pick_and_place import __main__ as pick_and_place
from apps.studies.scenes import __main__ as scenes
from apps.studies.strokes import __main__ as strokes
from apps.studies.true_shapes import __main__ as true_shapes
from apps.studies.ways_out import __main__ as ways_out

FOLDERS = [
    (goal_bounds, "--output"),
    (hours, "--folder"),
    (large_splats, "--folder"),
    (push, "--output"),
    (causes, "--output"),
    (imports, "--output"),
    (noise, "--output"),
    (operators, "--output"),
    (pick_and_place, "--output"),
    (strokes, "--output"),
    (ways_out, "--output"),
]

FILES = [
    (hours, "--output"),
    (depth_backends, "--json"),
    (depth_backends, "--write-states"),
    (live_map, "--json"),
    (scenes, "--output"),
    (true_shapes, "--output"),
]


def named(pair) -> str:
    return f"{pair[0].__name__.removeprefix('apps.studies.')} {pair[1]}"


@pytest.mark.parametrize("study, flag", FOLDERS, ids=map(named, FOLDERS))
def test_a_folder_that_cannot_be_made_is_named(study, flag, tmp_path, capsys):
    there = beneath_a_file(tmp_path)
    assert study.main([flag, str(there)]) == 2
    (line,) = capsys.readouterr().err.splitlines()
    assert line.startswith(f"remosplat: {there}: cannot be made: ")


@pytest.mark.parametrize("study, flag", FILES, ids=map(named, FILES))
def test_a_file_that_cannot_be_written_is_named(study, flag, tmp_path, capsys):
    there = beneath_a_file(tmp_path)
    assert study.main([flag, str(there)]) == 2
    (line,) = capsys.readouterr().err.splitlines()
    assert line.startswith(f"remosplat: {there}: ")


def test_the_folder_of_a_walk_is_named(tmp_path, capsys):
    there = beneath_a_file(tmp_path)
    assert phone_walk.main([str(there)]) == 2
    (line,) = capsys.readouterr().err.splitlines()
    assert line.startswith(f"remosplat: {there}: cannot be made: ")


def test_the_default_folder_is_checked_too(tmp_path, capsys, monkeypatch):
    monkeypatch.chdir(tmp_path)
    Path("results").touch()
    assert ways_out.main([]) == 2
    (line,) = capsys.readouterr().err.splitlines()
    assert line.startswith("remosplat: results/ways_out: cannot be made: ")


def test_a_missing_folder_is_made(tmp_path):
    there = tmp_path / "results" / "first"
    assert output_folder(str(there)) == there
    assert there.is_dir()


def beneath_a_file(folder: Path) -> Path:
    (folder / "file").touch()
    return folder / "file" / "results"
