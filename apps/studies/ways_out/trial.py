"""One start: whether the robot gets out, and decreases of distances."""

import dataclasses as dc
from typing import Any

import numpy as np

from apps.studies.ways_out.search import finds_a_way
from apps.studies.ways_out.start import (
    UNSEEN,
    Place,
    Posture,
    Start,
    draw,
    place_of,
)
from remosplat_drake.controller.tick.run_tick import run_tick
from remosplat_drake.safety.supervision import Observation, SupervisorLaw
from remosplat_drake.safety.supervisor import supervise
from remosplat_drake.scene.mover import Movers
from remosplat_drake.signals.station_status import StationStatus
from remosplat_drake.signals.supervisor_state import SupervisorState

TIME = 10.0
"""A robot must get out within this time [s]."""

ROUNDING = 1e-6
"""Tolerance of stopping distances at the end [m], which a damper approaches
asymptotically."""

JOINT_ROUNDING = 1e-3
"""Tolerance of joints, whose damper is slower [rad, m]."""

_LOOKS = 4
"""Number of samples of the distances per tick."""


@dc.dataclass(frozen=True)
class Result:
    """The result of a start.

    Attributes:
        key: Name of the start.
        depth: Largest violation of a stopping distance at the start [m].
        out_after: Time until every pair and every joint was beyond its stopping
            distance [s]; None if it never was.
        left: Largest violation at the end [m].
        nearer_at_ticks: Largest decrease of a distance, below its initial value
            and its stopping distance, at the ends of ticks [m].
        nearer_between: Largest such decrease at all times [m].
        stopped: Reason of a stop by the supervisor; empty without a stop.
        has_way: Whether the search found a way out; None without a search.
        error: Reason why there is no result; empty if there is one.
        joints_nearer: Largest decrease of a joint's distance from its limit,
            below its initial value and its stopping distance [rad, m].
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
    joints_nearer: float = 0.0

    @property
    def group(self) -> str:
        """Name of the robot, and the kind of violated distance."""
        return self.key.rpartition(" ")[0]


def failed(start: Start, error: str) -> Result:
    """Makes the result of a start that failed."""
    return Result(start.key, error=error)


def restored(fields: dict[str, Any]) -> Result:
    """Restores a result from a file's line."""
    return Result(**fields)


def run_trial(start: Start) -> Result:
    """Drives a robot out of a start, and searches for a way out if that fails.

    Args:
        start: The start.
    """
    place, posture = place_of(start.robot, start.kind == UNSEEN), draw(start)
    result = _driven(place, start.key, posture)
    if result.out_after is not None:
        return result
    random = np.random.default_rng(start.seed)
    return dc.replace(result, has_way=finds_a_way(place, posture, random))


def _driven(place: Place, key: str, posture: Posture) -> Result:
    law, robot, field = place.law, place.world.robot, place.world.field
    q, still = posture.q, posture.movers
    dt, u, margins = law.dt, np.zeros(robot.n_u), place.margins(q, still)
    watch = SupervisorLaw.make(
        place.scenario.supervisor,
        robot,
        dt,
        smallest_stopping=place.scenario.controller.smallest_stopping,
    )
    state = SupervisorState(u)
    depth, level = -margins.min(), np.minimum(margins, 0.0)
    joints_level = place.joint_margins(q)
    fell, fell_between, joints_fell, out = 0.0, 0.0, 0.0, None
    for tick in range(round(TIME / dt)):
        spheres = robot.spheres_at(q)
        near = field.clearances(spheres, law.collision.influence)
        time = tick * dt
        movers = Movers(time, still.movers) if still.movers else None
        report = run_tick(
            law,
            time,
            q,
            place.target,
            near,
            field,
            state.command,
            movers=movers,
        )
        seen = Observation(
            time, report.command, report, StationStatus(), u, movers=movers
        )
        state = supervise(watch, state, seen)
        u = state.command
        for look in range(1, _LOOKS + 1):
            after = robot.advance(q, u, dt * look / _LOOKS)
            margins = place.margins(after, still)
            fell_between = max(fell_between, float((level - margins).max()))
        fell = max(fell, float((level - margins).max()))
        q = robot.advance(q, u, dt)
        joints = place.joint_margins(q)
        joints_fell = max(joints_fell, float((joints_level - joints).max()))
        if margins.min() >= -ROUNDING and joints.min() >= -JOINT_ROUNDING:
            out = time + dt
            break
        if state.is_latched and not u.any():
            break
    lacking = max(-margins.min(), -joints.min(), 0.0)
    return Result(
        key,
        float(depth),
        out,
        float(lacking),
        fell,
        fell_between,
        state.reason if state.is_latched else "",
        joints_nearer=joints_fell,
    )
