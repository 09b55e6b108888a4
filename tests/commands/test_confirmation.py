"""A person who accepts something on the real robot types its name.

The terminal is a pseudo-terminal, and the person at it a thread that answers
each question when it is asked.
"""

import os
import pty
import threading
from collections.abc import Callable, Iterator

import pytest
from rich.console import Console

from remosplat_drake.app.map_knowledge import MapError, MapKnowledge
from remosplat_drake.base.errors import RemoSplatError
from remosplat_drake.commands.gate_keeping import Admission
from remosplat_drake.oracle.map_summary import SPLATS, MapSummary
from remosplat_drake.safety.gates import EMPTY_MAP, MAP_ERROR, Gate, Passage

WRONG = Gate(MAP_ERROR, "0.021 is too small")
EMPTY = Gate(EMPTY_MAP, "nothing is there")
QUESTION = b"to move the robot anyway: "


class Person:
    """Sits at a terminal and types an answer to each question.

    Attributes:
        console: What the program prints to.
        read: All that has come to the screen.
    """

    def __init__(self, ours: int, theirs: int):
        self._ours = ours
        self._screen = os.fdopen(os.dup(theirs), "w")
        self.console = Console(file=self._screen, force_terminal=False)
        self.read = b""

    def type(self, text: str) -> None:
        """Types at once, before or after a question."""
        os.write(self._ours, text.encode())

    def answering(self, *answers: str) -> threading.Thread:
        """Starts to read the screen and to answer what is asked there."""

        def answer():
            for asked, text in enumerate(answers, start=1):
                while self.read.count(QUESTION) < asked:
                    self.read += os.read(self._ours, 4096)
                self.type(text)

        thread = threading.Thread(target=answer, daemon=True)
        thread.start()
        return thread

    def close(self) -> None:
        self._screen.close()


@pytest.fixture
def person(monkeypatch) -> Iterator[Person]:
    ours, theirs = pty.openpty()
    with os.fdopen(theirs) as keyboard:
        monkeypatch.setattr("sys.stdin", keyboard)
        person = Person(ours, theirs)
        yield person
        person.close()
    os.close(ours)


@pytest.fixture
def announce(person) -> Callable[..., None]:
    """Announces a run with something accepted."""
    knowledge = MapKnowledge(
        MapSummary(SPLATS, 1, 0, 0, 1.0, ()), MapError(0.03), 0.021, ()
    )

    def _announce(*accepted: Gate, hardware: bool = True):
        passage = Passage(accepted=accepted)
        Admission(knowledge, passage, hardware).announce(person.console)

    return _announce


def test_the_name_is_asked_for_and_opens_the_gate(person, announce):
    person.answering("map-error\n")
    announce(WRONG)
    assert b"map-error: 0.021 is too small" in person.read
    assert b"type map-error to move the robot anyway: " in person.read


@pytest.mark.parametrize(
    # The last one is Ctrl-D, the end of all input.
    "answer",
    ["yes\n", "\n", "map-errors\n", "map\n", "\x04"],
)
def test_nothing_else_opens_it(person, announce, answer):
    person.answering(answer)
    with pytest.raises(RemoSplatError, match="map-error: not confirmed"):
        announce(WRONG)


def test_what_was_typed_before_the_question_is_no_answer(person, announce):
    person.type("map-error\n")
    person.answering("no\n")
    with pytest.raises(RemoSplatError, match="not confirmed"):
        announce(WRONG)


def test_each_is_confirmed_by_its_own_name(person, announce):
    person.answering("empty-map\n", "map-error\n")
    announce(EMPTY, WRONG)


def test_the_name_of_one_is_no_answer_about_the_other(person, announce):
    person.answering("empty-map\n", "empty-map\n")
    with pytest.raises(RemoSplatError, match="map-error: not confirmed"):
        announce(EMPTY, WRONG)


def test_in_simulation_the_flag_suffices(person, announce):
    announce(WRONG, EMPTY, hardware=False)
    assert QUESTION not in person.read
