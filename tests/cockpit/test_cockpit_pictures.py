"""The cockpit in all its states looks as it shall, on every screen."""

import numpy as np
import pytest

pytest.importorskip("viser")
pytest.importorskip("PIL")

from browser import find_chromium, open_browser
from cockpit_rig import AT_REST, RUNNING, Rig
from cockpit_tab import DRAW_NOTHING, CockpitTab
from page_pictures import Gallery, darkness

from remosplat_drake.cockpit.offers import HIGHER, NEARER
from remosplat_drake.signals.thing import SOLID
from remosplat_drake.visualization.page_state import (
    HELD,
    STOP,
    PageState,
    without_map,
)

LIT = 0.001, 0.02
"""Share of black in a scene that is drawn, and lit by its surroundings."""

IS_HELD = PageState(
    HELD,
    "Held",
    "hand held 21 mm from the can, 0.12 m from the target: move or turn the"
    " target",
    (STOP,),
)


@pytest.mark.slow
@pytest.mark.browser
@pytest.mark.skipif(
    find_chromium() is None, reason="needs chromium on the PATH"
)
def test_the_cockpit():
    rig = Rig(solids=True)
    with open_browser() as tab:
        # What lights the scene is drawn once, when it has been loaded.
        tab.run_first(DRAW_NOTHING + "window.draws = true;")
        client = CockpitTab(tab, rig.url)
        rig.until(lambda: LIT[0] < darkness(tab) < LIT[1])
        gallery = Gallery(tab, "cockpit")

        def see(name: str, target: str, *buttons: str, **changes):
            # A clock that goes back has no ratio to real time.
            time = rig.content.time - 1.0
            rig.show(target=target, time=time, **changes)
            client.wait_for_text(f"Target {target}")
            for button in buttons:
                client.wait_for_button(button)
            gallery.take(name)

        see("watching", "following the cockpit")
        none_yet = {"state": without_map(RUNNING), "map": "none yet"}
        see("without_map", "hold: start", **none_yet)
        client.operate(rig.code)
        see("operating", "hold", state=RUNNING, map="version 1: 4 frames")
        see("stopped", "hold: stopped", "RELEASE", state=AT_REST)
        # Its target is in the table, so that it has offers.
        X_WT = np.array(rig.content.X_WT)
        X_WT[:3, 3] = 1.1, 0.0, 0.44
        see(
            "held",
            "following the cockpit",
            HIGHER,
            NEARER,
            state=IS_HELD,
            cause=SOLID,
            X_WT=X_WT,
            p_WHeld=X_WT[:3, 3] + [0, 0, 0.05],
            held_link="panda_hand",
        )
        assert client.errors == []
    rig.process.close()
