"""One start: whether the robot gets out, and how near anything comes."""

import dataclasses as dc
from typing import Any

import numpy as np

from apps.studies.ways_out.search import finds_a_way
from apps.studies.ways_out.start import Place, Start, draw, place_of
from remosplat_drake.controller.tick.run_tick import run_tick
from remosplat_drake.safety.supervision import Observation, SupervisorLaw
from remosplat_drake.safety.supervisor import supervise
from remosplat_drake.signals.station_status import StationStatus
from remosplat_drake.signals.supervisor_state import SupervisorState

TIME = 10.0
"""Time in which a robot must get out [s]."""

ROUNDING = 1e-6
"""By how much a distance may lack of its stopping distance at the end [m]: a
damper comes near it, and never quite there."""

_LOOKS = 4
"""Number of looks at the distances a tick."""


@dc.dataclass(frozen=True)
class Result:
    """How a start went.

    Attributes:
        key: Name of the start.
        depth: How far inside its distances it was [m].
        out_after: When every pair was beyond its stopping distance [s]; None
            if it never was.
        left: What was lacking in the end [m].
        nearer_at_ticks: By how much a distance fell below that of the start,
            or its stopping distance, at the ends of ticks [m].
        nearer_between: The same at all times [m].
        stopped: Why the supervisor stopped the robot; empty if it did not.
        has_way: Whether a search finds a way; None where none was asked for.
        error: Why there is no result; empty for none.
    """

    key: str
    depth: float = float("nan")
    out_after: float | None = None
    left: float = float("nan")
    nearer_at_ticks: float = 0.0
    nearer_between: float = 0.0
    stopped: str = ""
    has_way: bool | None = None
    error: str = ""

    @property
    def robot(self) -> str:
        """Name of the robot."""
        return self.key.partition(" ")[0]


def failed(start: Start, error: str) -> Result:
    """Makes the result of a start that gave none."""
    return Result(start.key, error=error)


def restored(fields: dict[str, Any]) -> Result:
    """Makes a result of what a file holds."""
    return Result(**fields)


def run_trial(start: Start) -> Result:
    """Lets a robot get out of a start, and searches for a way if it does not.

    Args:
        start: The start.
    """
    place, q = place_of(start.robot), draw(start)
    result = _driven(place, start.key, q)
    if result.out_after is not None:
        return result
    random = np.random.default_rng(start.seed)
    return dc.replace(result, has_way=finds_a_way(place, q, random))


def _driven(place: Place, key: str, q: np.ndarray) -> Result:
    law, robot, field = place.law, place.world.robot, place.world.field
    dt, u, margins = law.dt, np.zeros(robot.n_u), place.margins(q)
    watch = SupervisorLaw.make(
        place.scenario.supervisor,
        robot,
        dt,
        smallest_stopping=place.scenario.controller.smallest_stopping,
    )
    state = SupervisorState(u)
    depth, level = -margins.min(), np.minimum(margins, 0.0)
    fell, fell_between, out = 0.0, 0.0, None
    for tick in range(round(TIME / dt)):
        spheres = robot.spheres_at(q)
        near = field.clearances(spheres, law.collision.influence)
        time = tick * dt
        report = run_tick(
            law, time, q, place.target, near, field, state.command
        )
        seen = Observation(time, report.command, report, StationStatus(), u)
        state = supervise(watch, state, seen)
        u = state.command
        for look in range(1, _LOOKS + 1):
            margins = place.margins(robot.advance(q, u, dt * look / _LOOKS))
            fell_between = max(fell_between, float((level - margins).max()))
        fell = max(fell, float((level - margins).max()))
        q = robot.advance(q, u, dt)
        if margins.min() >= -ROUNDING:
            out = time + dt
            break
        if state.is_latched and not u.any():
            break
    return Result(
        key,
        float(depth),
        out,
        float(max(-margins.min(), 0.0)),
        fell,
        fell_between,
        state.reason if state.is_latched else "",
    )
