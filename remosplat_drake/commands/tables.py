"""Makes consoles for commands, and tables that fit the console.

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
"""Width of a table if there is no terminal [columns]."""

_GAP = 2
"""Width between two columns: the padding of two cells, and a line."""

_NARROWEST = 16
"""A column of text is at least this wide. In narrower columns, words would be
broken."""


def open_console(*, stderr: bool = False, **options) -> Console:
    """Makes a console, which cuts and wraps texts only in a terminal.

    Args:
        stderr: Whether the console prints to stderr instead of stdout.
        options: Further arguments of rich's `Console`.
    """
    console = Console(stderr=stderr, **options)
    if not console.is_terminal:
        console.width = _ENDLESS
    return console


def print_table(
    console: Console, table: Table, styles: dict[str, str] | None = None
) -> None:
    """Prints a table without exceeding the console's width.

    Long texts wrap. A table that is still too wide is printed in parts, each of
    which repeats the first column.

    Args:
        console: Console for the table.
        table: The table.
        styles: Styles of cells, keyed by the cell's text; None for no styles.
    """
    if table.title:
        console.print(Text(table.title, "bold"))
    for columns in _pieces(table, console.width):
        console.print(_drawn(table, columns, console.width, styles or {}))
    if table.notes:
        console.print(Text(table.notes, "dim"))


def _pieces(table: Table, width: int) -> Iterator[list[int]]:
    """Splits a table's columns into parts; each contains the first column."""
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
    """Returns the least width at which a column is readable."""
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
