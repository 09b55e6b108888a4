"""The cockpit in a real browser: watching, operating, and the picture."""

import numpy as np
import pytest

pytest.importorskip("viser")

import viser
from browser import find_chromium, open_browser
from cockpit_rig import AT_REST, RUNNING, Rig
from cockpit_tab import OF_VISER, CockpitTab, open_cockpit

from remosplat_drake.cockpit.ghost import COLOURS
from remosplat_drake.cockpit.reach import REACHABLE
from remosplat_drake.robot.pose_error import pose_error

pytestmark = [
    pytest.mark.browser,
    pytest.mark.skipif(
        find_chromium() is None, reason="needs chromium on the PATH"
    ),
]

OPERATORS_OWN = {"Hold", "Go home", "Scan", "Undo", "Hand over"}
TABLE = (200, 330)
"""Where the floor before the table is in the picture [px]."""


def test_a_watcher_may_stop_and_nothing_else(rig):
    with open_cockpit(rig.url) as watcher:
        assert not OPERATORS_OWN & set(watcher.buttons)
        assert "RELEASE" not in watcher.buttons
        stops, moves = rig.requests.operator.stops, rig.requests.command.moves
        watcher.press("STOP")
        rig.until(lambda: rig.requests.operator.stops == stops + 1)
        rig.show(state=AT_REST)
        watcher.wait_for_text("stop button")
        assert "RELEASE" not in watcher.buttons
        watcher.click_at(*TABLE)
        watcher.key("Escape", "Escape")
        rig.until(lambda: rig.requests.operator.stops == stops + 2)
        assert "Go there" not in watcher.buttons
        # Nor does a wrong code make an operator of it.
        watcher.type_code("AAAA-AAAA")
        watcher.wait_for_text("not the code that the terminal shows")
        assert not OPERATORS_OWN & set(watcher.buttons)
        assert rig.requests.command.moves == moves
        assert watcher.errors == []


@pytest.mark.slow
def test_an_operator_operates_and_leaves(rig):
    with open_cockpit(rig.url) as operator:
        operator.operate(rig.code)
        presses_count(operator, rig)
        proposes(operator, rig)
        drags(operator, rig)
        stops_and_releases(operator, rig)
        assert operator.errors == []
        with open_cockpit(rig.url) as second:
            second.type_code("AAAA-AAAA")
            second.wait_for_text("another browser operates")
        holds, issued = rig.requests.command.holds, len(rig.codes)
    # It has closed its page: the target holds, and another code is issued.
    rig.until(lambda: len(rig.codes) == issued + 1)
    rig.until(lambda: rig.requests.command.holds == holds + 1)
    assert "left" in rig.codes[-1].why


def presses_count(operator: CockpitTab, rig: Rig):
    """Buttons and their keys."""
    before = rig.requests
    operator.press("Hold")
    rig.until(lambda: rig.requests.command.holds == before.command.holds + 1)
    operator.key("KeyH", "h")
    rig.until(lambda: rig.requests.command.holds == before.command.holds + 2)
    operator.press("→ over the table")
    rig.until(lambda: rig.requests.command.pose == "over the table")
    operator.press("Scan")
    rig.until(lambda: rig.requests.command.scans == before.command.scans + 1)
    operator.key("KeyM", "m")
    frames = before.map_requests.frames
    rig.until(lambda: rig.requests.map_requests.frames == frames + 1)
    operator.press("Put or take an object")
    rig.until(lambda: rig.requests.scene_changes == before.scene_changes + 1)
    moves = rig.requests.command.moves
    operator.key("KeyW", "w")
    rig.until(lambda: rig.requests.command.moves == moves + 1)
    X_WT = rig.requests.command.X_WT
    assert X_WT is not None
    step = X_WT[:3, 3] - rig.content.X_WT[:3, 3]
    np.testing.assert_allclose(step, [0.005, 0, 0], atol=1e-6)


def proposes(operator: CockpitTab, rig: Rig):
    """A click on a surface moves nothing before the operator agrees."""
    moves = rig.requests.command.moves
    operator.click_at(*TABLE)
    operator.wait_for_button("Go there")
    operator.wait_for_text("Reachable")
    background = operator.tab.evaluate(
        "getComputedStyle([...document.querySelectorAll('div')].filter(d =>"
        " d.innerText.startsWith('Reachable')).at(-1)).backgroundColor"
    )
    assert background == f"rgb{COLOURS[REACHABLE]}"
    assert rig.requests.command.moves == moves
    operator.press("Discard")
    operator.wait_without_button("Go there")
    operator.click_at(*TABLE)
    operator.wait_for_button("Go there")
    operator.press("Go there")
    rig.until(lambda: rig.requests.command.moves == moves + 1)
    X_WT = rig.requests.command.X_WT
    assert X_WT is not None
    # Before the floor, along its normal, at its distance from it.
    np.testing.assert_allclose(X_WT[:3, 2], [0, 0, -1], atol=0.05)
    assert abs(X_WT[2, 3] - (rig.job.stopping + 0.05)) < 0.03
    rig.follow()


def drags(operator: CockpitTab, rig: Rig):
    """The gizmo's middle, dragged across the picture."""
    moves, before = rig.requests.command.moves, rig.requests.command.X_WT
    assert before is not None
    x, y = TABLE
    tab = operator.tab
    # The gizmo stands above the place that was clicked at: an arrow or the
    # middle of it is below one of these points.
    for dy in range(0, -60, -4):
        tab._mouse("mouseMoved", [x, y + dy])
        tab._mouse("mousePressed", [x, y + dy])
        for k in range(1, 6):
            tab._mouse("mouseMoved", [x + 8 * k, y + dy - 6 * k])
        tab._mouse("mouseReleased", [x + 40, y + dy - 30])
        if rig.requests.command.moves > moves:
            break

    def has_moved() -> bool:
        after = rig.requests.command.X_WT
        assert after is not None
        error = pose_error(before, after)
        return error.distance > 1e-3 or error.angle > 1e-3

    rig.until(has_moved)


def stops_and_releases(operator: CockpitTab, rig: Rig):
    stops, releases = (
        rig.requests.operator.stops,
        rig.requests.operator.releases,
    )
    assert "RELEASE" not in operator.buttons
    operator.press("STOP")
    rig.until(lambda: rig.requests.operator.stops == stops + 1)
    rig.show(state=AT_REST)
    operator.wait_for_button("RELEASE")

    def lets_go() -> bool:
        # A slip releases nothing. On a busy computer the time to confirm may
        # be over before the second click, so RELEASE is pressed again.
        assert rig.requests.operator.releases == releases
        pressed = operator.press_any("Let the robot go", "RELEASE")
        return pressed == "Let the robot go"

    rig.until(lets_go)
    rig.until(lambda: rig.requests.operator.releases == releases + 1)
    rig.show(state=RUNNING)
    operator.wait_without_button("RELEASE")


@pytest.mark.slow
def test_who_hands_over_operates_no_more(rig):
    with open_cockpit(rig.url) as operator:
        operator.operate(rig.code)
        operator.press("Hand over")
        operator.wait_for_button("Operate")
        operator.wait_without_button("Hold")
        rig.until(lambda: "handed over" in rig.codes[-1].why)
        # The same browser may come back with the new code.
        operator.operate(rig.code)


@pytest.mark.slow
def test_what_is_left_out_of_the_errors_is_visers_own():
    """A Gaussian, and no code of ours: when this fails, leave nothing out."""
    server = viser.ViserServer(host="127.0.0.1", port=0, verbose=False)
    one = np.ones((1, 3))
    server.scene.add_gaussian_splats(
        "/one",
        centers=one,
        covariances=0.01 * np.eye(3)[None],
        rgbs=one,
        opacities=one[:, :1],
    )
    with open_browser((400, 300)) as tab:
        tab.listen_to_console()
        tab.open(f"http://127.0.0.1:{server.get_port()}")
        tab.wait_for("window.wrong?.length > 0")
        assert tab.console() == [OF_VISER]
    server.stop()


@pytest.mark.slow
def test_on_an_upright_phone_the_panel_is_a_sheet_that_folds(rig):
    """It leaves more than half of the screen to the scene, and STOP."""
    size = (390, 844)
    title = '[style*="3.5em"][style*="font-weight: 400"]'
    scene = "document.querySelector('canvas[data-engine]')"
    bottom = f"{scene}.getBoundingClientRect().bottom"
    with open_cockpit(rig.url, size) as watcher:
        tab = watcher.tab
        tab.show_as(*size, mobile=True)
        tab.wait_for(f"{bottom} > {0.5 * size[1]}")
        tab.wait_for(f"{bottom} < {0.65 * size[1]}")
        covered = f"document.elementFromPoint({0.5 * size[0]}, {bottom} - 20)"
        assert tab.evaluate(f"{covered}.contains({scene})")
        tab.click(title)
        tab.wait_for(f"{bottom} > {0.75 * size[1]}")
        watcher.wait_for_stop_in_sight(size)
        stops = rig.requests.operator.stops
        watcher.press("STOP")
        rig.until(lambda: rig.requests.operator.stops == stops + 1)
        tab.click(title)
        tab.wait_for(f"{bottom} < {0.65 * size[1]}")
        assert watcher.errors == []
