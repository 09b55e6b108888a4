"""`TaskOutline`: a task as people read it: its steps, and its objects."""

import dataclasses as dc

AHEAD, PRESENT, DONE, FAILED = "ahead", "present", "done", "failed"
"""States of a line."""


@dc.dataclass(frozen=True)
class OutlineLine:
    """A job of a task, or one of its steps.

    Attributes:
        text: What the robot does.
        state: `AHEAD`, `PRESENT`, `DONE` or `FAILED`.
        is_step: Whether it is a step of the job before it.
    """

    text: str
    state: str
    is_step: bool = False


@dc.dataclass(frozen=True)
class OutlineObject:
    """An object, and what the robot may do to it at present.

    Attributes:
        name: Its name.
        text: Whether it is carried, or which links may touch it.
        may_be_touched: Whether some link may touch it.
        is_carried: Whether the robot carries it.
    """

    name: str
    text: str
    may_be_touched: bool = False
    is_carried: bool = False


@dc.dataclass(frozen=True)
class TaskOutline:
    """A task at a tick; copying returns the object itself.

    Attributes:
        lines: Its jobs in their order; the steps of the present job follow it.
        objects: Its objects.
        failures: Why ways have failed so far.
    """

    lines: tuple[OutlineLine, ...] = ()
    objects: tuple[OutlineObject, ...] = ()
    failures: tuple[str, ...] = ()

    def __deepcopy__(self, memo) -> "TaskOutline":
        return self

    def document(self) -> dict:
        """Returns the outline as JSON has it."""
        return dc.asdict(self)
