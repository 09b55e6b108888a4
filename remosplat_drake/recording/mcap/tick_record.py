"""`TickRecord`: a compact record of a control tick, for another process."""

import dataclasses as dc

import numpy as np

from remosplat_drake.recording.events import Event
from remosplat_drake.recording.tick_events import LoggedSignals
from remosplat_drake.robot.payload import Payload
from remosplat_drake.signals.aim import Aim
from remosplat_drake.signals.station_status import StationStatus
from remosplat_drake.signals.tick_report import TickReport


@dc.dataclass(frozen=True, eq=False)
class TickRecord:
    """The data of a control tick, without the map and the kinematics.

    Attributes:
        time: Time of the tick, by the diagram's clock [s].
        q: Measured configuration, shape (n_q,) [m, rad].
        commanded: The controller's command u, shape (n_u,) [m/s, rad/s].
        executed: The command that the station received, shape (n_u,).
        aim: The targets of the end effectors.
        status: Status of the controller, one of `STATUSES`.
        reason: Reason for the status; empty for `OPTIMAL`.
        scale: Scale of the command after verification, 0 to 1.
        duration: Wall-clock duration of the tick [s].
        sphere: Index of the sphere of each clearance, shape (m,).
        distance: The clearances, shape (m,) [m].
        mode: Mode of the supervisor; empty if there is none.
        stop_reason: Reason why the supervisor stopped the robot; empty if it
            did not.
        station: Status of the station; None if none is connected.
        events: The events since the previous tick.
        payload: The carried object, whose spheres have the indices after those
            of the robot; None if the robot carries nothing.
    """

    time: float
    q: np.ndarray
    commanded: np.ndarray
    executed: np.ndarray
    aim: Aim
    status: str
    reason: str
    scale: float
    duration: float
    sphere: np.ndarray
    distance: np.ndarray
    mode: str
    stop_reason: str
    station: StationStatus | None
    events: tuple[Event, ...]
    payload: Payload | None = None

    @staticmethod
    def of(
        report: TickReport,
        executed: np.ndarray,
        signals: LoggedSignals,
        events: tuple[Event, ...],
    ) -> "TickRecord":
        """Assembles the record of a tick.

        Args:
            report: The controller's report.
            executed: The command that the robot received, shape (n_u,).
            signals: Other signals at the tick.
            events: The events since the previous tick.
        """
        supervision = signals.supervision
        return TickRecord(
            time=report.time,
            q=report.q,
            commanded=report.command,
            executed=np.array(executed),
            aim=report.aim,
            status=report.status,
            reason=report.reason,
            scale=report.scale,
            duration=report.timings.get("total", 0.0),
            sphere=report.clearances.sphere,
            distance=report.clearances.distance,
            mode=signals.mode,
            stop_reason="" if supervision is None else supervision.reason,
            station=signals.station,
            events=events,
            payload=report.payload,
        )
