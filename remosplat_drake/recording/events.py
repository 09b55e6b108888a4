"""Events of a run, such as a stop or a new map, as lines of JSON."""

import dataclasses as dc
import json
from pathlib import Path

from remosplat_drake.base.append_file import AppendFile
from remosplat_drake.base.errors import FileError
from remosplat_drake.base.reading import reads_file
from remosplat_drake.base.strict_json import as_number, parse_json_object

SUPERVISOR = "supervisor"
"""Kind of event: the supervisor's mode has changed."""
MOTION_STATUS = "motion_status"
"""Kind of event: the cause that keeps the robot from moving has changed."""
MAP = "map"
"""Kind of event: the oracle has begun to use another version of the map."""
TARGET = "target"
"""Kind of event: the source that moves the target has changed."""
REQUEST = "request"
"""Kind of event: a person or a program has requested a change of the map."""
TROUBLE = "trouble"
"""Kind of event: a part of the system fails; control continues."""


@dc.dataclass(frozen=True)
class Event:
    """An event of a run, such as a stop or a new map.

    Attributes:
        time: Time of the event, by the diagram's clock [s].
        kind: `SUPERVISOR`, `MOTION_STATUS`, `MAP`, `TARGET`, `REQUEST` or
            `TROUBLE`.
        text: Description of the event, for display.
        version: Version of the map, in events about a map.
        link: Name of the link that cannot move on; empty if there is none.
        place: Point in W at which the link was first held up [m]; None if there
            is none.
    """

    time: float
    kind: str
    text: str
    version: int | None = None
    link: str = ""
    place: tuple[float, float, float] | None = None


class EventWriter:
    """Appends events to a file immediately.

    Args:
        path: The file; it must not exist.

    Attributes:
        trouble: Reason why events are missing in the file; empty if the file is
            complete.

    Raises:
        FileError: The file exists or cannot be made.
    """

    def __init__(self, path: Path):
        self.trouble = ""
        self._file = AppendFile(path)

    def append(self, event: Event) -> None:
        """Writes an event; if that fails, `trouble` states the reason."""
        line = json.dumps(dc.asdict(event)) + "\n"
        problem = self._file.append(line.encode())
        if problem:
            self.trouble = f"{self._file.path.name} lacks events: {problem}"

    def close(self) -> None:
        """Closes the file; `trouble` states if the file no longer exists."""
        problem = self._file.close()
        if problem:
            self.trouble = f"{self._file.path} {problem}"


@reads_file
def read_events(path: Path) -> list[Event]:
    """Reads a file of events, and ignores an incomplete last line.

    Args:
        path: The file.

    Raises:
        FileError: The file cannot be read, or does not contain events.
        FieldError: The time of an event is not a number.
    """
    try:
        text = path.read_text("utf-8")
    except OSError as error:
        raise FileError(path, error.strerror or str(error)) from error
    except UnicodeDecodeError as error:
        raise FileError(path, "is not a file of events") from error
    lines = text.split("\n")[:-1]
    return [_event(path, number, line) for number, line in enumerate(lines, 1)]


def _event(path: Path, number: int, line: str) -> Event:
    """Parses a line of the file to an event."""
    where = f"{path}:{number}"
    fields = parse_json_object(line, where)
    version, place = fields.get("version"), fields.get("place")
    link = fields.get("link", "")
    if (
        not fields.keys() <= {field.name for field in dc.fields(Event)}
        or not isinstance(fields.get("kind"), str)
        or not isinstance(fields.get("text"), str)
        or not isinstance(link, str)
        or not (version is None or type(version) is int)
        or not (place is None or (type(place) is list and len(place) == 3))
    ):
        raise FileError(where, "is not an event")
    time = as_number(where, "time", fields.get("time"))
    if place is not None:
        x, y, z = (as_number(where, "place", value) for value in place)
        place = x, y, z
    return Event(time, fields["kind"], fields["text"], version, link, place)
