"""A whole session at the cockpit with objects, in a real browser."""

import pytest

pytest.importorskip("viser")

from browser import find_chromium
from cockpit_session import insist, open_session
from cockpit_tab import CockpitTab


@pytest.mark.slow
@pytest.mark.browser
@pytest.mark.skipif(
    find_chromium() is None, reason="needs chromium on the PATH"
)
def test_an_operator_takes_a_can_and_puts_it_on_the_tray(tmp_path):
    with open_session("TableObjects", tmp_path / "session") as operator:
        insist(
            operator,
            lambda: operator.press("Take it"),
            "pick the soup can: lifts the soup can",
        )
        assert "✓ approaches the soup can" in operator.text
        operator.tab.save_picture(tmp_path / "takes.png")
        operator.wait_for_text("hold: pick the soup can: done")
        choose(operator, "tray")
        insist(
            operator,
            lambda: operator.press("Put it there"),
            "hold: place the soup can: done",
        )
        operator.tab.save_picture(tmp_path / "placed.png")


def choose(operator: CockpitTab, name: str):
    """Chooses an object of the list."""
    field = "input[value='soup can']"
    operator.tab.click(field)
    option = "[...document.querySelectorAll('[role=option]')]"
    operator.tab.wait_for(f"{option}.some(o => o.innerText == '{name}')")
    operator.tab.click("[role=option]", text=name)
