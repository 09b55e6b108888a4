"""`StationStatus`: how fresh a station's measurements are, and its mode."""

import dataclasses as dc

RUNNING = "running"
"""Commands are carried out."""
STOPPED = "stopped"
"""The robot holds still; `stop_reason` says why."""


@dc.dataclass(frozen=True)
class StationStatus:
    """The state of a station; copying returns the object itself.

    Attributes:
        age: Age of the oldest measurement on the ports [s]; simulated
            stations measure at once.
        mode: `RUNNING` or `STOPPED`.
        stop_reason: One line; empty while running.
    """

    age: float = 0.0
    mode: str = RUNNING
    stop_reason: str = ""

    def __deepcopy__(self, memo) -> "StationStatus":
        return self
