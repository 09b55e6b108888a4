"""The page of a run in all its states looks as it shall, on every screen."""

import itertools
import socket
from collections.abc import Callable, Iterator

import pytest

pytest.importorskip("PIL")

from browser import find_chromium, open_browser
from page_messages import click
from page_pictures import FEW, FOLDER, Gallery, unlike
from PIL import Image

from remosplat_drake.app.simulation import run as simulate
from remosplat_drake.cockpit.offers import BACK_OFF, HIGHER, NEARER
from remosplat_drake.cockpit.page_offers import BUTTONS as OFFERS
from remosplat_drake.commands import driving
from remosplat_drake.commands import run as run_command
from remosplat_drake.commands.main import main
from remosplat_drake.visualization import page_state
from remosplat_drake.visualization.page import MeshcatPage
from remosplat_drake.visualization.page_state import RELEASE, STOP, waiting
from remosplat_drake.visualization.page_style import BUTTONS

TARGET = (
    "{targets: [{translation: [1.15, 0.0, 0.5], rpy_deg: [180, 0, 0]}],"
    " controller: {guidance: {enabled: false}}, time_limit: 60}"
)
"""Inside of the table, until an operator takes an offer."""


class Visit:
    """A person at the page of a run: stops it, and takes an offer."""

    def __init__(self, gallery: Gallery):
        self._gallery = gallery
        self._page: MeshcatPage | None = None
        self._steps = self._visit()

    def starts(self, page: MeshcatPage, goal: str, _):
        """Opens the page before START."""
        self._page = page
        page.show(waiting(goal))
        tab = self._gallery.tab
        tab.open(page.url)
        tab.wait_for("!!document.querySelector('.remosplat-start')")
        self._see("ready")

    def drives(self, application, on_progress: Callable, **arguments):
        """Looks at the page after every step of the run."""
        assert self._page is not None

        def look(time, *told):
            on_progress(time, *told)
            self._time = time
            next(self._steps, None)

        return simulate(application, on_progress=look, **arguments)

    def _visit(self) -> Iterator[None]:
        page = self._page
        assert page is not None and page.state is not None
        while self._time < 0.7:
            yield
        self._see("live")
        while not self._offers() >= {BACK_OFF, HIGHER, NEARER}:
            yield
        self._see("held")
        click(page.meshcat, BUTTONS[STOP])
        # Shown at once; the offers go a moment later.
        while page.state.title != "Stopped" or self._offers():
            yield
        self._see("stopped")
        click(page.meshcat, BUTTONS[RELEASE])
        while HIGHER not in self._offers():
            yield
        click(page.meshcat, OFFERS[HIGHER])

    def _offers(self) -> set[str]:
        """The offers on the page."""
        assert self._page is not None
        names = self._page.meshcat.GetButtonNames()
        return {offer for offer, name in OFFERS.items() if name in names}

    def ends(self, *_):
        """Sees the result."""
        assert self._page is not None and self._page.state is not None
        assert self._page.state.phase == page_state.REACHED
        self._gallery.tab.wait_for(
            "parseFloat(document.querySelector('#clock').textContent) > 1"
        )
        self._see("reached")

    def _see(self, state: str):
        assert self._page is not None and self._page.state is not None
        self._page.scene.settle()
        bar = self._page.state.title
        self._gallery.tab.wait_for(
            f"document.querySelector('#bar b').innerText == '{bar}'"
        )
        self._gallery.take(state)


@pytest.mark.parametrize("prefix", ["run", "cockpit"])
def test_no_two_states_look_alike(prefix):
    kept = [Image.open(path) for path in FOLDER.glob(f"{prefix}_*.webp")]
    assert len(kept) >= 5
    for one, other in itertools.combinations(kept, 2):
        assert unlike(one, other) > FEW


@pytest.mark.slow
@pytest.mark.browser
@pytest.mark.skipif(
    find_chromium() is None, reason="needs chromium on the PATH"
)
def test_the_page_of_a_run(monkeypatch, tmp_path):
    with socket.socket() as probe:
        probe.bind(("localhost", 0))
        port = probe.getsockname()[1]
    with open_browser() as tab:
        tab.listen_to_console()
        visit = Visit(Gallery(tab, "run"))
        monkeypatch.setattr(run_command, "wait_for_start", visit.starts)
        monkeypatch.setattr(driving, "simulate", visit.drives)
        monkeypatch.setattr(run_command, "hold", visit.ends)
        saved = tmp_path / "run.html"
        command = (
            *("run", "TableReach", "--wait-for-viewer", "--hold"),
            *("--port", str(port), "--scenario-text", TARGET),
            *("--save-html", str(saved)),
        )
        assert main(command) == 0
        tab.open(saved.resolve().as_uri())
        line = "document.querySelector('#time')"
        tab.wait_for(f"parseFloat({line}?.max) > 1")
        # Dragging the time line ends the playing.
        tab.evaluate(
            f"{line}.value = 1; {line}.dispatchEvent(new Event('input'))"
        )
        Gallery(tab, "run").take("saved")
        assert tab.console() == []
