"""`Table`: a table of text cells, written as Markdown or HTML."""

import dataclasses as dc
import html


@dc.dataclass(frozen=True)
class Table:
    """A table of text cells, with headings and notes.

    Attributes:
        title: Heading above the table; empty for none.
        header: Headings of the columns. If all are empty, a terminal shows
            none.
        rows: Rows of cells. Each row has one cell for each heading.
        notes: Paragraph below the table; empty for none.
        texts: Number of columns with text. They precede the columns with
            numbers, and are aligned left.
        quoted: Indices of rows with results that are quoted from publications.
    """

    title: str
    header: tuple[str, ...]
    rows: tuple[tuple[str, ...], ...]
    notes: str = ""
    texts: int = 1
    quoted: frozenset[int] = frozenset()

    def to_markdown(self) -> str:
        """Returns heading, aligned pipe table and notes as Markdown."""
        rows = [
            (f"*{cells[0]}*", *cells[1:]) if i in self.quoted else cells
            for i, cells in enumerate(self.rows)
        ]
        widths = [
            max(3, *(len(cells[i]) for cells in (self.header, *rows)))
            for i in range(len(self.header))
        ]
        rule = [
            "-" * width if i < self.texts else f"{'-' * (width - 1)}:"
            for i, width in enumerate(widths)
        ]
        lines = [f"### {self.title}", ""] if self.title else []
        for cells in (self.header, rule, *rows):
            padded = [
                cell.ljust(width) if i < self.texts else cell.rjust(width)
                for i, (cell, width) in enumerate(
                    zip(cells, widths, strict=True)
                )
            ]
            lines.append("| " + " | ".join(padded) + " |")
        if self.notes:
            lines += ["", self.notes]
        return "\n".join(lines) + "\n"

    def to_html(self) -> str:
        """Returns heading, table and notes as a fragment of HTML."""
        head = "".join(
            f"<th{self._side(i)}>{_safe(cell)}</th>"
            for i, cell in enumerate(self.header)
        )
        lines = []
        for i, cells in enumerate(self.rows):
            quoted = ' class="quoted"' if i in self.quoted else ""
            inner = "".join(
                f"<td{self._side(j)}>{_safe(cell)}</td>"
                for j, cell in enumerate(cells)
            )
            lines.append(f"<tr{quoted}>{inner}</tr>")
        body = "\n".join(lines)
        title = f"<h3>{_safe(self.title)}</h3>\n" if self.title else ""
        notes = f"<p>{_safe(self.notes)}</p>\n" if self.notes else ""
        return (
            f'{title}<div class="table"><table>\n'
            f"<thead><tr>{head}</tr></thead>\n"
            f"<tbody>\n{body}\n</tbody>\n</table></div>\n{notes}"
        )

    def _side(self, column: int) -> str:
        return ' class="text"' if column < self.texts else ""


def _safe(text: str) -> str:
    return html.escape(text)
