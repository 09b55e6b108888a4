"""`remosplat run --hardware` against `remosplat hardware-sim`, as in a lab."""

import json

import pytest
from consenting import consenting
from runs import PATIENT, remosplat

from remosplat_drake.acceptance.hardware_processes import end, free_url, robot
from remosplat_drake.acceptance.motion_judge import TrueRun, true_clearance


@pytest.mark.smoke
def test_the_table_is_reached_through_the_wire(wire, table, tmp_path):
    url, motion = free_url(), tmp_path / "motion.npz"
    with (
        consenting(url),
        robot(url, "--record", str(motion)) as process,
    ):
        result = remosplat(
            *(
                "run",
                "TableReach",
                "--hardware",
                "--without-doctor",
                "--headless",
            ),
            *("--lcm-url", url, "--output", tmp_path),
            *("--scenario-text", PATIENT),
        )
        end(process)
    assert result.returncode == 0, result.stderr
    metrics = json.loads((tmp_path / "metrics.json").read_text())
    assert metrics["outcome"] == "reached"
    run = TrueRun.read(motion)
    assert true_clearance(run, table.robot, table.truth_field) > 0
