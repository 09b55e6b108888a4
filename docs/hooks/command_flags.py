"""Generation of the reference of all commands from their parsers."""

import argparse

from remosplat_drake.commands.catalogue import GROUPS
from remosplat_drake.commands.command_parser import CommandParser


def reference_of_commands() -> str:
    """Returns Markdown with one section for each command, in their groups."""
    return "\n".join(
        _section(command, summary)
        for group in GROUPS
        for command, summary in group.commands.items()
    )


def make_parser(command: str) -> CommandParser:
    """Returns the parser of one command."""
    parser = CommandParser(command)
    parser.formatter_class = lambda prog: argparse.HelpFormatter(prog, width=79)
    return parser


def _section(command: str, summary: str) -> str:
    parser = make_parser(command)
    lines = [
        f"## {command}",
        "",
        f"{summary[0].upper()}{summary[1:]}.",
        "",
        "```text",
        parser.format_usage().removeprefix("usage: ").rstrip(),
        "```",
        "",
    ]
    rows = [_row(action) for action in parser._actions[1:]]
    if rows:
        lines += ["| argument | meaning |", "|---|---|", *rows, ""]
    lines += ["```sh", *parser.examples.splitlines(), "```", ""]
    return "\n".join(lines)


def _row(action: argparse.Action) -> str:
    meaning = _meaning(action)
    return f"| {_name(action)} | {meaning} |".replace("\n", " ")


def _name(action: argparse.Action) -> str:
    value = action.metavar or action.dest.upper().replace("_", "-")
    shown = " ".join(value) if isinstance(value, tuple) else value
    if not action.option_strings:
        return f"`{(action.metavar and shown) or action.dest}`"
    names = ", ".join(action.option_strings)
    if action.nargs == 0:
        return f"`{names}`"
    if action.choices is not None and action.metavar is None:
        shown = "|".join(map(str, action.choices))
    return f"`{names} {shown}`".replace("|", "\\|")


def _meaning(action: argparse.Action) -> str:
    text = (action.help or "") % {**vars(action), "prog": ""}
    text = " ".join(text.split()).replace("|", "\\|").replace("<", "&lt;")
    if action.choices is not None and not action.option_strings:
        names = ", ".join(f"`{choice}`" for choice in action.choices)
        text = f"{text} One of {names}."
    return f"{text[0].upper()}{text[1:].rstrip('.')}." if text else ""
