"""The safety supervisor as a pure state machine: may the robot move, and how.

It passes the controller's command, scales it as a whole, or runs the braking
ramp. It never changes one joint alone: that would break the clearance rows
that a command fulfils as a vector. The ramp starts from the command being
executed and is the one that verify-then-scale has checked against the map,
whatever the controller's settings, so that a stop at any tick keeps the
guarantee of `verify.py`.

| mode     | output                                  | left when          |
|----------|-----------------------------------------|--------------------|
| starting | zero, then the command, grown from zero | it passes whole    |
| running  | the command                             | something is wrong |
| stopping | the braking ramp                        | it is at zero      |
| stopped  | zero                                    | released, and well |

A stop is latched: stopping and stopped end in no other way.
"""

import dataclasses as dc
import math

import numpy as np

from remosplat_drake.controller.braking import braking_command
from remosplat_drake.safety.supervision import Observation, SupervisorLaw
from remosplat_drake.safety.symptoms import Symptom, has_paused, symptoms
from remosplat_drake.signals.supervisor_state import (
    RUNNING,
    STARTING,
    STOPPED,
    STOPPING,
    UNARMED,
    SupervisorState,
)

_ROUNDING = 1e-9
"""Rounding errors of sums of periods [s], and of ramps relative to their
bounds."""


def supervise(
    law: SupervisorLaw, state: SupervisorState, now: Observation
) -> SupervisorState:
    """Advances the supervisor by one control tick.

    Args:
        law: The thresholds and limits.
        state: The supervisor after the tick before.
        now: What is seen at this tick.

    Returns:
        The next state; its command may be executed until the next tick.
    """
    found = symptoms(law, state, now)
    is_clear = all(symptom.name != "clearance" for symptom in found)
    since = _since(state, found, now.time)
    tripped = _tripped(found, since, now)
    if has_paused(law, state, now):
        # The drivers have let the command expire, and the robot stands: a
        # ramp down from it would set it going again.
        state = dc.replace(state, command=np.zeros_like(state.command))
    state = dc.replace(
        state,
        time=now.time,
        p_WTs=now.report.p_WTs,
        since=since,
        map_revision=(
            now.report.clearances.revision if is_clear else state.map_revision
        ),
    )
    if state.mode == STOPPED:
        return _rest(state, now, found)
    if state.mode == STOPPING:
        return _brake(law, state, state.reason)
    missing = _missing(now) if state.mode == STARTING else ""
    if missing and not (state.command.any() or now.stop):
        return dc.replace(state, reason=missing)
    if tripped:
        return _brake(law, state, tripped)
    if state.mode == STARTING:
        return _start(law, state, now.command)
    return dc.replace(state, command=now.command)


def _since(
    state: SupervisorState, found: list[Symptom], time: float
) -> dict[str, float]:
    """When each symptom began; a clock that went back starts them anew."""
    known = {} if time < state.time else state.since
    return {symptom.name: known.get(symptom.name, time) for symptom in found}


def _tripped(
    found: list[Symptom], since: dict[str, float], now: Observation
) -> str:
    """Why the robot must stop: what began first; empty if it need not."""
    if now.stop:
        return now.stop
    causes = [
        symptom
        for symptom in found
        if not now.time - since[symptom.name] < symptom.dwell - _ROUNDING
    ]
    first = min(causes, key=lambda cause: since[cause.name], default=None)
    return first.message if first else ""


def _missing(now: Observation) -> str:
    """What a start still waits for."""
    if now.status.age == math.inf:
        return "waiting for the first measurement"
    if math.isnan(now.report.time):
        return "waiting for the first control tick"
    return ""


def _start(
    law: SupervisorLaw, state: SupervisorState, u: np.ndarray
) -> SupervisorState:
    """As much of u as the acceleration allows, or a step of the ramp.

    A smaller share of u and its own ramp stay on the path that was verified
    for u; a mixture of u with the ramp that is under way would leave it.
    """
    share = _largest_share(law, state.command, u)
    if share == 1.0:
        return dc.replace(state, mode=RUNNING, reason="", command=u)
    if share is None:
        step = braking_command(state.command, law.start_acceleration, law.dt)
        return dc.replace(state, reason="", command=step)
    return dc.replace(state, reason="", command=share * u)


def _largest_share(
    law: SupervisorLaw, u_previous: np.ndarray, u: np.ndarray
) -> float | None:
    """Largest f in [0, 1] with |f u - u_previous| <= a dt, if there is one."""
    step = law.start_acceleration * law.dt * (1.0 + _ROUNDING)
    lower, upper = u_previous - step, u_previous + step
    moving = u != 0.0
    if not ((lower <= 0.0) & (upper >= 0.0))[~moving].all():
        return None
    with np.errstate(over="ignore"):  # A command of next to nothing.
        ends = np.stack([lower, upper])[:, moving] / u[moving]
    least = ends.min(axis=0).max(initial=0.0)
    most = ends.max(axis=0).min(initial=1.0)
    return float(most) if least <= most else None


def _brake(
    law: SupervisorLaw, state: SupervisorState, reason: str
) -> SupervisorState:
    command = braking_command(state.command, law.acceleration, law.dt)
    mode = STOPPING if command.any() else STOPPED
    return dc.replace(
        state, mode=mode, reason=reason, refusal="", command=command
    )


def _rest(
    state: SupervisorState, now: Observation, found: list[Symptom]
) -> SupervisorState:
    """Only a release ends a stop, and only where nothing is wrong."""
    if not now.release:
        # What else is wrong with a robot that nobody has let go yet is news.
        if state.reason == UNARMED and now.stop:
            return dc.replace(state, reason=now.stop)
        return state
    obstacle = now.stop or (found and found[0].message)
    if obstacle:
        return dc.replace(state, refusal=f"not released: {obstacle}")
    return dc.replace(state, mode=STARTING, reason="", refusal="")
