"""Tables fit a terminal, are whole in a pipe, and come as JSON."""

import io
import json
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from rich.console import Console
from rich.text import Text

from remosplat_drake.base.table import Table
from remosplat_drake.commands.json_output import json_text
from remosplat_drake.commands.tables import open_console, print_table

WORDS = ("elbow", "a rather long remark about it", "12.345", "-")
TABLES = st.integers(1, 9).flatmap(
    lambda columns: st.builds(
        Table,
        st.sampled_from(("", "title")),
        st.tuples(*[st.sampled_from(("x", "largest [mm]"))] * columns),
        st.lists(
            st.tuples(*[st.sampled_from(WORDS)] * columns), max_size=4
        ).map(tuple),
        st.sampled_from(("", "† over all scenes")),
        st.integers(0, columns),
    )
)


def printed(table: Table, width: int) -> list[str]:
    stream = io.StringIO()
    console = Console(file=stream, width=width, force_terminal=True)
    print_table(console, table)
    return Text.from_ansi(stream.getvalue()).plain.splitlines()


@given(TABLES, st.sampled_from((60, 80, 120)))
def test_no_table_is_wider_than_the_terminal_and_nothing_is_lost(table, width):
    lines = printed(table, width)
    assert all(len(line.rstrip()) <= width for line in lines)
    text = "".join("".join(lines).split())
    assert "…" not in text
    for cell in {cell for row in table.rows for cell in row}:
        # What wraps has its words on several lines.
        assert all(word in text for word in cell.split())


def test_what_does_not_fit_is_printed_in_pieces():
    header = ("method", *(f"value {i}" for i in range(6)))
    rows = (("first", *("1.2345678 ± 0.01",) * 6), ("second", *("2",) * 6))
    lines = printed(Table("", header, rows, quoted=frozenset({1})), 60)
    # Three columns of 16 fit beside the names, at two columns' distance.
    assert [line.split()[0] for line in lines if line[0].isalpha()] == [
        *("method", "first", "second") * 2
    ]
    (wide,) = [x for x in printed(Table("", header, rows), 200) if "first" in x]
    assert wide.count("1.2345678") == 6


def test_in_a_pipe_there_is_neither_wrapping_nor_colour(capsys, monkeypatch):
    monkeypatch.setenv("COLUMNS", "40")
    monkeypatch.delenv("FORCE_COLOR", raising=False)
    names = tuple((f"{'x' * 90}{i}", "remark " * 30) for i in range(3))
    console = open_console()
    print_table(console, Table("", ("name", "remark"), names, texts=2))
    console.print("[bold red]a text[/] " * 40)
    lines = capsys.readouterr().out.splitlines()
    assert len(lines) == 2 + 3 + 1
    for name, remark in names:
        assert any(name in x and remark.strip() in x for x in lines)
    assert "\x1b" not in "".join(lines)


def test_documents_hold_what_json_knows():
    document = {
        "path": Path("a/b"),
        "numbers": (np.float64(1.5), np.inf, float("nan"), np.int64(3)),
        "array": np.eye(2, dtype=int),
    }
    assert json.loads(json_text(document)) == {
        "path": "a/b",
        "numbers": [1.5, None, None, 3],
        "array": [[1, 0], [0, 1]],
    }
    with pytest.raises(TypeError):
        json_text({"a": object()})
