"""The safety supervisor's state machine, as a pure function.

The supervisor either passes on the controller's command unchanged, or executes
the braking ramp. Verification has checked both. The supervisor never scales a
command, because at the end of a scaled command's tick the robot would be in a
configuration that verification has not checked. The ramp starts from the
command that is being executed. Verification has checked this ramp together with
this command. So a stop at any tick keeps the guarantee of `verify.py`.

| mode     | output           | left when                           |
|----------|------------------|-------------------------------------|
| starting | zero             | there are measurements and commands |
| running  | the command      | something is wrong                  |
| stopping | the braking ramp | it is at zero                       |
| stopped  | zero             | released, and nothing is wrong      |

A stop is latched: no other event ends the modes stopping and stopped.
"""

import dataclasses as dc
import math

from remosplat_drake.robot.braking import (
    braking_command,
)
from remosplat_drake.safety.supervision import Observation, SupervisorLaw
from remosplat_drake.safety.symptoms import (
    Symptom,
    kept_clearance,
    symptoms,
)
from remosplat_drake.signals.supervisor_state import (
    ASKED,
    CLEARANCE,
    RUNNING,
    STARTING,
    STOPPED,
    STOPPING,
    UNARMED,
    SupervisorState,
)

_ROUNDING = 1e-9
"""Bound of the rounding error of a sum of periods [s]."""


def supervise(
    law: SupervisorLaw, state: SupervisorState, now: Observation
) -> SupervisorState:
    """Advances the supervisor by one control tick.

    Args:
        law: The thresholds and limits.
        state: The supervisor's state after the previous tick.
        now: The inputs of this tick.

    Returns:
        The next state, with the command to execute until the next tick.
    """
    found = symptoms(law, state, now)
    is_clear = all(symptom.name != CLEARANCE for symptom in found)
    since = _since(state, found, now.time)
    tripped = _tripped(found, since, now)
    elapsed = law.elapsed(state.time, now.time)
    state = dc.replace(
        state,
        time=now.time,
        p_WTs=now.report.p_WTs,
        kept_clearance=kept_clearance(state, now),
        since=since,
        payload=now.report.payload,
        map_revision=(
            now.report.clearances.revision if is_clear else state.map_revision
        ),
    )
    if state.mode == STOPPED:
        return _rest(state, now, found)
    if state.mode == STOPPING:
        return _brake(law, state, elapsed)
    missing = _missing(now) if state.mode == STARTING else ""
    if missing and not now.stop:
        return dc.replace(state, reason=missing)
    if tripped:
        return _brake(law, _with_reason(state, tripped), elapsed)
    state = _with_reason(state, Symptom("", ""))
    return dc.replace(state, mode=RUNNING, command=now.command)


def _since(
    state: SupervisorState, found: list[Symptom], time: float
) -> dict[str, float]:
    """Returns each symptom's start time; all restart if the clock goes back."""
    known = {} if time < state.time else state.since
    return {symptom.name: known.get(symptom.name, time) for symptom in found}


def _tripped(
    found: list[Symptom], since: dict[str, float], now: Observation
) -> Symptom | None:
    """Returns the earliest symptom that has lasted too long, if any."""
    if now.stop:
        return Symptom(ASKED, now.stop)
    causes = [
        symptom
        for symptom in found
        if not now.time - since[symptom.name] < symptom.dwell - _ROUNDING
    ]
    return min(causes, key=lambda cause: since[cause.name], default=None)


def _missing(now: Observation) -> str:
    """Returns the condition that a start waits for; empty if there is none."""
    if now.status.age == math.inf:
        return "waiting for the first measurement"
    if math.isnan(now.report.time):
        return "waiting for the first control tick"
    return ""


def _brake(
    law: SupervisorLaw, state: SupervisorState, elapsed: float
) -> SupervisorState:
    command = braking_command(state.command, law.acceleration, elapsed)
    mode = STOPPING if command.any() else STOPPED
    return dc.replace(state, mode=mode, command=command)


def _with_reason(state: SupervisorState, why: Symptom) -> SupervisorState:
    return dc.replace(
        state,
        reason=why.message,
        symptom=why.name,
        axis=why.axis,
        refusal="",
    )


def _rest(
    state: SupervisorState, now: Observation, found: list[Symptom]
) -> SupervisorState:
    """Ends a stop if a release is requested and there is no symptom."""
    if not now.release:
        # If the robot is not armed yet, the reason of a requested stop replaces
        # the reason that it is not armed.
        if state.reason == UNARMED and now.stop:
            return dc.replace(state, reason=now.stop, symptom=ASKED)
        return state
    obstacle = now.stop or (found and found[0].message)
    if obstacle:
        return dc.replace(state, refusal=f"not released: {obstacle}")
    return dc.replace(_with_reason(state, Symptom("", "")), mode=STARTING)
