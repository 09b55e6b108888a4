"""The page about the real robot numbers its steps, and knows the wire."""

import re
from pathlib import Path

from remosplat_drake.hardware.wire import channels

ROOT = Path(__file__).resolve().parents[2]
PAGE = (ROOT / "docs/guides/bringing_up.md").read_text()


def test_the_steps_are_numbered():
    steps = re.findall(r"^## (\d+)\. ", PAGE, re.M)
    assert [int(step) for step in steps] == list(range(1, len(steps) + 1))


def test_the_numbers_are_those_of_the_wire():
    for time in (
        channels.COMMAND_EXPIRY,
        channels.STATUS_EXPIRY,
        channels.BASE_STATUS_EXPIRY,
    ):
        assert f"{time:g} s" in " ".join(PAGE.split())
