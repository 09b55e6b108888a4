"""`remosplat capture-info` on rendered folders, right and wrong ones."""

import dataclasses as dc
import json

import numpy as np
import pytest

from remosplat_drake.capture.readers.nerfstudio import write_capture
from remosplat_drake.commands.main import main

image = pytest.importorskip("PIL.Image")


def said(capsys) -> str:
    """What was printed, without the table's lines and line breaks."""
    return " ".join(capsys.readouterr().out.replace("│", " ").split())


@pytest.fixture(scope="module")
def folder(scene_capture, tmp_path_factory):
    folder = tmp_path_factory.mktemp("capture")
    write_capture(folder, scene_capture)
    return folder


def test_a_good_capture(folder, capsys):
    assert main(["capture-info", str(folder)]) == 0
    text = said(capsys)
    assert "(nerfstudio)" in text
    assert "12 of 120x90 pixels" in text
    assert "57.3 degrees" in text
    assert "pairs of frames" in text and "100 % by less than 2 %" in text
    assert "no problem found" in text


def test_what_it_found_as_json(folder, capsys):
    assert main(["capture-info", str(folder), "--json"]) == 0
    document = json.loads(capsys.readouterr().out)
    assert set(document) == set(
        "capture format frames width height focal fov_deg depth known hidden"
        " path_length extent registration overlap wrong_frames findings".split()
    )
    assert (document["width"], document["height"]) == (120, 90)
    assert document["overlap"]["agreement"] > 0.99
    assert document["findings"] == document["wrong_frames"] == []


def test_it_judges_the_keyframes(scene_capture, folder, capsys):
    """Eleven of twelve miss next to nothing; of two, it is said what."""
    flags = ["capture-info", str(folder), "--keyframes"]
    assert main([*flags, "11"]) == 0
    text = said(capsys)
    assert "keyframes: 11 of 12 frames are used;" in text
    assert "11 of 120x90 pixels" in text
    assert main([*flags, "2", "--json"]) == 1
    document = json.loads(capsys.readouterr().out)
    assert document["frames"] == 2
    problems = [finding["problem"] for finding in document["findings"]]
    assert any("(--keyframes N uses more)" in words for words in problems)
    assert main([*flags, "0"]) == 0
    assert "12 of 120x90 pixels" in said(capsys)


def test_world_to_camera_poses_are_named(scene_capture, tmp_path, capsys):
    inverse = np.linalg.inv(scene_capture.X_WC)
    write_capture(tmp_path, dc.replace(scene_capture, X_WC=inverse))
    assert main(["capture-info", str(tmp_path)]) == 1
    assert "wrong: poses look like world-to-camera" in said(capsys)


def test_a_wrong_frame_is_listed_and_drawn(scene_capture, tmp_path, capsys):
    X_WC = scene_capture.X_WC.copy()
    X_WC[3, :3, 3] += [0.15, -0.1, 0.1]
    write_capture(tmp_path, dc.replace(scene_capture, X_WC=X_WC))
    picture = tmp_path / "picture.png"
    flags = ["--picture", str(picture)]
    assert main(["capture-info", str(tmp_path), *flags]) == 1
    text = said(capsys)
    assert "wrong frames 3" in text
    assert "1 of 12 frames disagree" in text
    with image.open(picture) as drawn:
        pixels = np.asarray(drawn.convert("RGB")).reshape(-1, 3)
    # Frame, name and camera of the wrong one are red.
    assert (pixels == [255, 59, 48]).all(axis=1).sum() > 50


def test_every_nth_frame(folder, capsys):
    assert main(["capture-info", str(folder), "--stride", "4"]) in (0, 1)
    assert "3 of 120x90 pixels" in said(capsys)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["nowhere"], "nowhere: no such file"),
        (["{folder}", "--format", "tmu"], "did you mean 'tum'"),
        (["{folder}", "--stride", "0"], "stride: must be positive"),
        (["{folder}/images"], "no capture of a known format"),
    ],
)
def test_what_cannot_be_read_is_told_in_one_line(
    folder, capsys, arguments, message
):
    arguments = [a.format(folder=folder) for a in arguments]
    assert main(["capture-info", *arguments]) == 2
    error = capsys.readouterr().err
    assert message in error
    assert error.count("\n") == 1
