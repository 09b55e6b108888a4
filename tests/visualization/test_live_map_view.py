"""Tests of how a new map comes onto the page."""

import numpy as np
import pytest
from pydrake.common.value import Value

from remosplat_drake.oracle.point_distance import PointDistanceField
from remosplat_drake.signals.coverage import FREE, UNSEEN, Coverage
from remosplat_drake.signals.map_status import MapStatus
from remosplat_drake.signals.scene_map import SceneMap
from remosplat_drake.splat.gaussian_splat import GaussianSplat
from remosplat_drake.splat.surfel_tiles import make_tiles
from remosplat_drake.visualization.live_map_view import (
    TILES,
    LiveMapView,
)
from remosplat_drake.visualization.unseen_space import UNSEEN_SPACE


def map_of(version: int, tiles: int, layers: int = 0) -> SceneMap:
    """A map of so many tiles of two discs, and layers of free space."""
    n = 2 * tiles
    splat = GaussianSplat(
        p_GK=np.arange(3.0 * n).reshape(n, 3),
        quaternions=np.tile([1.0, 0, 0, 0], (n, 1)),
        scales=np.full((n, 2), 0.1),
        opacities=np.ones(n),
        colors=np.full((n, 3), 0.5),
    )
    state = np.full((2, 2, 4), UNSEEN, np.uint8)
    state[0, 0, :layers] = FREE
    return SceneMap(
        version=version,
        parent=None,
        frames=(),
        time=0.0,
        field=PointDistanceField(splat.p_GK),
        splat_W=splat,
        coverage=Coverage(np.zeros(3), 0.5, state) if layers else None,
        tiles=make_tiles(splat, size=2),
    )


@pytest.fixture
def show(page):
    """Publishes a status, to a view that began with a map of three tiles."""
    view = LiveMapView(page=page, initial=map_of(0, 3), show_unseen=False)
    context = view.CreateDefaultContext()

    def _show(status: MapStatus):
        view.GetInputPort("map_status").FixValue(context, Value(status))
        view.ForcedPublish(context)

    return _show


def drawn(page) -> tuple[int, int]:
    """How many tiles and layers are on the page."""
    has = page.meshcat.HasPath
    tiles = sum(has(f"{TILES}/{i}") for i in range(20))
    return tiles, sum(has(f"{UNSEEN_SPACE}/{i}") for i in range(20))


def test_the_first_map_is_drawn_at_once(show, page):
    assert drawn(page) == (3, 0)


def test_a_new_map_comes_a_piece_at_a_time(show, page):
    status = MapStatus(map_of(1, 5, layers=3), "map 1", "the camera is silent")
    before = page.meshcat._GetPackedObject(f"{TILES}/1")
    show(status)
    assert page.meshcat._GetPackedObject(f"{TILES}/1") == before
    assert drawn(page) == (3, 0)
    assert page.status["map"] == "map 1 the camera is silent"
    show(status)
    assert page.meshcat._GetPackedObject(f"{TILES}/1") != before
    for _ in range(3):
        show(status)
    assert drawn(page) == (5, 0)
    # Four layers of which the last one has no frontier.
    for expected in (1, 2, 3, 3):
        show(status)
        assert drawn(page) == (5, expected)


def test_what_is_left_over_is_wiped_off(show, page):
    """Also where a newer map interrupts the drawing of another one."""
    full, small = MapStatus(map_of(1, 6, layers=2)), MapStatus(map_of(2, 2))
    for _ in range(12):
        show(full)
    assert drawn(page) == (6, 2)
    interrupted = MapStatus(map_of(3, 9))
    for _ in range(8):
        show(interrupted)
    assert drawn(page) == (8, 2)
    for _ in range(3):
        show(small)
    assert drawn(page) == (2, 0)


def test_unseen_space_is_hidden_to_begin_with(show, page, is_visible):
    assert is_visible(page.meshcat, TILES)
    assert not is_visible(page.meshcat, UNSEEN_SPACE)
