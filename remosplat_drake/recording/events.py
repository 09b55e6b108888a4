"""What happens in a run now and then, as lines of JSON."""

import dataclasses as dc
import json
from pathlib import Path

from remosplat_drake.base.append_file import AppendFile
from remosplat_drake.base.errors import FileError
from remosplat_drake.base.reading import reads_file
from remosplat_drake.base.strict_json import as_number, parse_json_object

SUPERVISOR = "supervisor"
"""The supervisor's mode has changed."""
MAP = "map"
"""Another version of the map is asked from now on."""
TARGET = "target"
"""What moves the target has changed."""
REQUEST = "request"
"""A person or a program asked for something."""
TROUBLE = "trouble"
"""Something does not work; control goes on."""


@dc.dataclass(frozen=True)
class Event:
    """One of them.

    Attributes:
        time: When it happened, by the diagram's clock [s].
        kind: One of the above.
        text: For a person.
        version: Of the map, where the event is about one.
    """

    time: float
    kind: str
    text: str
    version: int | None = None


class EventWriter:
    """Appends events to a file, each of them at once.

    Args:
        path: Must not exist.

    Attributes:
        trouble: Why events are missing; empty while none is.

    Raises:
        FileError: The file cannot be begun.
    """

    def __init__(self, path: Path):
        self.trouble = ""
        self._file = AppendFile(path)

    def append(self, event: Event) -> None:
        """Adds an event."""
        line = json.dumps(dc.asdict(event)) + "\n"
        problem = self._file.append(line.encode())
        if problem:
            self.trouble = f"{self._file.path.name} lacks events: {problem}"

    def close(self) -> None:
        """Closes the file."""
        self._file.close()


@reads_file
def read_events(path: Path) -> list[Event]:
    """Reads events; a line that was cut off at the end is left out.

    Raises:
        FileError: The file cannot be read, or holds something else.
        FieldError: An event has no time.
    """
    try:
        text = path.read_text("utf-8")
    except OSError as error:
        raise FileError(path, error.strerror or str(error)) from error
    except UnicodeDecodeError as error:
        raise FileError(path, "is not a list of events") from error
    lines = text.split("\n")[:-1]
    return [_event(path, number, line) for number, line in enumerate(lines, 1)]


def _event(path: Path, number: int, line: str) -> Event:
    """The event of a line."""
    where = f"{path}:{number}"
    fields = parse_json_object(line, where)
    version = fields.get("version")
    if (
        not fields.keys() <= {field.name for field in dc.fields(Event)}
        or not isinstance(fields.get("kind"), str)
        or not isinstance(fields.get("text"), str)
        or not (version is None or type(version) is int)
    ):
        raise FileError(where, "is not an event")
    time = as_number(where, "time", fields.get("time"))
    return Event(time, fields["kind"], fields["text"], version)
