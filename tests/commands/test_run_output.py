"""The streams of `remosplat run`: results on stdout, all else on stderr."""

import json

from remosplat_drake.commands.main import main


def test_the_result_is_on_stdout(capfd):
    assert main(["run", "TableGroundTruth", "--headless"]) == 0
    said = capfd.readouterr()
    outcome, *_ = said.out.splitlines()
    assert outcome.split() == ["outcome", "reached"]
    assert "outcome" not in said.err


def test_json_is_all_that_is_on_stdout(tmp_path, capfd):
    """It holds what the file of the metrics holds."""
    flags = ["--headless", "--json", "--output", str(tmp_path)]
    assert main(["run", "TableGroundTruth", *flags]) == 0
    document = json.loads(capfd.readouterr().out)
    assert document["outcome"] == "reached"
    assert document == json.loads((tmp_path / "metrics.json").read_text())
