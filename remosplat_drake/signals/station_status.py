"""`StationStatus`: how fresh a station's measurements are, and its mode."""

import dataclasses as dc

RUNNING = "running"
"""Commands are carried out."""
STOPPED = "stopped"
"""The robot holds still; `stop_reason` says why."""

MOVE = "move"
"""The arm carries out motion commands: libfranka's name of the mode."""


@dc.dataclass(frozen=True)
class StationStatus:
    """The state of a station; copying returns the object itself.

    Attributes:
        age: Age of the arm's state on the ports [s]; simulated stations
            measure at once. A real base tells its state less often; how old
            that may be is the station's business.
        mode: `RUNNING` or `STOPPED`.
        stop_reason: One line; empty while running.
        robot_mode: The arm's own mode by libfranka's names: other, idle,
            move, guiding, reflex, user_stopped or automatic_error_recovery.
        success_rate: Share of the arm's latest commands that reached it in
            time, 0 to 1.
        protective_stop: Whether the base's safety scanner holds it. The base
            lifts that stop by itself.
    """

    age: float = 0.0
    mode: str = RUNNING
    stop_reason: str = ""
    robot_mode: str = MOVE
    success_rate: float = 1.0
    protective_stop: bool = False

    def __deepcopy__(self, memo) -> "StationStatus":
        return self
