"""Finds symptoms, the faults at a control tick that stop the robot."""

import dataclasses as dc
import math
from collections.abc import Iterator

import numpy as np

from remosplat_drake.robot.braking import (
    executed_command,
)
from remosplat_drake.safety.supervision import Observation, SupervisorLaw
from remosplat_drake.signals import station_status, tick_report
from remosplat_drake.signals.motion import Motion
from remosplat_drake.signals.near_movers import mover_at
from remosplat_drake.signals.supervisor_state import (
    ARM_MODE,
    ARM_RATE,
    CLEARANCE,
    JUMP,
    LOST,
    RUNNING,
    SCANNER,
    STARTING,
    STOPPED,
    SupervisorState,
)

_SOLVER = 1e-3
"""Relative tolerance by which a solver's command may exceed a bound."""

_ROUNDING = 1e-6
"""An error of predicted positions up to this value counts as a rounding error
[m, rad]. This tolerance is needed because a robot's description may state
delays without an error bound (tube)."""

_TOUCH = 1e-6
"""The robot counts as touching the scene if a clearance is below this value
[m]."""


@dc.dataclass(frozen=True)
class Symptom:
    """A fault at a control tick.

    Attributes:
        name: Name of the rule that found the symptom.
        message: Description of the fault for a person.
        dwell: Time for which the symptom may last before the robot must stop
            [s].
        axis: Index in u of the axis that the symptom concerns; None if it
            concerns no single axis.
    """

    name: str
    message: str
    dwell: float = 0.0
    axis: int | None = None


def symptoms(
    law: SupervisorLaw, state: SupervisorState, now: Observation
) -> list[Symptom]:
    """Finds all symptoms at a control tick, the most informative first.

    A value of NaN is always a symptom.

    Args:
        law: The thresholds and limits.
        state: The supervisor's state after the previous tick. Its command is
            being executed.
        now: The inputs of this tick.
    """
    return [
        *_of_clock(law, state, now),
        *_of_station(law, now),
        *_of_motion(law, state, now),
        *_of_tick(law, now),
        *_of_bounds(law, state, now),
        *_of_clearance(law, state, now),
        *_of_target_and_map(law, state, now),
        *_of_movers(law, now),
    ]


def _has_paused(
    law: SupervisorLaw, state: SupervisorState, now: Observation
) -> bool:
    """Returns whether the control loop has paused for too long."""
    return now.time - state.time > law.dt + law.config.max_overrun


def _of_clock(
    law: SupervisorLaw, state: SupervisorState, now: Observation
) -> Iterator[Symptom]:
    pause = now.time - state.time
    if not math.isfinite(now.time):
        yield Symptom("clock", "the clock is not finite")
    elif pause < 0:
        yield Symptom("clock", f"the clock went back by {-pause:.3g} s")
    elif _has_paused(law, state, now):
        yield Symptom("clock", f"the control loop paused for {pause:.3g} s")


def _of_station(law: SupervisorLaw, now: Observation) -> Iterator[Symptom]:
    config, status = law.config, now.status
    if status.protective_stop:
        yield Symptom(SCANNER, "protective stop of the base")
    if status.robot_mode not in config.robot_modes:
        yield Symptom(ARM_MODE, f"the arm's mode is {status.robot_mode}")
    if status.mode != station_status.RUNNING:
        reason = status.stop_reason or "it gives no reason"
        name = LOST if status.is_lost else "station"
        yield Symptom(name, f"the station stopped: {reason}")
    if not status.age <= config.max_status_age:
        age = f"{1e3 * status.age:.0f} ms"
        yield Symptom("status_age", f"measurements are {age} old")
    if not status.success_rate >= config.min_success_rate:
        share = f"{100 * status.success_rate:.0f} %"
        yield Symptom(
            ARM_RATE,
            f"only {share} of the commands reach the arm in time",
            config.success_rate_dwell,
        )


def _of_motion(
    law: SupervisorLaw, state: SupervisorState, now: Observation
) -> Iterator[Symptom]:
    if not np.isfinite(now.u_measured).all():
        yield Symptom("measurement", "measured velocities are not finite")
        return
    if not law.obeyed:
        return
    motion = now.motion
    expected = executed_command(
        state.command,
        law.acceleration,
        law.dt,
        law.elapsed(state.time, now.time),
    )
    if motion is not None:
        expected = motion.v_measured
        yield from _of_tracking(law, motion)
    error = np.abs(expected - now.u_measured) / law.velocity
    if error.max() > law.config.max_follow_error:
        i = int(error.argmax())
        yield Symptom(
            "follow",
            "the robot does not follow its command:"
            f" u[{i}] is {now.u_measured[i]:.2f}, not {expected[i]:.2f}",
            law.config.follow_dwell,
            i,
        )


def _of_tracking(law: SupervisorLaw, motion: Motion) -> Iterator[Symptom]:
    bound = law.config.max_tracking_error * motion.bound + _ROUNDING
    if not (motion.residual <= bound).all():
        i = int((motion.residual / bound).argmax())
        yield Symptom(
            "tracking",
            "the robot's motion deviates from its actuator model: axis"
            f" {i} is off by {motion.residual[i]:.3f}, beyond {bound[i]:.3f};"
            " `remosplat identify` measures the model",
            axis=i,
        )


def _of_tick(law: SupervisorLaw, now: Observation) -> Iterator[Symptom]:
    config, report = law.config, now.report
    if not np.isfinite(now.command).all():
        yield Symptom("command", "the command is not finite")
    if not np.isfinite(report.q).all():
        yield Symptom("configuration", "measured positions are not finite")
    if not now.time - report.time <= config.max_tick_age:
        age = f"{1e3 * (now.time - report.time):.0f} ms"
        yield Symptom("tick_age", f"the latest control tick is {age} old")
    if report.status == tick_report.BRAKING:
        yield Symptom(
            "braking",
            f"no command for {config.max_braking_time:g} s: {report.reason}",
            config.max_braking_time,
        )


def _of_bounds(
    law: SupervisorLaw, state: SupervisorState, now: Observation
) -> Iterator[Symptom]:
    if not law.strict or state.mode not in (STARTING, RUNNING):
        return
    step = law.acceleration * law.elapsed(state.time, now.time)
    for what, value, bound in (
        ("is", now.command, law.velocity),
        ("changes by", now.command - state.command, step),
    ):
        share = np.abs(value) / bound
        if share.max() > 1.0 + _SOLVER:
            i = int(share.argmax())
            yield Symptom(
                "bounds",
                f"the command is out of bounds: u[{i}] {what} {value[i]:.3f},"
                f" beyond {bound[i]:.3f}",
                axis=i,
            )


def _of_clearance(
    law: SupervisorLaw, state: SupervisorState, now: Observation
) -> Iterator[Symptom]:
    clearances, least = now.report.clearances, law.min_clearance
    if clearances.minimum() >= least:
        return
    row = int(clearances.distance.argmin())
    mover = mover_at(now.movers, now.time, clearances.p_WC[row])
    if mover:
        yield Symptom(
            CLEARANCE,
            f"{mover} came nearer than {1e3 * least:.1f} mm, to"
            f" {1e3 * clearances.minimum():.1f} mm",
            law.config.clearance_dwell,
        )
        return
    # A robot that starts too near to the scene may move away from it, since
    # verification ensures that no command reduces the present clearance. The
    # robot must not come nearer again later.
    kept = kept_clearance(state, now)
    least = min(least, kept - law.config.clearance_margin)
    if kept > 0.0:
        least = max(least, _TOUCH)
    if clearances.is_known and clearances.minimum() >= least:
        return
    # If the map has just changed, the text states that this is the clearance in
    # the new map.
    maps = {state.map_revision, clearances.revision}
    is_new = "" not in maps and len(maps) == 2
    yield Symptom(
        CLEARANCE,
        ("in the new map the " if is_new else "")
        + f"clearance {1e3 * clearances.minimum():.1f} mm is below"
        f" {1e3 * least:.1f} mm",
        law.config.clearance_dwell,
    )


def kept_clearance(state: SupervisorState, now: Observation) -> float:
    """Returns the largest clearance since the start of motion [m].

    Before the robot starts, the result is the present clearance. After a stop
    it is at least `_TOUCH`, so that a robot in contact is not released. If the
    payload changes, it is the present clearance again, since the new payload
    may be near the scene.

    Args:
        state: The supervisor's state after the previous tick.
        now: The inputs of this tick.
    """
    present = now.report.clearances.minimum()
    if state.mode in (STARTING, STOPPED):
        return max(present, _TOUCH) if state.mode == STOPPED else present
    if now.report.payload != state.payload:
        return present
    return max(state.kept_clearance, present)


def _of_target_and_map(
    law: SupervisorLaw, state: SupervisorState, now: Observation
) -> Iterator[Symptom]:
    config = law.config
    if config.max_target_jump is not None:
        jumps = now.report.p_WTs - state.p_WTs
        jump = float(np.linalg.norm(jumps, axis=1).max())
        if jump > config.max_target_jump:
            yield Symptom(JUMP, f"the target jumped by {jump:.2f} m")
    if config.max_map_age is not None and not now.map_age <= config.max_map_age:
        yield Symptom("map_age", f"the map is {now.map_age:.3g} s old")


def _of_movers(law: SupervisorLaw, now: Observation) -> Iterator[Symptom]:
    """Yields symptoms of stale movers, and of cameras without new images.

    A time stamp in the future is a symptom, too.
    """
    if now.movers is None:
        return
    movers, longest = now.movers, law.config.max_movers_age
    if not abs(now.time - movers.stamp) <= longest:
        cause = movers.problem or "no newer state has arrived"
        yield Symptom("movers_age", f"movers are not known: {cause}")
    for camera in movers.cameras:
        age = now.time - camera.seen
        if not abs(age) <= longest:
            cause = camera.problem or "no image has arrived"
            yield Symptom(
                "camera_age",
                f"{camera.name} has no usable image for {age:.2g} s: {cause}",
            )
