"""Offers at the cockpit, in a real browser: a click, and it works."""

import itertools
from functools import partial

import numpy as np
import pytest

pytest.importorskip("viser")

from browser import find_chromium, open_browser
from cockpit_rig import RUNNING, Rig
from cockpit_tab import DRAW_NOTHING, CockpitTab

from remosplat_drake.cockpit.offers import HIGHER, LABELS, LOOK_THERE, NEARER
from remosplat_drake.cockpit.reach import REACHABLE, find_reach
from remosplat_drake.signals.target import Target
from remosplat_drake.signals.thing import UNSEEN
from remosplat_drake.visualization.page_state import HELD, STOP, PageState

pytestmark = [
    pytest.mark.slow,
    pytest.mark.browser,
    pytest.mark.skipif(
        find_chromium() is None, reason="needs chromium on the PATH"
    ),
]

IS_HELD = PageState(HELD, "Held", "hand held 21 mm from unseen space", (STOP,))


def test_what_is_offered_works(rig):
    """For a target in the table, one out of reach, and a held robot."""
    with open_browser((600, 400)) as tab:
        tab.run_first(DRAW_NOTHING)
        operator = CockpitTab(tab, rig.url)
        operator.operate(rig.code)
        home = np.array(rig.content.X_WT)
        within = home.copy()
        within[:3, 3] = 1.1, 0.0, 0.44
        wants(operator, rig, within, "Blocked")
        accepts(operator, rig, HIGHER)

        beyond = home.copy()
        beyond[2, 3] = 2.0
        wants(operator, rig, beyond, "Out of reach")
        accepts(operator, rig, NEARER)

        rig.show(X_WT=home, is_followed=False)
        for label in LABELS:
            operator.wait_without_button(label)
        p_W = home[:3, 3] + [0.2, 0.1, -0.1]
        rig.show(state=IS_HELD, cause=UNSEEN, p_WHeld=p_W)
        X_WT = accepts(operator, rig, LOOK_THERE)
        ahead = X_WT[:3, :3].T @ (p_W - X_WT[:3, 3])
        np.testing.assert_allclose(ahead[:2], 0, atol=1e-3)
        rig.show(state=RUNNING, cause="", p_WHeld=None)
        assert operator.errors == []


def wants(operator: CockpitTab, rig: Rig, X_WT: np.ndarray, verdict: str):
    """Lets the operator's target be somewhere, as soon as the page takes it.

    It leaves a target alone that a person has moved just before.
    """
    numbers = itertools.count()

    def is_judged() -> bool:
        told = f"moment {next(numbers)}"
        rig.show(X_WT=X_WT, is_followed=False, target=told)
        operator.wait_for_text(told)
        rig.show(is_followed=True)
        return verdict in operator.text

    rig.until(is_judged)


def accepts(operator: CockpitTab, rig: Rig, label: str) -> np.ndarray:
    """Clicks an offer, and lets the robot go there; returns the target."""
    moves = rig.requests.command.moves
    operator.press(label)
    operator.wait_for_text("Reachable")
    operator.wait_for_button("Go there")
    assert rig.requests.command.moves == moves
    operator.press("Go there")
    rig.until(lambda: rig.requests.command.moves == moves + 1)
    X_WT = rig.requests.command.X_WT
    assert X_WT is not None
    job, content = rig.job, rig.content
    reach = partial(find_reach, job.planner, rig.picture.field, job.stopping)
    assert reach(content.q, Target(X_WT)).verdict == REACHABLE
    return X_WT
