"""`CommandParser`: parses one command's flags; its errors are one line."""

import argparse
import importlib
import re
from collections.abc import Iterator, Sequence
from types import ModuleType
from typing import Any, NoReturn

from remosplat_drake.base.errors import RemoSplatError, unknown_name
from remosplat_drake.base.system_libraries import libraries_named
from remosplat_drake.commands.catalogue import COMMANDS
from remosplat_drake.commands.interrupts import interrupts_deferred
from remosplat_drake.commands.number_flags import number, whole_number

_NUMBER = re.compile(r"-\.?\d.*")


def load_command(name: str) -> ModuleType:
    """Loads the module of a command.

    Args:
        name: One of `COMMANDS`.

    Raises:
        MissingLibraryError: A shared library of the system is not installed.
    """
    with interrupts_deferred(), libraries_named("Drake"):
        return importlib.import_module(
            f"remosplat_drake.commands.{name.replace('-', '_')}"
        )


class CommandParser(argparse.ArgumentParser):
    """Reads the arguments of one command.

    Invalid arguments raise a `RemoSplatError` with a suggestion. `argparse`
    itself would print several lines and exit.

    Attributes:
        examples: Example command lines, one per line.
    """

    def __init__(self, command: str):
        """Declares the flags of a command.

        Args:
            command: One of `COMMANDS`.
        """
        self._command = command
        module = load_command(command)
        summary = COMMANDS[command]
        self.examples: str = module.EXAMPLES.strip()
        indented = self.examples.replace("\n", "\n  ")
        super().__init__(
            prog=f"remosplat {command}",
            description=f"{summary[0].upper()}{summary[1:]}.",
            epilog=f"examples:\n  {indented}",
            formatter_class=_HelpFormatter,
            # Flags cannot be abbreviated: --har must not move a real robot.
            allow_abbrev=False,
        )
        # Without this pattern, `argparse` would parse -1e-3 as a flag.
        self._negative_number_matcher = _NUMBER
        self.register("type", float, number)
        self.register("type", int, whole_number)
        module.add_arguments(self)
        self.set_defaults(run=module.run)

    def parse_args(self, args: Sequence[str], namespace: Any = None) -> Any:
        """Reads the arguments that follow the command's name.

        Args:
            args: The arguments.
            namespace: Object whose attributes receive the values. If None, a
                new object is made.

        Raises:
            RemoSplatError: An argument is unknown, missing or invalid.
        """
        # Unknown flags are checked first, so that a misspelt required flag is
        # not reported as missing.
        for word in args:
            if word == "--":
                break
            flag = word.partition("=")[0]
            if self._is_flag(word) and not self._accepts(flag):
                self._refuse(flag)
        namespace, rest = self.parse_known_args(args, namespace)
        if rest:
            self.error(f"{rest[0]!r} is an unexpected argument")
        return namespace

    def error(self, message: str) -> NoReturn:
        """Raises an error about this command's arguments."""
        message = message.removeprefix("argument ")
        raise RemoSplatError(f"{self._command}: {message}")

    def _check_value(self, action: argparse.Action, value: Any) -> None:
        """Checks a value's choices; an error suggests a similar choice."""
        if action.choices is not None and value not in action.choices:
            problem = unknown_name("choice", value, map(str, action.choices))
            raise argparse.ArgumentError(action, problem)

    def _is_flag(self, word: str) -> bool:
        return (
            len(word) > 1
            and word.startswith("-")
            and " " not in word
            and not _NUMBER.fullmatch(word)
        )

    def _accepts(self, flag: str) -> bool:
        flags = self._option_string_actions
        if not flag.startswith("--"):
            return flag[:2] in flags
        return flag in flags

    def _refuse(self, flag: str) -> NoReturn:
        flags = [f for f in self._option_string_actions if f.startswith("--")]
        flags.remove("--help")
        problem = unknown_name("flag", flag, flags)
        if "did you mean" not in problem:
            found = ", ".join(_commands_with(flag))
            head, _, tail = problem.partition(";")
            problem = f"{head} (a flag of {found});{tail}" if found else problem
        self.error(problem)


class _HelpFormatter(argparse.HelpFormatter):
    """A help formatter that wraps paragraphs, but not the lines of examples."""

    def _fill_text(self, text: str, width: int, indent: str) -> str:
        if "\n" in text:
            return text
        return super()._fill_text(text, width, indent)


def _commands_with(flag: str) -> Iterator[str]:
    """Returns the commands that have a flag."""
    for command in COMMANDS:
        try:
            parser = CommandParser(command)
        except (ImportError, RemoSplatError):
            continue
        if flag in parser._option_string_actions:
            yield command
