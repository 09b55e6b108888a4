"""Consoles of commands, and tables that fit them.

In a terminal, a table is at most as wide as the terminal. In a pipe or a file,
nothing is cut and no line is broken.
"""

import textwrap
from collections.abc import Iterator

from rich import box
from rich.cells import cell_len
from rich.console import Console
from rich.table import Table as RichTable
from rich.text import Text

from remosplat_drake.base.table import Table

_ENDLESS = 10_000
"""Width of a table without a terminal [columns]."""

_GAP = 2
"""Width between two columns: padding of cells, and the line."""

_NARROWEST = 16
"""Width to which a column of text may shrink before words are broken."""


def open_console(*, stderr: bool = False, **options) -> Console:
    """Makes a console; only in a terminal it cuts and wraps texts.

    Args:
        stderr: Whether it prints to stderr, and not to stdout.
        options: Further arguments of rich's `Console`.
    """
    console = Console(stderr=stderr, **options)
    if not console.is_terminal:
        console.width = _ENDLESS
    return console


def print_table(
    console: Console, table: Table, styles: dict[str, str] | None = None
) -> None:
    """Prints a table, whole and no wider than the console.

    Long texts wrap. A table that is still too wide is printed in parts, each of
    which repeats the first column.

    Args:
        console: Console for the table.
        table: The table.
        styles: Styles of cells by their text; None for no styles.
    """
    if table.title:
        console.print(Text(table.title, "bold"))
    for columns in _pieces(table, console.width):
        console.print(_drawn(table, columns, console.width, styles or {}))
    if table.notes:
        console.print(Text(table.notes, "dim"))


def _pieces(table: Table, width: int) -> Iterator[list[int]]:
    """The columns of each piece; the first column is in all of them."""
    first, *others = (_least(table, i) for i in range(len(table.header)))
    piece, used = [0], first
    for i, least in enumerate(others, start=1):
        if len(piece) > 1 and used + _GAP + least > width:
            yield piece
            piece, used = [0], first
        piece.append(i)
        used += _GAP + least
    yield piece


def _least(table: Table, column: int) -> int:
    """Width without which a column is not readable."""
    cells = [cell_len(cells[column]) for cells in table.rows]
    words = [cell_len(word) for word in table.header[column].split()]
    widest = max([*cells, 0])
    if 0 < column < table.texts:
        widest = min(widest, _NARROWEST)
    return max([widest, *words])


def _drawn(
    table: Table, columns: list[int], width: int, styles: dict[str, str]
) -> RichTable:
    drawn = RichTable(
        show_header=any(table.header),
        box=box.SIMPLE_HEAD,
        padding=(0, 1, 0, 0),
        pad_edge=False,
        show_edge=False,
    )
    natural = sum(_natural(table, i) + _GAP for i in columns)
    for i in columns:
        heading = table.header[i]
        if natural > width:
            heading = textwrap.fill(
                heading, _least(table, i), break_long_words=False
            )
        drawn.add_column(
            Text(heading),
            justify="left" if i < table.texts else "right",
            no_wrap=not 0 < i < table.texts,
            overflow="fold",
        )
    for number, cells in enumerate(table.rows):
        row = [Text(cells[i], styles.get(cells[i], "")) for i in columns]
        drawn.add_row(*row, style="dim" if number in table.quoted else "")
    return drawn


def _natural(table: Table, column: int) -> int:
    texts = (table.header[column], *(cells[column] for cells in table.rows))
    return max(map(cell_len, texts))
