"""The page about what was removed: points in their colours, and how many."""

import re

import numpy as np

from remosplat_drake.splat.cleaning.junk import (
    BEFORE,
    FLOATER,
    GIANT,
    KEPT,
    Junk,
)
from remosplat_drake.splat.cleaning.junk_page import (
    UNBOUNDED,
    junk_page,
    junk_table,
    page_path,
)


def toy(has_views: bool = False) -> Junk:
    """Six splats are kept, two are floaters, one is a giant."""
    names = [KEPT] * 6 + [FLOATER] * 2 + [GIANT]
    reason = np.array([Junk.names.index(name) for name in names], np.uint8)
    return Junk(reason, np.zeros(3), 1.0, has_views)


def test_the_table_counts_each_kind():
    rows = {row[0]: row[2:] for row in junk_table(toy()).rows}
    assert rows[FLOATER] == ("2", "22.22 %")
    assert rows[GIANT] == ("1", "11.11 %")
    assert rows["in all"] == ("3", "33.33 %")
    assert BEFORE not in rows  # The cameras are unknown.
    assert BEFORE in {row[0] for row in junk_table(toy(True)).rows}


def test_each_kind_is_drawn_in_its_colour():
    x = np.array([-2.0, -1, 0, 0, 1, 2, 3, 4, 1000])
    p_FK = np.stack([x, 0 * x, 0.1 * x], axis=1)
    page = junk_page(toy(), p_FK, "B & C.ply", upright=True)
    assert "Cleaned: B &amp; C.ply" in page and UNBOUNDED in page
    above, _ = re.findall(r"<svg.*?</svg>", page, re.DOTALL)
    dots = {
        color: re.findall(r"M(\d+) (\d+)", path)
        for path, color in re.findall(r'd="([^"]*)" stroke="([^"]*)"', above)
    }
    assert sorted(map(len, dots.values())) == [1, 2, 5]  # Two in one place.
    # The giant lies beyond the picture: at its right border.
    assert ["620", "310"] in [list(d) for ds in dots.values() for d in ds]
    assert "from above" in page
    assert "along A" in junk_page(toy(), p_FK, "B", upright=False)


def test_the_page_lies_beside_the_splat(tmp_path):
    assert page_path(tmp_path / "b.ply") == tmp_path / "b.clean.html"
