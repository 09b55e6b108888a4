"""The large picture of the wrist camera."""

import numpy as np

from remosplat_drake.cockpit.wrist_monitor import ahead_of, with_crosshair


def test_the_crosshair_is_in_the_middle_and_seen_on_any_ground():
    for ground in (0, 255):
        rgb = np.full((100, 160, 3), ground, np.uint8)
        marked = with_crosshair(rgb)
        assert (marked[50, 80] == 255 - ground).all()
        rows, columns, _ = np.nonzero(marked != rgb)
        assert (rows.min() + rows.max(), columns.min() + columns.max()) == (
            100,
            160,
        )
        assert np.ptp(rows) < 20 and np.ptp(columns) < 20


def test_the_distance_is_that_of_the_middle():
    depth = np.full((100, 160), 2.0, np.float32)
    depth[48:53, 78:83] = 0.4
    assert "0.40 m ahead" in ahead_of(depth)
    depth[45:56, 75:86] = 0.0
    assert "nothing ahead" in ahead_of(depth)
