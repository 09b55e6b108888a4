"""Prints the state of a map, and lets a person accept its problems."""

import argparse
import dataclasses as dc
import sys
import termios
from collections.abc import Iterable, Sequence

from rich.console import Console

from remosplat_drake.app.map_knowledge import MapKnowledge
from remosplat_drake.base.errors import RemoSplatError
from remosplat_drake.safety.gates import (
    GATES,
    Gate,
    Passage,
    check_names,
    open_gates,
)


def add_accept_argument(parser: argparse.ArgumentParser) -> None:
    """Declares the flag `--accept`, which accepts a problem of the map."""
    gates = "; ".join(f"{name}: {what}" for name, what in GATES.items())
    parser.add_argument(
        "--accept",
        action="append",
        default=[],
        metavar="NAME",
        help="drive in spite of this problem of the map; repeat the flag for "
        "further problems. With --hardware a person must confirm each "
        f"problem at the terminal ({gates})",
    )


def check_accepted(arguments: argparse.Namespace) -> None:
    """Checks that `--accept` contains only names of gates.

    Raises:
        RemoSplatError: `--accept` contains a name that is not the name of a
            gate.
    """
    check_names(arguments.accept)


def describe(
    knowledge: MapKnowledge, warnings: Iterable[Gate], console: Console
) -> None:
    """Prints the content, the error and the problems of a map."""
    for line in knowledge.lines():
        _tell(console, line)
    for gate in warnings:
        _tell(console, f"warning: {gate}", "bold yellow")


@dc.dataclass(frozen=True)
class Admission:
    """Permission for a run to begin, with the warnings and accepted problems.

    Attributes:
        knowledge: Content, error and problems of the run's map.
        passage: Result of the gates (checks before a run): warnings, and
            accepted problems.
        hardware: Whether a real robot will move.
    """

    knowledge: MapKnowledge
    passage: Passage
    hardware: bool

    def announce(self, console: Console) -> None:
        """Prints the map's state; a person must confirm accepted problems.

        Raises:
            RemoSplatError: No person has confirmed an accepted problem.
        """
        describe(self.knowledge, self.passage.warnings, console)
        for gate in self.passage.accepted:
            if self.hardware:
                _confirm(gate, console)
            _tell(console, f"accepted: {gate}", "bold yellow")

    def document(self) -> dict:
        """Returns the data about the map, for the files that a run writes."""
        return {
            "map_summary": dc.asdict(self.knowledge.summary),
            "map_error": self.knowledge.error.largest,
            "unseen": self.knowledge.unseen,
            "warnings": list(map(_entry, self.passage.warnings)),
            "accepted": list(map(_entry, self.passage.accepted)),
        }


def admit(
    knowledge: MapKnowledge,
    arguments: argparse.Namespace,
    where: str,
    start: Sequence[Gate] = (),
) -> Admission:
    """Permits a run or refuses it, without printing.

    Args:
        knowledge: Content, error and problems of the run's map.
        arguments: The command line, with `accept` and `hardware`.
        where: Name of the scenario, for errors.
        start: Problems of the run's start and targets.

    Raises:
        RemoSplatError: The run is refused.
    """
    passage = open_gates(
        [*knowledge.gates, *start],
        arguments.accept,
        hardware=arguments.hardware,
        where=where,
    )
    return Admission(knowledge, passage, arguments.hardware)


def _entry(gate: Gate) -> dict[str, str]:
    return {"name": gate.name, "problem": gate.problem}


def _confirm(gate: Gate, console: Console) -> None:
    """Waits until a person types a gate's name, before a real robot moves.

    Raises:
        RemoSplatError: There is no terminal, or the typed text is not the
            gate's name.
    """
    flag = f"--accept {gate.name}"
    if sys.stdin is None or not sys.stdin.isatty():
        raise RemoSplatError(
            f"{flag}: with --hardware a person must confirm this at a "
            f"terminal, but the program has no terminal ({gate.problem})"
        )
    # Input that was typed before the question is discarded.
    termios.tcflush(sys.stdin, termios.TCIFLUSH)
    _tell(console, str(gate))
    console.print(
        f"type [bold]{gate.name}[/bold] to move the robot anyway: ", end=""
    )
    if sys.stdin.readline().strip() != gate.name:
        raise RemoSplatError(
            f"{flag}: not confirmed, so the robot does not move; type the "
            "name to drive"
        )


def _tell(console: Console, line: str, style: str = "") -> None:
    """Prints one line without wrapping; brackets in it are not markup."""
    console.print(
        line, style=style, markup=False, highlight=False, soft_wrap=True
    )
