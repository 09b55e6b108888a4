"""The streams of `remosplat run`: results on stdout, all else on stderr."""

import json

from runs import remosplat


def test_the_result_is_on_stdout():
    done = remosplat("run", "TableGroundTruth", "--headless")
    assert done.returncode == 0, done.stderr
    outcome, *_ = done.stdout.splitlines()
    assert outcome.split() == ["outcome", "reached"]
    assert "outcome" not in done.stderr


def test_json_is_all_that_is_on_stdout(tmp_path):
    """It holds what the file of the metrics holds."""
    done = remosplat(
        *("run", "TableGroundTruth", "--headless", "--json"),
        *("--output", tmp_path),
    )
    assert done.returncode == 0, done.stderr
    document = json.loads(done.stdout)
    assert document["outcome"] == "reached"
    assert document == json.loads((tmp_path / "metrics.json").read_text())
