"""A run that waits for somebody at its page."""

import io
import sys

import pytest
from rich.console import Console

from remosplat_drake.base.errors import RemoSplatError
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
def test_nobody_waits_where_no_page_starts_a_run(flag):
    with pytest.raises(RemoSplatError, match=f"not with --{flag}"):
        is_waited_for(Arguments(wanted=True, **{flag: True}))


def test_a_refused_wait_is_one_line(capsys):
    assert main(["run", "TableReach", "--headless", "--wait-for-viewer"]) == 2
    said = capsys.readouterr().err
    assert said == "remosplat: --wait-for-viewer: not with --headless\n"


class Finger:
    """Presses Start at the third look, and remembers what it saw."""

    def __init__(self, page: MeshcatPage):
        self._page, self.phases = page, []

    def poll(self):
        assert self._page.state is not None
        self.phases.append(self._page.state.phase)
        if len(self.phases) == 3:
            name = BUTTONS[START]
            self._page.meshcat._InjectWebsocketMessage(packed_click(name))


def test_start_begins_the_run_and_gives_the_page_back(monkeypatch):
    monkeypatch.setattr(sys, "stdin", io.StringIO())
    page = MeshcatPage()
    page.show(unsupervised())
    finger = Finger(page)
    page.add_toggle(finger)
    text = io.StringIO()
    wait_for_start(page, "TableReach", Console(file=text, width=200))
    assert finger.phases == [WAITING] * 3
    assert page.state == unsupervised()
    assert "press Start; Ctrl-C" in text.getvalue()


def packed_click(name: str) -> bytes:
    """MessagePack of what Meshcat's page sends for a click."""
    text = name.encode()
    return (
        b"\x82\xa4type\xa6button\xa4name"
        + b"\xda"
        + len(text).to_bytes(2, "big")
        + text
    )
