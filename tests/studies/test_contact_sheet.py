"""The sheet's layout: every picture once, in order, none cut off."""

import numpy as np
from PIL import Image

from apps.studies.scenes.contact_sheet import Section, contact_sheet

COLOURS = [(250, 0, 0), (0, 250, 0), (0, 0, 250), (250, 250, 0), (0, 250, 250)]


def section(title: str, colours) -> Section:
    pictures = [Image.new("RGB", (90, 60), c) for c in colours]
    return Section(title, "a note", [f"{c}" for c in colours], pictures)


def test_pictures_stand_in_rows_of_their_family():
    sheet = contact_sheet(
        [section("first", COLOURS[:3]), section("second", COLOURS[3:])], 2
    )
    page = np.asarray(sheet)
    boxes = []
    for colour in COLOURS:
        rows, columns = np.nonzero((page == colour).all(axis=2))
        # Only the rounded corners are missing.
        assert 0.95 * 90 * 60 < len(rows) < 90 * 60
        assert np.ptp(rows) == 59 and np.ptp(columns) == 89
        boxes.append((rows.min(), columns.min()))
    (y0, x0), (y1, x1), (y2, x2), (y3, x3), (y4, x4) = boxes
    assert y0 == y1 < y2 < y3 == y4
    assert x0 == x2 == x3 < x1 == x4
    # Below the first row of a family comes the heading of the next.
    assert y3 - y2 > y2 - y0
