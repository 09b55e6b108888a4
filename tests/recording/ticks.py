"""A tick of a run, by hand."""

import numpy as np

from remosplat_drake.recording.events import Event
from remosplat_drake.recording.mcap.tick_record import TickRecord
from remosplat_drake.signals.aim import Aim
from remosplat_drake.signals.station_status import StationStatus


def tick(robot, time: float, *events: Event) -> TickRecord:
    return TickRecord(
        time=time,
        q=robot.q_home,
        commanded=np.zeros(robot.n_u),
        executed=np.ones(robot.n_u),
        aim=Aim.of(np.eye(4)),
        status="optimal",
        reason="",
        scale=1.0,
        duration=1e-3,
        sphere=np.array([0, 3, 3]),
        distance=np.array([0.3, 0.2, 0.1]),
        mode="running",
        stop_reason="",
        station=StationStatus(age=np.inf),
        events=events,
    )
