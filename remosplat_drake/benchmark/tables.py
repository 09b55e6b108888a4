"""`Table`: a small table that can be written as Markdown and as HTML."""

import dataclasses as dc
import html


@dc.dataclass(frozen=True)
class Table:
    """Cells of text under headings.

    Attributes:
        title: What it shows.
        header: One heading a column; the first column is left-aligned.
        rows: As many cells each as there are headings.
        notes: A paragraph below.
    """

    title: str
    header: tuple[str, ...]
    rows: tuple[tuple[str, ...], ...]
    notes: str = ""

    def to_markdown(self) -> str:
        """A heading, a pipe table whose columns line up, and the notes."""
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
        """The same as a fragment of HTML."""

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
