"""A run that waits for a visitor at its page."""

import io
import sys

import pytest
from page_messages import click
from rich.console import Console

from remosplat_drake.base.errors import RemoSplatError
from remosplat_drake.commands import hold
from remosplat_drake.commands.hold import is_waited_for, wait_for_start
from remosplat_drake.commands.main import main
from remosplat_drake.visualization.page import MeshcatPage
from remosplat_drake.visualization.page_state import (
    START,
    WAITING,
    unsupervised,
)
from remosplat_drake.visualization.page_style import BUTTONS


class Arguments:
    def __init__(self, wanted=None, headless=False, hardware=False):
        self.wait_for_viewer = wanted
        self.headless, self.hardware = headless, hardware


class Terminal(io.StringIO):
    def isatty(self):
        return True


def test_only_a_terminal_makes_a_run_wait_unasked(monkeypatch):
    monkeypatch.setattr(sys, "stdin", io.StringIO())
    assert not is_waited_for(Arguments())
    assert is_waited_for(Arguments(wanted=True))
    monkeypatch.setattr(sys, "stdin", Terminal())
    assert is_waited_for(Arguments())
    assert not is_waited_for(Arguments(wanted=False))
    assert not is_waited_for(Arguments(headless=True))
    assert not is_waited_for(Arguments(hardware=True))


@pytest.mark.parametrize("flag", ["headless", "hardware"])
def test_no_run_waits_where_no_page_starts_it(flag):
    with pytest.raises(RemoSplatError, match="--wait-for-viewer: a r"):
        is_waited_for(Arguments(wanted=True, **{flag: True}))


def test_a_refused_wait_is_one_line(capsys):
    assert main(["run", "TableReach", "--headless", "--wait-for-viewer"]) == 2
    said = capsys.readouterr().err
    assert said == (
        "remosplat: --wait-for-viewer: a run with --headless has no page; "
        "leave one of the two out\n"
    )


def test_start_begins_the_run_and_gives_the_page_back(monkeypatch):
    monkeypatch.setattr(sys, "stdin", io.StringIO())
    page = MeshcatPage()
    page.show(unsupervised())
    seen = []

    def press(*_):
        seen.append(page.state)
        click(page.meshcat, BUTTONS[START])

    text = io.StringIO()
    console = Console(file=text, width=200)
    monkeypatch.setattr(hold.time, "sleep", press)
    wait_for_start(page, "TableReach", console)
    assert [state.phase for state in seen] == [WAITING]
    assert page.state == unsupervised()
    assert "press Start; Ctrl-C" in text.getvalue()
