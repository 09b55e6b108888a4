"""The reason why a robot stands can be read on a telephone, too."""

import itertools

import pytest
from browser import find_chromium, open_browser

from remosplat_drake.visualization import page_state
from remosplat_drake.visualization.page_state import (
    RELEASE,
    STOP,
    PageState,
    ended,
)

WHY = (
    "right finger held 21 mm from the second board of the shelf, 0.37 m from"
    " the target: looking ahead found no way, planning goes on"
)
SIZES = (390, 844), (844, 390)
STATES = (
    PageState(page_state.HELD, "Held", WHY, (STOP,)),
    PageState(page_state.STOPPED, "Stopped", WHY, (STOP, RELEASE)),
    ended(WHY, reached=False),
)


@pytest.mark.browser
@pytest.mark.skipif(
    find_chromium() is None, reason="needs chromium on the PATH"
)
@pytest.mark.slow
def test_a_long_sentence_is_shown_whole(page):
    with open_browser() as tab:
        tab.draw_nothing()
        tab.open(page.url)
        for size, state in itertools.product(SIZES, STATES):
            tab.show_as(*size, mobile=True)
            page.show(state)
            text = f"document.querySelector('#bar.{state.phase} span')"
            tab.wait_for(f"!!{text}")
            release = "document.querySelector('.remosplat-release')"
            shall = str(RELEASE in state.buttons).lower()
            tab.wait_for(f"!!{release}?.offsetHeight == {shall}")
            assert tab.evaluate(f"{text}.innerText") == WHY
            # Nothing of it is cut off, or behind the button.
            tab.wait_for(
                f"{text}.scrollHeight <= {text}.clientHeight"
                f" && {text}.scrollWidth <= {text}.clientWidth"
            )
            # The button comes by Meshcat's way, the sentence by ours.
            ends = f"{text}.getBoundingClientRect().right"
            begins = (
                f"({release}?.closest('li').getBoundingClientRect().left"
                " || innerWidth)"
            )
            tab.wait_for(f"{ends} <= {begins}")
