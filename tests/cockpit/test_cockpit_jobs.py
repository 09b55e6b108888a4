"""A whole session at the cockpit with objects, in a real browser."""

import signal
import subprocess

import pytest

pytest.importorskip("viser")

from browser import find_chromium, open_browser
from cockpit_tab import DRAW_NOTHING, CockpitTab
from patience import PATIENCE
from runs import command_line
from test_cockpit_session import address, insist


@pytest.mark.slow
@pytest.mark.browser
@pytest.mark.skipif(
    find_chromium() is None, reason="needs chromium on the PATH"
)
def test_an_operator_takes_a_can_and_puts_it_on_the_tray(tmp_path):
    command = command_line(
        *("teleop", "TableObjects", "--session", tmp_path / "session"),
    )
    with subprocess.Popen(
        command, stderr=subprocess.PIPE, text=True
    ) as process:
        try:
            url, code = address(process)
            with open_browser((900, 900)) as tab:
                tab.run_first(DRAW_NOTHING)
                operator = CockpitTab(tab, url)
                operator.operate(code)
                insist(
                    operator,
                    lambda: operator.press("Take it"),
                    "pick the soup can: lifts the soup can",
                )
                assert "✓ approaches the soup can" in operator.text
                tab.save_picture(tmp_path / "takes.png")
                operator.wait_for_text("hold: pick the soup can: done")
                choose(operator, "tray")
                insist(
                    operator,
                    lambda: operator.press("Put it there"),
                    "hold: place the soup can: done",
                )
                tab.save_picture(tmp_path / "placed.png")
                assert operator.errors == []
            process.send_signal(signal.SIGINT)
            process.wait(PATIENCE)
        finally:
            process.kill()


def choose(operator: CockpitTab, name: str):
    """Chooses an object of the list."""
    field = "input[value='soup can']"
    operator.tab.click(field)
    option = "[...document.querySelectorAll('[role=option]')]"
    operator.tab.wait_for(f"{option}.some(o => o.innerText == '{name}')")
    operator.tab.click("[role=option]", text=name)
