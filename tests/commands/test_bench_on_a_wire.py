"""`remosplat bench faults` and `bench hardware`: flags, tables and files."""

import io
import json
import math

import pytest
from rich.console import Console
from runs import complaint, remosplat

from remosplat_drake.acceptance.fault_campaign import FaultResult
from remosplat_drake.acceptance.fault_cases import CASES
from remosplat_drake.commands.bench_hardware import fault_rows, fault_table
from remosplat_drake.commands.tables import print_table

STOPPED = FaultResult(CASES[0], "a reason", 0.25, 0.0, "no", "moves", 0.0381)
DISTURBED = FaultResult(CASES[1], "too early", problem="not tried")


@pytest.mark.parametrize(
    ("flags", "mention"),
    [
        (("hardware", "--case", "stop"), "--case chooses among faults"),
        (
            ("faults", "--compare", "x.json"),
            "--compare has no effect on the group faults",
        ),
        (
            ("hardware", "--scenario", "x"),
            "--scenario has no effect on the group hardware",
        ),
        (("faults", "--case", "nothing"), "unknown fault 'nothing'"),
    ],
)
def test_flags_that_say_nothing_are_refused(capsys, flags, mention):
    assert mention in complaint(capsys, "bench", *flags)


def test_a_file_that_cannot_be_written_is_named_first(capsys, tmp_path):
    line = complaint(capsys, "bench", "faults", "--json", tmp_path)
    assert f"{tmp_path}: is a folder" in line


def test_the_table_fits_a_terminal():
    console = Console(width=80, file=io.StringIO())
    print_table(console, fault_table([STOPPED, DISTURBED]))
    assert isinstance(console.file, io.StringIO)
    table = console.file.getvalue()
    assert "…" not in table
    assert f"{CASES[0].name} " in table
    assert " 250 " in table
    assert " 38.1\n" in table
    assert "not tried" in table


def test_rows_of_the_file():
    stopped, disturbed = json.loads(
        json.dumps(fault_rows([STOPPED, DISTURBED]), allow_nan=False)
    )
    assert stopped["fault"] == CASES[0].name
    assert stopped["time_to_zero"] == 0.25
    assert math.isclose(stopped["clearance"], 0.0381)
    assert disturbed["clearance"] is None
    assert disturbed["problem"] == "not tried"


@pytest.mark.slow
def test_one_fault_ends_in_a_file(lone_robot, tmp_path):
    path = tmp_path / "faults.json"
    done = remosplat(
        *("bench", "faults", "--case", "controller killed", "--json", path)
    )
    assert done.returncode == 0, done.stderr
    (row,) = json.loads(path.read_text())
    assert row["problem"] == ""
    assert row["clearance"] > 0
