"""The page about the real robot names only commands that exist."""

import importlib
import re
import shlex
from itertools import pairwise
from pathlib import Path

import pytest

import remosplat_drake
from remosplat_drake.app.scenario import load_scenario
from remosplat_drake.commands.main import COMMANDS, main
from remosplat_drake.hardware.hardware_config import check_lcm_url
from remosplat_drake.hardware.wire import channels

PAGE = (
    Path(remosplat_drake.__file__).parent / "hardware" / "drivers" / "README.md"
).read_text()
BLOCKS = re.findall(r"^```sh\n(.*?)^```", PAGE, re.M | re.S)
LINES = [shlex.split(line) for block in BLOCKS for line in block.splitlines()]


@pytest.mark.parametrize("line", LINES, ids=" ".join)
def test_every_command_is_one(line, monkeypatch):
    program, *arguments = line
    if program == "pip":
        return
    assert program == "remosplat"
    assert arguments[0] in COMMANDS
    module = importlib.import_module(
        f"remosplat_drake.commands.{arguments[0].replace('-', '_')}"
    )
    monkeypatch.setattr(module, "run", lambda arguments: 0)
    assert main(arguments) == 0
    for name, value in pairwise(arguments):
        if name == "--lcm-url":
            check_lcm_url(value)
        elif name == "--scenario-text":
            load_scenario(override=value)


def test_the_steps_are_numbered():
    steps = re.findall(r"^## (\d+)\. ", PAGE, re.M)
    assert [int(step) for step in steps] == list(range(1, len(steps) + 1))


def test_the_numbers_are_those_of_the_wire():
    for time in (
        channels.COMMAND_EXPIRY,
        channels.STATUS_EXPIRY,
        channels.BASE_STATUS_EXPIRY,
    ):
        assert f"{time:g} s" in PAGE
