"""`Table`, written as Markdown and as HTML, and the numbers in its cells.

A number comes with its count and its 95 % interval.
"""

import dataclasses as dc
import html

import numpy as np
from scipy.stats import binomtest, norm, sem


@dc.dataclass(frozen=True)
class Table:
    """Cells of text under headings.

    Attributes:
        title: Heading above the table.
        header: Headings of the columns; the first column is left-aligned.
        rows: Rows of cells, as many each as there are headings.
        notes: Paragraph below the table; empty for none.
    """

    title: str
    header: tuple[str, ...]
    rows: tuple[tuple[str, ...], ...]
    notes: str = ""

    def to_markdown(self) -> str:
        """Writes the heading, an aligned pipe table, and the notes."""
        widths = [
            max(3, *(len(cells[i]) for cells in (self.header, *self.rows)))
            for i in range(len(self.header))
        ]
        rule = ["-" * width for width in widths]
        rule[1:] = [f"{dashes[:-1]}:" for dashes in rule[1:]]
        lines = [f"### {self.title}", ""]
        for cells in (self.header, rule, *self.rows):
            padded = [
                cell.rjust(width) if i else cell.ljust(width)
                for i, (cell, width) in enumerate(
                    zip(cells, widths, strict=True)
                )
            ]
            lines.append("| " + " | ".join(padded) + " |")
        if self.notes:
            lines += ["", self.notes]
        return "\n".join(lines) + "\n"

    def to_html(self) -> str:
        """Writes heading, table and notes as a fragment of HTML."""

        def row(cells: tuple[str, ...], tag: str) -> str:
            inner = "".join(
                f"<{tag}>{html.escape(cell)}</{tag}>" for cell in cells
            )
            return f"<tr>{inner}</tr>"

        body = "\n".join(row(cells, "td") for cells in self.rows)
        return (
            f"<h3>{html.escape(self.title)}</h3>\n<table>\n"
            f"<thead>{row(self.header, 'th')}</thead>\n"
            f"<tbody>\n{body}\n</tbody>\n</table>\n"
            f"<p>{html.escape(self.notes)}</p>\n"
        )


def rate_interval(successes: int, count: int) -> tuple[float, float]:
    """Returns the 95 % interval of a rate (Wilson's score interval).

    It stays inside [0, 1] and is meaningful at 0 and at `count` successes.
    """
    interval = binomtest(successes, count).proportion_ci(method="wilson")
    return interval.low, interval.high


def format_rate(successes: int, count: int) -> str:
    """Formats a rate in per cent, its 95 % interval and its counts."""
    if not count:
        return "–"
    low, high = rate_interval(successes, count)
    return (
        f"{100 * successes / count:.1f} [{100 * low:.1f}, {100 * high:.1f}]"
        f" ({successes}/{count})"
    )


def format_rare(successes: int, count: int) -> str:
    """Formats counts of rare events, and the upper bound of their rate."""
    _, high = rate_interval(successes, count)
    return f"{successes}/{count} (< {100 * high:.1f} %)"


def format_mean(values: np.ndarray, decimals: int) -> str:
    """Formats a mean and half the width of its 95 % interval.

    A dash stands for the mean of nothing; one value has no interval.
    """
    if not len(values):
        return "–"
    mean = f"{np.mean(values):.{decimals}f}"
    if len(values) == 1:
        return mean
    return f"{mean} ± {norm.ppf(0.975) * sem(values):.{decimals}f}"


def format_median(values: np.ndarray, decimals: int) -> str:
    """Formats a median; a dash stands for the median of nothing."""
    return f"{np.median(values):.{decimals}f}" if len(values) else "–"
