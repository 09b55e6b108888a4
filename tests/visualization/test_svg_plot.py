"""Tests of the small plots."""

import dataclasses as dc
import re
from xml.etree import ElementTree

import numpy as np
import pytest

from remosplat_drake.visualization.svg_plot import (
    HEIGHT,
    WIDTH,
    Mark,
    SvgPlot,
    round_numbers,
)

PLOT = SvgPlot(
    title="Clearance <b>",
    unit="m",
    lower=0.0,
    upper=0.2,
    marks=(Mark(0.05, "near", "red"),),
    span=10.0,
)


def parts(svg: str, tag: str) -> list[ElementTree.Element]:
    return ElementTree.fromstring(svg).findall(tag)


def texts(svg: str) -> list[str]:
    return ["".join(t.itertext()) for t in parts(svg, "text")]


def curves(svg: str) -> list[np.ndarray]:
    """Corners of each piece of the curve, (n, 2) [px]."""
    (path,) = parts(svg, "path")
    pieces = path.attrib["d"].split("M")[1:]
    numbers = [re.findall(r"[\d.]+", piece) for piece in pieces]
    return [np.array(n, float).reshape(-1, 2) for n in numbers]


def heights(svg: str) -> dict[str, float]:
    """Heights of the ticks and marks by their texts [px]."""
    lines = [float(line.attrib["y1"]) for line in parts(svg, "line")]
    return dict(zip(["0", "0.05", "0.1", "0.15", "0.2"], lines, strict=False))


def test_axes_have_numbers_and_units():
    svg = PLOT.draw(np.array([1.0, 0.0]), np.array([0.1, 0.125]))
    assert texts(svg)[:2] == ["Clearance <b> [m]", "0.125 m"]
    assert {"0", "0.05", "0.1", "0.15", "0.2"} <= set(texts(svg))
    assert {"−10 s", "−5 s", "now", "near"} <= set(texts(svg))
    assert "'" not in svg and "\\" not in svg


def test_the_curve_lies_between_its_ticks():
    age = np.array([10.0, 5.0, 0.0])
    svg = PLOT.draw(age, np.array([0.0, 0.1, 0.2]))
    (curve,) = curves(svg)
    y = heights(svg)
    np.testing.assert_allclose(
        curve[:, 1], [y["0"], y["0.1"], y["0.2"]], atol=0.1
    )
    assert curve[1, 0] == pytest.approx(curve[[0, 2], 0].mean(), abs=0.1)
    marked = parts(svg, "line")[-1]
    assert float(marked.attrib["y1"]) == pytest.approx(y["0.05"])


def test_values_beyond_the_axis_stay_in_the_picture():
    svg = PLOT.draw(np.array([20.0, 2.0, 1.0]), np.array([0.1, -1, np.inf]))
    (curve,) = curves(svg)
    assert len(curve) == 2
    assert (curve >= 0).all() and (curve <= [WIDTH, HEIGHT]).all()
    assert "over 0.2 m" in texts(svg)


def test_it_is_as_large_as_was_asked_for():
    small = dc.replace(PLOT, width=200, height=90, digits=1)
    svg = small.draw(np.array([10.0, 0.0]), np.array([0.0, 0.2]))
    (curve,) = curves(svg)
    assert (curve >= 0).all() and (curve <= [200, 90]).all()
    assert np.ptp(curve, axis=0) == pytest.approx([140, 30], abs=0.1)
    assert "0.2 m" in texts(svg)


def test_the_unknown_is_a_gap():
    value = np.array([0.1, 0.1, np.nan, 0.1, np.nan])
    svg = PLOT.draw(np.arange(5.0)[::-1], value)
    assert [len(curve) for curve in curves(svg)] == [2, 1]
    assert "unknown" in texts(svg)


def test_nothing_is_drawn_as_axes():
    svg = PLOT.draw(np.zeros(0), np.zeros(0))
    assert curves(svg) == [] and "now" in texts(svg)


@pytest.mark.parametrize(
    ("lower", "upper", "expected"),
    [
        (0.0, 20.0, [0, 5, 10, 15, 20]),
        (-0.04, 0.2, [0, 0.1, 0.2]),
        (0.0, 0.3125, [0, 0.1, 0.2, 0.3]),
    ],
)
def test_round_numbers(lower, upper, expected):
    np.testing.assert_array_equal(round_numbers(lower, upper, 4), expected)
