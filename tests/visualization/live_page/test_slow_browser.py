"""A browser that draws two pictures a second sees what is so now."""

import time

import numpy as np
import pytest
from browser import Browser, find_chromium, open_browser
from pydrake.geometry import Box
from pydrake.math import RigidTransform

from remosplat_drake.visualization.page import MeshcatPage
from remosplat_drake.visualization.page_state import (
    LIVE,
    STOP,
    PageState,
    ended,
    waiting,
)
from remosplat_drake.visualization.saved_page.account import Account
from remosplat_drake.visualization.toggle import on_off

FRAME = 0.5
"""Time that the browser takes for a picture [s]."""

LAG = 3
"""Pictures that a page may be behind."""

pytestmark = [
    pytest.mark.slow,
    pytest.mark.browser,
    pytest.mark.skipif(
        find_chromium() is None, reason="needs chromium on the PATH"
    ),
]

SLOW = f"""addEventListener('DOMContentLoaded', () => {{
  window.pictures = [];
  viewer.render = () => {{
    const begun = performance.now();
    const thing = viewer.scene_tree.find(['remosplat', 'thing']).object;
    pictures.push(thing.position.x);
    viewer.needs_render = false;
    while (performance.now() - begun < {1000 * FRAME});
  }};
}})"""
"""Each picture takes that long; kept is what is drawn on it."""

THING = "/remosplat/thing"
BAR = "document.querySelector('#bar').innerText"
X = "viewer.scene_tree.find(['remosplat', 'thing']).object.position.x"


def open_slowly(tab: Browser, page: MeshcatPage):
    page.meshcat.SetObject(THING, Box(0.1, 0.1, 0.1))
    tab.run_first(SLOW)
    tab.open(page.url)
    tab.wait_for("window.pictures?.length > 1")


def moving(number: int) -> PageState:
    return PageState(LIVE, "Live", f"at {number} mm", (STOP,))


class Drive:
    """A thing that moves on, and a page that says where it is."""

    def __init__(self, page: MeshcatPage):
        self._page, self.number = page, 0

    def go_on(self, seconds: float):
        """As a run does, 32 times a second, with shapes now and then."""
        for _ in range(round(32 * seconds)):
            self.number += 1
            self._page.beat()
            x = 0.001 * self.number
            X_WT = RigidTransform([x, 0.0, 0.0])
            self._page.scene.move(THING, X_WT, self.number / 32)
            self._page.show(moving(self.number))
            if self.number % 8 == 0:
                points = np.array([[0, 0, 0], [x, 0, 1]]).T
                self._page.meshcat.SetLineSegments(
                    "/remosplat/line", points, points
                )
            time.sleep(1 / 32)


def test_a_slow_browser_is_a_few_pictures_behind_and_no_more(page):
    with open_browser((600, 400)) as tab:
        open_slowly(tab, page)
        drive = Drive(page)
        page.start_recording()
        drive.go_on(8.0)
        # A message for each picture of 8 s would take 128 s.
        end = tab.evaluate("pictures.length")
        latest = 0.001 * drive.number
        tab.wait_for(f"Math.abs({X} - {latest}) < 1e-6")
        tab.wait_for(f"pictures.at(-1) > {latest} - 1e-6")
        assert tab.evaluate("pictures.length") - end <= LAG
        tab.wait_for(f"{BAR}.includes('at {drive.number} mm')")


def test_the_verdict_comes_before_the_recording(page):
    """The page says it two pictures after the end at the latest."""
    with open_browser((600, 400)) as tab:
        open_slowly(tab, page)
        drive = Drive(page)
        page.start_recording()
        drive.go_on(4.0)
        before = tab.evaluate("pictures.length")
        page.end(ended("in 4.0 s", reached=True))
        page.finish_recording()
        tab.wait_for(f"{BAR}.includes('Reached')")
        assert tab.evaluate("pictures.length") - before <= LAG
        tab.wait_for("document.documentElement.dataset.buttons === ''")


def test_a_picture_that_grows_old_says_so(page):
    with open_browser((600, 400)) as tab:
        tab.draw_nothing()
        tab.open(page.url)
        Drive(page).go_on(0.2)
        # Now the control loop hangs.
        age = "document.querySelector('#age').innerText"
        tab.wait_for(f"parseFloat({age}) > 1 && {age}.endsWith('s old')")
        page.end(ended("interrupted", reached=False))
        tab.wait_for(f"{age} === ''")


def test_a_verdict_stays_when_the_program_has_ended():
    page = MeshcatPage()
    with open_browser((600, 400)) as tab:
        tab.draw_nothing()
        tab.open(page.url)
        page.show(moving(1))
        page.end(ended("in 3.2 s", reached=True))
        tab.wait_for(f"{BAR}.includes('in 3.2 s')")
        del page
        tab.wait_for(f"{BAR}.includes('the program has ended')")
        assert tab.evaluate(f"{BAR}.includes('Reached')")
        assert "reconnect" not in tab.evaluate("document.body.innerText")


def test_start_goes_when_nothing_hears_it():
    page = MeshcatPage()
    start = "document.querySelector('.remosplat-start')?.offsetHeight"
    with open_browser((600, 400)) as tab:
        tab.draw_nothing()
        tab.open(page.url)
        page.show(waiting("TableReach"))
        tab.wait_for(f"{start} > 30")
        del page
        tab.wait_for(f"{start} === 0 && {BAR}.includes('no connection')")


def test_a_run_is_played_where_it_was_watched(page):
    """Result, plot and events are those of the saved page."""
    clock = "parseFloat(document.querySelector('#clock').textContent)"
    with open_browser((1000, 700)) as tab:
        tab.draw_nothing()
        tab.listen_to_console()
        tab.open(page.url)
        page.meshcat.SetObject(THING, Box(0.1, 0.1, 0.1))
        page.start_recording()
        times = np.linspace(0.0, 2.0, 65)
        for t in times:
            page.scene.move(THING, RigidTransform([t, 0, 0]), t)
        state = ended("in 2.0 s", reached=True)
        page.end(state)
        page.finish_recording()
        account = Account(
            state,
            times,
            times[:, None],
            0.3 - 0.1 * times,
            0.02,
            0.5,
            facts=[("path", "2.0 m")],
        )
        page.set_account(account)
        tab.wait_for(f"{clock} == 2")
        text = tab.evaluate("document.body.innerText")
        for told in ("2.0 m", "nearest to the scene: 100 mm"):
            assert told in text
        tab.click("#play")
        tab.wait_for(f"{X} < 1.5")
        tab.wait_for(f"{clock} == 2")
        assert tab.console() == []


def test_a_view_goes_along_with_what_it_looks_at(page):
    camera = "viewer.camera.position.toArray()"
    with open_browser((1000, 700)) as tab:
        tab.draw_nothing()
        tab.open(page.url)
        hand, base = np.array([0.5, 0.0, 0.8]), np.zeros(3)
        page.set_places(hand, base, np.array([0.9, 0.0, 0.8]))
        # Where the page looks from at first.
        tab.wait_for(f"window.viewer && Math.abs({camera}[0] + 1.2) < 1e-6")
        tab.click("#views button", text="both")
        tab.wait_for(f"Math.abs({camera}[0] - 0.7) < 1e-3")
        # Beside the line from hand to target, and above it; y is up there.
        before = np.array(tab.evaluate(camera))
        assert before[1] > 1.2 and abs(before[2]) > 0.9
        higher = np.array([0.5, 0.0, 1.0])
        page.set_places(higher, base, np.array([0.9, 0.0, 1.0]))
        tab.wait_for(f"Math.abs({camera}[1] - {before[1] + 0.2}) < 1e-3")
        tab.click("#views button", text="free")
        page.set_places(hand, base, None)
        pressed = "document.querySelector('[aria-pressed=true]').innerText"
        tab.wait_for(f"{pressed} === 'free'")
        after = np.array(tab.evaluate(camera))
        assert after[1] == pytest.approx(before[1] + 0.2, abs=1e-3)


def test_each_onlooker_hides_things_for_himself(page):
    """A button says what it shows, and works when the program has ended."""
    shown = "viewer.scene_tree.find(['remosplat', 'truth']).object.visible"
    with open_browser((1000, 700)) as tab:
        page.meshcat.SetObject("/remosplat/truth", Box(0.1, 0.1, 0.1))
        page.add_toggle(on_off("Truth", "3", "/remosplat/truth", shown=False))
        tab.draw_nothing()
        tab.open(page.url)
        state = "document.querySelector('#scene output')?.innerText"
        tab.wait_for(f"{state} === 'off' && {shown} === false")
        tab.click("#scene button")
        tab.wait_for(f"{state} === 'on' && {shown}")
        tab.press("3")
        tab.wait_for(f"{state} === 'off' && !{shown}")
