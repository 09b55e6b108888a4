"""`SvgPlot`: a small plot over time as an inline SVG.

The SVG becomes part of a label on the page, so it contains neither apostrophes
nor backslashes. It has only a few kilobytes, since it is sent several times per
second.
"""

import dataclasses as dc
from functools import cached_property

import numpy as np

from remosplat_drake.visualization.page_style import escaped

WIDTH, HEIGHT = 380, 132
"""Default size of a whole plot [px]."""

_LEFT, _RIGHT, _TOP, _BOTTOM = 46, 14, 34, 26
_INK, _GREY, _FAINT = "#1f2933", "#66717f", "#dfe4ea"


@dc.dataclass(frozen=True)
class Mark:
    """A horizontal line in a plot, such as a threshold.

    Attributes:
        value: Value at which the line is drawn, in the unit of the plot.
        text: Meaning of the line.
        color: Colour of the line, as a CSS colour.
    """

    value: float
    text: str
    color: str


@dc.dataclass(frozen=True)
class SvgPlot:
    """One curve over time, with axes, units and marks.

    Attributes:
        title: Text above the curve.
        unit: Unit of the values.
        lower: Lower end of the axis of values.
        upper: Upper end of the axis of values; values beyond the ends are
            drawn at the ends.
        marks: Horizontal lines in the plot, such as thresholds.
        color: Colour of the curve, as a CSS colour.
        span: Length of the time axis [s].
        elapsed: Whether the time axis runs from 0 to `span`, with a cursor line
            that a script may move. Otherwise, the time axis shows the last
            `span` seconds.
        width: Width of the whole plot [px].
        height: Height of the whole plot [px].
        digits: Number of decimals of the displayed latest value.
    """

    title: str
    unit: str
    lower: float
    upper: float
    marks: tuple[Mark, ...] = ()
    color: str = "#2f6fb3"
    span: float = 20.0
    elapsed: bool = False
    width: int = WIDTH
    height: int = HEIGHT
    digits: int = 3

    def draw(self, time: np.ndarray, value: np.ndarray) -> str:
        """Returns the plot as the text of an SVG element.

        Args:
            time: Ages of the values, decreasing, shape (n,) [s]. If `elapsed`
                is set, times of the values instead, increasing.
            value: The values, shape (n,); the curve has gaps where they are
                NaN.
        """
        latest = float(value[-1]) if len(value) else float("nan")
        parts = [
            f'<svg width="{self.width}" height="{self.height}"'
            f' viewBox="0 0 {self.width} {self.height}" style="display:block;'
            'font:11px sans-serif;text-shadow:none">',
            f'<rect width="{self.width}" height="{self.height}" rx="8"'
            ' fill="#fff" fill-opacity=".9"/>',
            _text(14, 21, f"{self.title} [{self.unit}]", _INK, weight=600),
            ""
            if self.elapsed
            else _text(self._end, 21, self._number(latest), _INK, "end", 600),
            self._axes,
            # The texts are drawn before the curve, since their white rim must
            # not hide it.
            self._marks,
            self._curve(time, value),
            self._cursor if self.elapsed else "",
            "</svg>",
        ]
        return "".join(parts)

    def _number(self, value: float) -> str:
        if np.isnan(value):
            return "unknown"
        if value > self.upper:
            return f"over {self.upper:g} {self.unit}"
        return f"{value:.{self.digits}f} {self.unit}"

    @property
    def _end(self) -> int:
        """Horizontal position of the end of the time axis [px]."""
        return self.width - _RIGHT

    @property
    def _foot(self) -> int:
        """Vertical position of the start of the value axis [px]."""
        return self.height - _BOTTOM

    def _x(self, age: np.ndarray | float) -> np.ndarray:
        share = np.asarray(age) / self.span
        if self.elapsed:
            share = 1 - share
        return self._end - share * (self._end - _LEFT)

    def _y(self, value: np.ndarray | float) -> np.ndarray:
        value = np.clip(np.asarray(value), self.lower, self.upper)
        share = (value - self.lower) / (self.upper - self.lower)
        return self._foot - share * (self._foot - _TOP)

    @cached_property
    def _axes(self) -> str:
        parts = []
        for tick in round_numbers(self.lower, self.upper, 4):
            y = float(self._y(tick))
            parts.append(_line(_LEFT, y, self._end, y, _FAINT))
            parts.append(_text(_LEFT - 6, y + 4, f"{tick:g}", _GREY, "end"))
        for tick in round_numbers(0.0, self.span, 4):
            x = float(self._x(tick))
            label = f"−{tick:g} s" if tick else "now"
            anchor = "middle" if tick else "end"
            if self.elapsed:
                label, anchor = f"{tick:g} s", "middle"
            parts.append(_text(x, self.height - 9, label, _GREY, anchor))
        return "".join(parts)

    @cached_property
    def _marks(self) -> str:
        parts = []
        for mark in self.marks:
            y = float(self._y(mark.value))
            parts.append(_line(_LEFT, y, self._end, y, mark.color, "5 3"))
            # The text of a line at the bottom is written below the line.
            aside = 12 if mark.value <= 0 else -4
            parts.append(_text(_LEFT + 6, y + aside, mark.text, mark.color))
        return "".join(parts)

    @property
    def _cursor(self) -> str:
        return (
            f'<line class="cursor" y1="{_TOP}" y2="{self._foot}"'
            f' x1="{_LEFT}" x2="{_LEFT}" stroke="{_INK}" stroke-width="1.5"'
            f' data-left="{_LEFT}" data-right="{self._end}"'
            f' data-end="{self.span:g}"/>'
        )

    def _curve(self, age: np.ndarray, value: np.ndarray) -> str:
        shown = (age <= self.span) & ~np.isnan(value)
        begins = shown & ~np.append(False, shown[:-1])
        x, y = self._x(age), self._y(value)
        # Lists are used, since they are formatted faster than arrays.
        rows = zip(
            begins[shown].tolist(),
            x[shown].tolist(),
            y[shown].tolist(),
            strict=True,
        )
        steps = [f"{'M' if m else 'L'}{a:.1f} {b:.1f}" for m, a, b in rows]
        return (
            f'<path d="{"".join(steps)}" fill="none" stroke="{self.color}"'
            ' stroke-width="1.8" stroke-linejoin="round"/>'
        )


def round_numbers(lower: float, upper: float, most: int) -> np.ndarray:
    """Returns the ticks of an axis, at multiples of 1, 2 or 5 times 10^n.

    Args:
        lower: Lower end of the axis.
        upper: Upper end of the axis, above the lower one.
        most: Upper limit of the number of intervals between ticks.
    """
    rough = (upper - lower) / most
    power = 10.0 ** np.floor(np.log10(rough))
    step = next(
        power * m for m in (1, 2, 5, 10) if power * m >= rough * (1 - 1e-9)
    )
    first = np.ceil(lower / step - 1e-9)
    last = np.floor(upper / step + 1e-9)
    # Adding zero turns -0.0 into 0.0.
    return np.round(step * np.arange(first, last + 1), 12) + 0.0


def _text(
    x: float,
    y: float,
    text: str,
    color: str,
    anchor: str = "start",
    weight: int = 400,
) -> str:
    return (
        f'<text x="{x:.0f}" y="{y:.0f}" fill="{color}"'
        f' text-anchor="{anchor}" font-weight="{weight}"'
        ' paint-order="stroke" stroke="#fff" stroke-width="2">'
        f"{escaped(text)}</text>"
    )


def _line(
    x0: float, y0: float, x1: float, y1: float, color: str, dash: str = ""
) -> str:
    dashes = f' stroke-dasharray="{dash}"' if dash else ""
    return (
        f'<line x1="{x0:.0f}" y1="{y0:.1f}" x2="{x1:.0f}" y2="{y1:.1f}"'
        f' stroke="{color}"{dashes}/>'
    )
