"""`reconstruct` that is interrupted, and started again."""

import signal

import pytest
from effort import effort

from remosplat_drake.base.progress import Progress
from remosplat_drake.base.resources import models_dir
from remosplat_drake.commands.main import main
from remosplat_drake.commands.reconstruct import stages_path

pytest.importorskip("PIL")

SCENE = str(models_dir() / "scenes" / "table" / "scene.json")

STAGES = {
    "choosing keyframes": (),
    "reading frames": ("keyframes",),
    "aligning the views": (),
    "refining": ("refined cameras",),
    "bounding": (),
    "finding what was seen": ("splat",),
    "comparing distances": ("seen space", "cross-validation"),
}
"""What is interrupted, and the stages that have been finished since the one
before."""
STRUCK = effort(("aligning the views", "comparing distances"), tuple(STAGES))
"""Of these, the ones at which Ctrl-C is struck."""


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    folder = tmp_path_factory.mktemp("capture")
    size = ["--views", "12", "--width", "80", "--height", "60", "--floor"]
    assert main(["render-capture", SCENE, str(folder), *size]) == 0
    return folder


def reconstruct(folder, output, *flags: str) -> int:
    flags = ("--device", "cpu", "--count", "1000", "--keyframes", "8", *flags)
    return main(["reconstruct", str(folder), "-o", str(output), *flags])


@pytest.fixture
def strike(monkeypatch):
    """Makes Ctrl-C be struck as soon as a stage is reported."""

    def _strike(stage: str):
        plain = Progress.report

        def report(self, what, done=0, total=None):
            plain(self, what, done, total)
            if what == stage:
                monkeypatch.setattr(Progress, "report", plain)
                signal.raise_signal(signal.SIGINT)

        monkeypatch.setattr(Progress, "report", report)

    # Of a shell's background jobs, Ctrl-C is ignored from the start.
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    yield _strike
    signal.signal(signal.SIGINT, before)


def test_goes_on_where_it_was(folder, tmp_path, strike, capsys):
    """However often: what comes out is the same, bit for bit."""
    whole, broken = tmp_path / "whole", tmp_path / "broken"
    assert reconstruct(folder, whole / "a.ply") == 0
    kept: list[str] = []
    for stage, finished in STAGES.items():
        kept += finished
        if stage not in STRUCK:
            continue
        strike(stage)
        assert reconstruct(folder, broken / "a.ply") == 130, stage
        said = capsys.readouterr()
        assert said.err.endswith("remosplat: interrupted\n")
        files = sorted(f.stem for f in stages_path(broken / "a.ply").glob("*"))
        assert files == sorted(name.replace(" ", "_") for name in kept), stage
    assert reconstruct(folder, broken / "a.ply") == 0
    said = capsys.readouterr().out
    for name in kept:
        assert f"{name}: reuses the kept result" in said
    names = sorted(file.name for file in whole.iterdir())
    assert sorted(file.name for file in broken.iterdir()) == names
    for name in names:
        a, b = (whole / name).read_bytes(), (broken / name).read_bytes()
        assert a == b, name


def test_other_flags_begin_afresh(folder, tmp_path, strike, capsys):
    output = tmp_path / "a.ply"
    strike("refining")
    assert reconstruct(folder, output) == 130
    capsys.readouterr()
    strike("refining")
    assert reconstruct(folder, output, "--depth-scale-std", "0.01") == 130
    said = capsys.readouterr().out
    assert "keyframes: reuses the kept result" in said
    assert "refined cameras: computed again: " in said
