"""The reference of all commands, read from their argument parsers."""

import argparse
import importlib

from remosplat_drake.commands.main import COMMANDS


def reference_of_commands() -> str:
    """Markdown: one section for each command."""
    return "\n".join(map(_section, COMMANDS))


def make_parser(command: str) -> argparse.ArgumentParser:
    """The parser of one command."""
    parser = argparse.ArgumentParser(
        prog=f"remosplat {command}",
        formatter_class=lambda prog: argparse.HelpFormatter(prog, width=79),
    )
    module = importlib.import_module(
        f"remosplat_drake.commands.{command.replace('-', '_')}"
    )
    module.add_arguments(parser)
    return parser


def _section(command: str) -> str:
    parser = make_parser(command)
    summary = COMMANDS[command]
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
