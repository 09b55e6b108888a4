"""`StationStatus`: a station's mode, and the age of its measurements."""

import dataclasses as dc
import math

RUNNING = "running"
"""Mode of a station that executes commands."""
STOPPED = "stopped"
"""Mode of a station that executes no commands; `StationStatus.stop_reason` is
the reason."""

MOVE = "move"
"""libfranka's name of the robot mode in which the arm executes motions."""


@dc.dataclass(frozen=True)
class StationStatus:
    """The state of a robot's station; copying returns the object itself.

    Attributes:
        age: Age of the arm's measurements on the output ports [s]; 0 in
            simulated stations.
        base_age: Time since the base's pose was measured [s]. The pose on the
            output ports is extrapolated by this time.
        mode: Either `RUNNING` or `STOPPED`.
        stop_reason: Reason why the station stopped, in one line; empty while it
            runs.
        robot_mode: Mode of the arm by libfranka's names: other, idle, move,
            guiding, reflex, user_stopped or automatic_error_recovery.
        success_rate: Fraction of the arm's latest commands that reached it in
            time, 0 to 1 (libfranka's control_command_success_rate).
        protective_stop: Whether the base's safety scanner has stopped the base.
            This stop ends by itself.
        is_lost: Whether the station stopped because the pose of the base is not
            known well enough.
        base_uncertainty: Bound of the error of the base's pose at the time of
            its measurement, as a position and a heading error [m, rad]; 0 in
            simulated stations. It excludes the error of the extrapolation,
            which `MotionPredictor` replaces by a prediction with its own bound.
        sent: Time at which the latest command was sent to a real robot, by the
            diagram's clock [s]; -inf in simulated stations.
    """

    age: float = 0.0
    mode: str = RUNNING
    stop_reason: str = ""
    robot_mode: str = MOVE
    success_rate: float = 1.0
    protective_stop: bool = False
    base_age: float = 0.0
    is_lost: bool = False
    base_uncertainty: tuple[float, float] = (0.0, 0.0)
    sent: float = -math.inf

    def __deepcopy__(self, memo) -> "StationStatus":
        return self
