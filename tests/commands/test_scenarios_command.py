"""`remosplat scenarios`: whole names, in a table and as JSON."""

import json

from remosplat_drake.app.scenario import DEFAULT_SCENARIO, shipped_scenarios
from remosplat_drake.commands.main import main


def test_every_name_is_whole(capsys, monkeypatch):
    monkeypatch.setenv("COLUMNS", "60")
    assert main(["scenarios"]) == 0
    lines = capsys.readouterr().out.splitlines()
    first = [line.split()[0] for line in lines]
    assert set(shipped_scenarios()) <= set(first)
    assert not any("…" in line for line in lines)


def test_as_json(capsys):
    assert main(["scenarios", "--json"]) == 0
    document = json.loads(capsys.readouterr().out)
    assert document["default"] == DEFAULT_SCENARIO
    entries = {entry["name"]: entry for entry in document["scenarios"]}
    assert entries.keys() == shipped_scenarios().keys()
    assert set(entries["TablePaper"]) == set(
        "name file robot spheres gains splat truth oracle station"
        " control_period time_limit".split()
    )
    assert entries["TablePaper"]["gains"] == "paper"
    assert entries["StudioLive"]["splat"] is None
