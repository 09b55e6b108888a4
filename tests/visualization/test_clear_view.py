"""A view that looks for a side from which hand and target are in sight."""

import time

import numpy as np
import pytest
from browser import Browser, find_chromium, open_browser
from patience import PATIENCE

from remosplat_drake.splat.gaussian_splat import GaussianSplat
from remosplat_drake.visualization.splat_view import SplatView

pytestmark = [
    pytest.mark.slow,
    pytest.mark.browser,
    pytest.mark.skipif(
        find_chromium() is None, reason="needs chromium on the PATH"
    ),
]

HAND, TARGET = np.array([0.5, 0.0, 0.6]), np.array([1.0, 0.0, 0.6])
WALL = -0.3
"""Where a wall stands along y, between them and the view *both* [m]."""


def wall() -> GaussianSplat:
    x, z = np.meshgrid(np.arange(-1, 2.5, 0.04), np.arange(0, 2, 0.04))
    p_W = np.stack([x.ravel(), np.full(x.size, WALL), z.ravel()], axis=1)
    n = len(p_W)
    return GaussianSplat(
        p_GK=p_W,
        quaternions=np.tile((0.7071068, 0.7071068, 0.0, 0.0), (n, 1)),
        scales=np.full((n, 2), 0.02),
        opacities=np.ones(n),
        colors=np.full((n, 3), 0.5),
    )


def eye(tab: Browser) -> np.ndarray:
    """Where the page looks from, in W [m]."""
    x, y, z = tab.evaluate("viewer.camera.position.toArray()")
    return np.array([x, -z, y])


def is_behind_wall(p_W: np.ndarray) -> bool:
    return p_W[1] < WALL and p_W[2] < 2.0


def choose(tab: Browser, view: str) -> np.ndarray:
    before, end = eye(tab), time.monotonic() + PATIENCE
    # Again until it moves: the page may still be loading the discs.
    while np.linalg.norm(eye(tab) - before) < 0.1:
        assert time.monotonic() < end
        tab.evaluate(f"document.querySelector(`[data-view='{view}']`).click()")
        time.sleep(0.5)
    here, last = eye(tab), before
    while not np.array_equal(here, last):  # It glides to its place.
        time.sleep(0.2)
        here, last = eye(tab), here
    return here


def test_a_view_avoids_what_is_in_the_way(page):
    SplatView(page, wall())
    page.set_places(HAND, np.zeros(3), TARGET)
    with open_browser((900, 600)) as tab:
        tab.draw_nothing()
        tab.listen_to_console()
        tab.open(page.url)
        tab.wait_for(
            "window.viewer && viewer.scene_tree.find(['remosplat', 'splat',"
            " 'surfels']).object.children.length > 0"
        )
        assert is_behind_wall(choose(tab, "both"))
        assert not is_behind_wall(choose(tab, "clear"))

        # Now they are on the other side of it, and the view follows.
        beyond, end = np.array([0, 2 * WALL, 0]), time.monotonic() + PATIENCE
        while not is_behind_wall(eye(tab)):
            assert time.monotonic() < end
            beyond[0] = 1e-3 - beyond[0]  # The page hears of motion only.
            page.set_places(HAND + beyond, np.zeros(3), TARGET + beyond)
        assert tab.console() == []
