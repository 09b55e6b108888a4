"""`TaskOutline`: the jobs, steps and objects of a task, for display."""

import dataclasses as dc

AHEAD, PRESENT, DONE, FAILED = "ahead", "present", "done", "failed"
"""States of a job or step."""


@dc.dataclass(frozen=True)
class OutlineLine:
    """A job of a task, or a step of a job.

    Attributes:
        text: Description of the robot's action.
        state: `AHEAD`, `PRESENT`, `DONE` or `FAILED`.
        is_step: Whether the line is a step of the previous job in the list.
    """

    text: str
    state: str
    is_step: bool = False


@dc.dataclass(frozen=True)
class OutlineObject:
    """An object of a task, and the contact that is permitted at present.

    Attributes:
        name: Name of the object.
        text: Statement that the robot carries the object, or about the links
            that may touch it.
        may_be_touched: Whether any link may touch the object.
        is_carried: Whether the robot carries the object.
    """

    name: str
    text: str
    may_be_touched: bool = False
    is_carried: bool = False


@dc.dataclass(frozen=True)
class TaskOutline:
    """Outline of a task at a tick; copying returns the object itself.

    Attributes:
        lines: The jobs of the task in their order. The steps of the present job
            follow this job.
        objects: The objects of the task.
        failures: Reasons why steps have failed so far.
    """

    lines: tuple[OutlineLine, ...] = ()
    objects: tuple[OutlineObject, ...] = ()
    failures: tuple[str, ...] = ()

    def __deepcopy__(self, memo) -> "TaskOutline":
        return self

    @property
    def is_running(self) -> bool:
        """Whether a step of the task is in progress."""
        return any(line.state == PRESENT for line in self.lines)

    def document(self) -> dict:
        """Returns the outline as a JSON object."""
        return dc.asdict(self)
