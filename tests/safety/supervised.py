"""A small supervisor, and what it may see."""

import numpy as np

from remosplat_drake.safety.supervision import Observation, SupervisorLaw
from remosplat_drake.safety.supervisor_config import SupervisorConfig
from remosplat_drake.scene.mover import Movers
from remosplat_drake.signals.aim import Aim
from remosplat_drake.signals.distance_field import Clearances
from remosplat_drake.signals.motion import Motion
from remosplat_drake.signals.station_status import StationStatus
from remosplat_drake.signals.supervisor_state import SupervisorState
from remosplat_drake.signals.tick_report import OPTIMAL, TickReport

DT = 0.01
ACCELERATION = np.array([1.0, 4.0, 10.0])
VELOCITY = np.array([0.5, 1.0, 2.0])
MIN_CLEARANCE = 0.016


def make_law(**config) -> SupervisorLaw:
    """A law for three joints; the thresholds are the defaults."""
    return SupervisorLaw(
        SupervisorConfig(**config),
        DT,
        ACCELERATION,
        VELOCITY,
        MIN_CLEARANCE,
    )


def clearances(distance: float, revision: str = "") -> Clearances:
    """One sphere that is so far away."""
    return Clearances(
        np.array([0]),
        np.array([distance]),
        np.array([[1.0, 0.0, 0.0]]),
        np.zeros((1, 3)),
        revision,
    )


def make_report(
    time: float,
    command: np.ndarray,
    *,
    report_status: str = OPTIMAL,
    clearance: float = 0.1,
    revision: str = "",
    q: float = 0.0,
    x_WT: float = 1.0,
) -> TickReport:
    """What the controller says when all is well."""
    X_WT = np.eye(4)
    X_WT[0, 3] = x_WT
    none = np.zeros(1, bool)
    return TickReport(
        time=time,
        q=np.full(3, q),
        command=command,
        status=report_status,
        reason="" if report_status == OPTIMAL else "no feasible command found",
        scale=1.0,
        clearances=clearances(clearance, revision),
        kept=none,
        tight=none,
        aim=Aim.of(X_WT),
    )


def make_observation(
    state: SupervisorState,
    time: float,
    u=(0.0, 0.0, 0.0),
    *,
    status: StationStatus | None = None,
    u_measured: np.ndarray | None = None,
    tick_age: float = 0.0,
    motion: Motion | None = None,
    map_age: float = 0.0,
    movers: Movers | None = None,
    stop: str = "",
    release: bool = False,
    **report,
) -> Observation:
    """A tick at which all is well but for what is given."""
    command = np.array(u, float)
    return Observation(
        time=time,
        command=command,
        report=make_report(time - tick_age, command, **report),
        status=status or StationStatus(),
        u_measured=state.command if u_measured is None else u_measured,
        motion=motion,
        map_age=map_age,
        movers=movers,
        stop=stop,
        release=release,
    )
