"""Help on commands, and what their arguments' errors look like."""

import subprocess
import sys

import pytest

from remosplat_drake.base.version import __version__
from remosplat_drake.commands.catalogue import COMMANDS, GROUPS
from remosplat_drake.commands.command_parser import CommandParser
from remosplat_drake.commands.main import USER_ERROR, main


def test_help_shows_every_command_in_lines_that_fit(capsys):
    assert main(["--help"]) == 0
    shown = capsys.readouterr().out
    assert max(map(len, shown.splitlines())) <= 80
    for group in GROUPS:
        assert f"`{group.example}`" in shown
        for command, summary in group.commands.items():
            assert f"  {command} " in shown
            assert summary in shown


def test_without_a_command_there_is_help_and_an_error(capsys):
    assert main([]) == USER_ERROR
    captured = capsys.readouterr()
    assert captured.out == ""
    assert "Drive, as in" in captured.err


def test_the_version(capsys):
    assert main(["--version"]) == 0
    assert capsys.readouterr().out.strip() == __version__


def test_help_loads_no_command():
    code = (
        "import sys; from remosplat_drake.commands.main import main\n"
        "main(['--help'])\n"
        "assert not {'numpy', 'pydrake', 'rich'} & set(sys.modules)"
    )
    subprocess.run([sys.executable, "-c", code], check=True)


@pytest.mark.parametrize("command", COMMANDS)
def test_help_of_a_command_ends_with_examples_of_it(command, capsys):
    with pytest.raises(SystemExit) as ended:
        main([command, "--help"])
    assert ended.value.code == 0
    head, _, examples = capsys.readouterr().out.partition("examples:\n")
    assert COMMANDS[command][1:] in " ".join(head.split())
    lines = examples.splitlines()
    assert 1 <= len(lines) <= 3
    assert all(line.startswith(f"  remosplat {command}") for line in lines)


@pytest.mark.parametrize(
    ("words", "expected"),
    [
        (["benhc"], "unknown command 'benhc' (did you mean 'bench'?); valid: "),
        (["--headless", "run"], "--headless: a flag precedes the command"),
        (
            ["run", "--scenariotext", "{}"],
            "run: unknown flag '--scenariotext' (did you mean"
            " '--scenario-text'?); valid: --scenario-text, ",
        ),
        (
            ["convert", "--headless"],
            "convert: unknown flag '--headless' (a flag of run, teleop);"
            " valid: ",
        ),
        # What is misspelt is not missing.
        (
            ["reconstruct", "a", "--outptu=b"],
            "reconstruct: unknown flag '--outptu' (did you mean '--output'?)",
        ),
        (["run", "-q"], "run: unknown flag '-q'; valid: "),
        (
            ["run", "--hardwar"],
            "run: unknown flag '--hardwar' (did you mean '--hardware'?)",
        ),
        (["scenarios", "more"], "scenarios: 'more' is an unexpected argument"),
        (["quality", "a.ply"], "quality: the following arguments are required"),
        (
            ["bench", "tik"],
            "bench: group: unknown choice 'tik' (did you mean 'tick'?); valid:",
        ),
        (["run", "--port", "http"], "run: --port: 'http' is not a whole"),
        (
            ["quality", "a", "b", "--reach", "far"],
            "quality: --reach: 'far' is not a number",
        ),
        (
            ["run", "--realtime-rate", "-1"],
            "run: --realtime-rate: -1 is not a number >= 0",
        ),
        (["replay", "a", "--rate", "0"], "replay: --rate: 0 is not a number >"),
        (["run", "--output"], "run: --output: expected one argument"),
    ],
    ids=" ".join,
)
def test_a_mistake_is_one_line_with_a_guess(words, expected, capsys):
    assert main(words) == USER_ERROR
    captured = capsys.readouterr()
    assert captured.out == ""
    assert captured.err.startswith(f"remosplat: {expected}")
    assert captured.err.count("\n") == 1


def test_values_that_look_like_flags_are_values():
    parser = CommandParser("convert")
    box = "-1 -2 -.5 1 2 3".split()
    arguments = parser.parse_args(["a.ply", "b.ply", "--crop", *box])
    assert arguments.crop == [float(x) for x in box]
    assert parser.parse_args(["--", "--a", "--b"]).source == "--a"
