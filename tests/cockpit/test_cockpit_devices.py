"""Keys, gamepad and hand at the cockpit in a real browser, and its age."""

import numpy as np
import pytest

pytest.importorskip("viser")

from browser import find_chromium, open_browser
from cockpit_rig import AT_REST, RUNNING, Rig
from cockpit_tab import DRAW_NOTHING, CockpitTab

pytestmark = [
    pytest.mark.slow,
    pytest.mark.browser,
    pytest.mark.skipif(
        find_chromium() is None, reason="needs chromium on the PATH"
    ),
]

AGE = "document.querySelector('#age').innerText"

PAD = """
window.pad = {connected: true, axes: [0, 0, 0, 0],
  buttons: Array.from({length: 17}, () => ({value: 0}))};
window.reads = 0;
navigator.getGamepads = () => { reads += 1; return [window.pad]; };
"""
"""No event of DevTools moves a gamepad: the page reads this one."""

SLOW = """
const draw = () => {
  const end = performance.now() + 700;
  while (window.isSlow && performance.now() < end);
  requestAnimationFrame(draw);
};
draw();
"""
"""While `isSlow`, a picture takes 0.7 s."""


def test_an_old_picture_says_so(rig):
    with open_browser((600, 400)) as tab:
        tab.run_first(DRAW_NOTHING + SLOW)
        watcher = CockpitTab(tab, rig.url)
        # No moment has come for a while, and now one comes.
        tab.wait_for(f"parseFloat({AGE}) > 1 && {AGE}.endsWith('old')")
        now_and_then(watcher, rig, f"{AGE} === ''")
        # The browser falls behind, and comes back.
        tab.evaluate("window.isSlow = true")
        now_and_then(watcher, rig, f"parseFloat({AGE}) >= 0.6")
        tab.evaluate("window.isSlow = false")
        now_and_then(watcher, rig, f"{AGE} === ''")
        assert watcher.errors == []


def now_and_then(watcher: CockpitTab, rig: Rig, condition: str):
    """Tells of moments as a run does, until the page shows something."""

    def is_so() -> bool:
        rig.show(time=rig.content.time + 0.05)
        return watcher.tab.evaluate(condition)

    rig.until(is_so)


def test_an_operator_uses_keys_hand_and_gamepad(rig):
    with open_browser((600, 400)) as tab:
        tab.run_first(DRAW_NOTHING + PAD)
        operator = CockpitTab(tab, rig.url)
        leads_nothing(operator, rig)
        operator.operate(rig.code)
        keys_have_a_speed(operator, rig)
        hand_opens_and_closes(operator, rig)
        assert operator.errors == []
        gamepad_leads(operator, rig)


def leads_nothing(watcher: CockpitTab, rig: Rig):
    """A gamepad of a client that does not operate."""
    hold_button(watcher, rig.job.config.gamepad.dead_man, 1)
    before = watcher.tab.wait_for("reads")
    watcher.tab.wait_for(f"reads > {before + 5}")
    assert rig.requests.command.V_W is None
    hold_button(watcher, rig.job.config.gamepad.dead_man, 0)


def keys_have_a_speed(operator: CockpitTab, rig: Rig):
    """Slower, and faster twice: steps of 4, 5 and 6 mm."""
    operator.wait_without_button("Operate")  # Keys went into the field there.
    for key, percent, millimetres in (("Z", 40, 4), ("V", 50, 5), ("V", 60, 6)):
        operator.key(f"Key{key}", key.lower())
        operator.tab.wait_for(
            "[...document.querySelectorAll('input')]"
            f".some(e => e.value === '{percent}')"
        )
        moves, before = rig.requests.command.moves, rig.content.X_WT
        operator.key("KeyR", "r")
        rig.until(lambda moves=moves: rig.requests.command.moves == moves + 1)
        after = rig.requests.command.X_WT
        assert after is not None
        step = 1e3 * (after[:3, 3] - before[:3, 3])
        np.testing.assert_allclose(step, [0, 0, millimetres], atol=1e-3)
        rig.follow()


def hand_opens_and_closes(operator: CockpitTab, rig: Rig):
    before = rig.requests.command
    operator.press("Close hand")
    rig.until(lambda: rig.requests.command.closes == before.closes + 1)
    operator.press("Open hand")
    rig.until(lambda: rig.requests.command.opens == before.opens + 1)
    operator.key("KeyC", "c")
    rig.until(lambda: rig.requests.command.closes == before.closes + 2)
    operator.key("KeyO", "o")
    rig.until(lambda: rig.requests.command.opens == before.opens + 2)
    rig.show(state=AT_REST)
    operator.tab.wait_for(
        "[...document.querySelectorAll('button')]"
        ".find(b => b.innerText === 'Open hand').disabled"
    )
    rig.show(state=RUNNING)


def gamepad_leads(operator: CockpitTab, rig: Rig):
    """While its switch is held, at a speed that its cross changes."""
    config, tab = rig.job.config.gamepad, operator.tab
    tab.evaluate("pad.axes[1] = -1")
    hold_button(operator, config.dead_man, 1)
    rig.until(lambda: rig.requests.command.V_W is not None)
    V_W = [0, 0, 0, 0.6 * config.speed, 0, 0]
    np.testing.assert_allclose(rig.requests.command.V_W, V_W)
    hold_button(operator, 12, 1)
    faster = 0.7 * config.speed
    rig.until(lambda: abs(ahead(rig) - faster) < 1e-6)
    hold_button(operator, 12, 0)
    closes = rig.requests.command.closes
    hold_button(operator, 0, 1)
    rig.until(lambda: rig.requests.command.closes == closes + 1)
    hold_button(operator, config.dead_man, 0)
    rig.until(lambda: rig.requests.command.V_W is None)
    # Each press counted once, while it was held for many messages.
    assert rig.requests.command.closes == closes + 1

    hold_button(operator, 0, 0)
    hold_button(operator, config.dead_man, 1)
    rig.until(lambda: abs(ahead(rig) - faster) < 1e-6)
    # A page that hangs holds no switch.
    tab.evaluate("setTimeout(() => { for (;;); }), 0")
    rig.until(lambda: rig.requests.command.V_W is None)


def hold_button(tab: CockpitTab, number: int, value: float):
    tab.tab.evaluate(f"pad.buttons[{number}] = {{value: {value}}}")


def ahead(rig: Rig) -> float:
    """Speed along x that is wished for [m/s]."""
    V_W = rig.requests.command.V_W
    return 0.0 if V_W is None else V_W[3]
