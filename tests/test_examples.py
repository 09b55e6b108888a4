"""Every example runs as it stands, and shows what it says."""

import json
import re
import runpy
import sys
from pathlib import Path

import pytest
from patience import PATIENCE

FOLDER = Path(__file__).resolve().parents[1] / "apps" / "examples"
EXAMPLES = sorted(FOLDER.glob("*.py"))


def output_of(number: int, capsys, monkeypatch, *arguments: str) -> str:
    """What an example prints."""
    (file,) = FOLDER.glob(f"{number:02}_*.py")
    monkeypatch.setattr(sys, "argv", [str(file), *arguments])
    runpy.run_path(str(file), run_name="__main__")
    return capsys.readouterr().out


def numbers(text: str, unit: str = "mm") -> list[float]:
    """All numbers before a unit."""
    return [float(x) for x in re.findall(rf"(-?[\d.]+) {unit}\b", text)]


def test_they_are_numbered_and_short():
    assert [int(file.name[:2]) for file in EXAMPLES] == list(range(1, 11))
    for file in EXAMPLES:
        assert len(file.read_text().splitlines()) <= 60, file.name


def test_clearances(capsys, monkeypatch):
    text = output_of(1, capsys, monkeypatch)
    *links, smallest = numbers(text)
    assert "base_link" in text
    assert smallest == min(links) == links[0]


def test_two_oracles(capsys, monkeypatch):
    text = output_of(2, capsys, monkeypatch)
    for row in text.splitlines()[1:]:
        ellipsoids, views, truth = numbers(row)
        assert ellipsoids == pytest.approx(truth, abs=10)
        assert views == pytest.approx(truth, abs=25)


def test_running_a_scenario(capsys, monkeypatch):
    text = output_of(3, capsys, monkeypatch)
    assert "reached: 1 of 1" in text
    assert numbers(text, "m")[-1] >= 0.02


def test_a_cost_of_ones_own_acts(capsys, monkeypatch):
    text = output_of(4, capsys, monkeypatch)
    without, with_cost = numbers(text, "m")
    assert with_cost < 0.95 * without


def test_the_controller_in_a_diagram_of_ones_own(capsys, monkeypatch):
    text = output_of(5, capsys, monkeypatch)
    reached, wanted = (
        [float(x) for x in group.split()]
        for group in re.findall(r"\[([^]]*)\]", text)
    )
    assert reached == pytest.approx(wanted, abs=0.02)


@pytest.mark.slow
def test_a_map_of_ones_own_holds_the_robot(capsys, monkeypatch):
    text = output_of(6, capsys, monkeypatch)
    assert "wall at 1.5 m: reached" in text
    assert "wall at 0.9 m: time limit" in text
    assert min(numbers(text, "m")) > 0.005


def test_a_robot_of_ones_own_arrives(capsys, monkeypatch):
    text = output_of(7, capsys, monkeypatch)
    assert "reached" in text
    assert numbers(text)[-1] < 20


def test_a_station_of_ones_own_keeps_its_distance(capsys, monkeypatch):
    text = output_of(8, capsys, monkeypatch)
    assert text.count("reached") == 2
    assert all(clearance > 0 for clearance in numbers(text, "m"))


def test_a_splat_from_a_capture(open3d, rendering, capsys, monkeypatch):
    text = output_of(9, capsys, monkeypatch)
    median, largest = numbers(text)
    assert abs(median) < 5
    assert largest < 60


def test_a_run_is_kept_as_a_page(tmp_path, capsys, monkeypatch):
    file = tmp_path / "run.html"
    text = output_of(10, capsys, monkeypatch, str(file), "--realtime-rate", "0")
    assert "reached" in text
    assert "<html" in file.read_text()[:1000].lower()


@pytest.mark.parametrize(
    "notebook", sorted(FOLDER.glob("notebooks/*.ipynb")), ids=lambda p: p.stem
)
def test_every_notebook_runs(notebook):
    nbformat = pytest.importorskip("nbformat", reason="a dev dependency")
    client = pytest.importorskip("nbclient", reason="a dev dependency")
    document = nbformat.read(notebook, as_version=4)
    nbformat.validate(document)
    client.NotebookClient(document, timeout=PATIENCE).execute()
    printed = "".join(
        output.get("text", "")
        for cell in document.cells
        for output in cell.get("outputs", [])
    )
    assert "mm" in printed


@pytest.mark.parametrize(
    "notebook", sorted(FOLDER.glob("notebooks/*.ipynb")), ids=lambda p: p.stem
)
def test_a_notebook_is_stored_with_outputs_and_a_picture(notebook):
    cells = json.loads(notebook.read_text())["cells"]
    outputs = [o for cell in cells for o in cell.get("outputs", [])]
    assert any("mm" in "".join(o.get("text", "")) for o in outputs)
    assert any("image/png" in o.get("data", {}) for o in outputs)
    # A page of the run that stored them is gone.
    assert "iframe" not in json.dumps(outputs).lower()
    assert notebook.stat().st_size < 200_000
