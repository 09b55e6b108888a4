"""Checks during which the robot moves, or a person presses a button."""

import dataclasses as dc
import re
import time
from collections.abc import Callable, Sequence
from pathlib import Path

import numpy as np

from remosplat_drake.base.errors import RemoSplatError
from remosplat_drake.hardware.client.measurement import Measurement
from remosplat_drake.hardware.client.robot_link import RobotLink
from remosplat_drake.hardware.doctor.finding import (
    ADVICE,
    FAILED,
    SKIPPED,
    Finding,
    judged,
)
from remosplat_drake.hardware.hardware_config import HardwareConfig
from remosplat_drake.hardware.wire import panda as panda_wire
from remosplat_drake.hardware.wire.base import MODE_NAMES
from remosplat_drake.hardware.wire.messages.base_status import base_status
from remosplat_drake.robot.robot_model import RobotModel

BASE_STEP, USER_STOP, EMERGENCY_STOP = (
    "base-step",
    "user-stop",
    "emergency-stop",
)

DRILLS = {
    BASE_STEP: "the base drives 10 cm forward",
    USER_STOP: "a person presses the arm's user stop",
    EMERGENCY_STOP: "a person presses the base's emergency stop",
}
"""Descriptions of the drills, keyed by name."""

STEP_SPEED, STEP_DURATION = 0.1, 1.0
"""Speed and duration of the base's motion for the step response [m/s, s]."""

LONGEST_DELAY = 0.5
"""Longest permitted time until the base has made half of a commanded change of
speed [s].
"""

PATIENCE = 60.0
"""Longest wait for a person to press or release a button [s]."""

_PERIOD = 0.02
_STANDING = 0.01
_SILENT = 0.5


def needed_drills(has_base: bool) -> tuple[str, ...]:
    """Returns the drills that a robot must pass before a run.

    Args:
        has_base: Whether the robot has a mobile base.
    """
    return tuple(DRILLS) if has_base else (USER_STOP,)


class WatchedRobot:
    """Receives the statuses of a robot, and sends nothing.

    Attributes:
        measurement: The last measurement.
    """

    def __init__(self, config: HardwareConfig, robot: RobotModel):
        """Joins the LCM network.

        Args:
            config: The LCM network and its channels.
            robot: The robot.
        """
        # In shadow mode, the link publishes nothing, not even by mistake.
        self._link = RobotLink(dc.replace(config, shadow=True), robot)
        self.measurement = Measurement()

    def listen(self) -> None:
        """Receives messages for one period."""
        end = time.monotonic() + _PERIOD
        while time.monotonic() < end:
            self._link.lcm.HandleSubscriptions(5)
        self._link.take_out()
        self.measurement = self._link.updated(self.measurement)

    def arm_stop(self) -> str:
        """Describes the sign of a stop in the arm's statuses, or ""."""
        arm = self.measurement.arm
        silence = time.time() - self.measurement.arm_stream.received
        if arm is None or silence > _SILENT:
            return "its statuses cease: the driver has ended"
        mode = panda_wire.MODE_NAMES[arm.robot_mode]
        return "" if mode in ("idle", "move", "other") else f"mode {mode}"

    def base_stop(self) -> str:
        """Describes the sign of a stop in the base's statuses, or ""."""
        base = self.measurement.base
        silence = time.time() - self.measurement.base_stream.received
        if base is None or silence > _SILENT:
            return "its statuses cease"
        if base.emergency_stop:
            return "emergency stop"
        stops = (base_status.STOPPED, base_status.FAULT)
        return f"mode {MODE_NAMES[base.mode]}" if base.mode in stops else ""


@dc.dataclass(frozen=True)
class StepResponse:
    """Response of the base to a step of its commanded speed.

    Attributes:
        rise: Time until the base had half of the commanded speed [s]; inf if it
            never had.
        fall: Time from the end of the command until the base had less than half
            of the commanded speed [s].
        speed: Greatest speed of the base [m/s].
        rest: Speed of the base at the end [m/s].
    """

    rise: float
    fall: float
    speed: float
    rest: float


def step_response(times: np.ndarray, speeds: np.ndarray) -> StepResponse:
    """Evaluates a step that begins at time 0 and ends at `STEP_DURATION`.

    Args:
        times: Times of the measurements, ascending, shape (n,) [s].
        speeds: Measured speeds, shape (n,) [m/s].
    """
    fast = speeds > STEP_SPEED / 2
    rises = times[fast]
    falls = times[~fast & (times > STEP_DURATION)]
    return StepResponse(
        rise=float(rises[0]) if len(rises) else np.inf,
        fall=float(falls[0]) - STEP_DURATION if len(falls) else np.inf,
        speed=float(speeds.max(initial=0.0)),
        rest=float(abs(speeds[-1])) if len(speeds) else np.inf,
    )


def base_step(robot: RobotModel, period: float) -> np.ndarray:
    """Makes the commands for the step, one row per control period, (k, n_u).

    Args:
        robot: The robot; the acceleration limit of its base determines the
            duration of the step's ramps.
        period: Control period [s].
    """
    rise = max(STEP_SPEED / robot.acceleration_limit[0], period)
    times = np.arange(0.0, 2.5 * STEP_DURATION, period)
    ends = [0.0, rise, STEP_DURATION, STEP_DURATION + rise]
    u = np.zeros((len(times), robot.n_u))
    u[:, 0] = np.interp(times, ends, [0.0, STEP_SPEED, STEP_SPEED, 0.0])
    return u


def drill_base_step(
    drive: Callable[[], tuple[np.ndarray, np.ndarray]],
) -> Finding:
    """Drives the base forward for a moment, and checks its response.

    Args:
        drive: Function that sends the commands of `base_step`, through
            supervisor and station as in a run. It returns the times of the
            ticks since the first tick, shape (n,) [s], and the measured speeds,
            shape (n,) [m/s]. If the motion fails, it raises a RemoSplatError
            with the reason.
    """
    wanted = (
        f"{STEP_SPEED} m/s forward and back to rest, each half within"
        f" {1e3 * LONGEST_DELAY:.0f} ms"
    )
    source = "BASE_STATUS during a command of 1 s"
    remedy = (
        "look for stops of the base, limits of its node, another sender of"
        " its commands, and obstacles"
    )
    try:
        times, speeds = drive()
    except RemoSplatError as error:
        return Finding(BASE_STEP, FAILED, str(error), wanted, source, remedy)
    response = step_response(times, speeds)
    return judged(
        BASE_STEP,
        max(response.rise, response.fall) <= LONGEST_DELAY
        and response.speed > 0.8 * STEP_SPEED
        and response.rest < _STANDING,
        found=f"half of the speed {1e3 * response.rise:.0f} ms after the"
        f" command's start, and again {1e3 * response.fall:.0f} ms after its"
        f" end; greatest speed {response.speed:.3f} m/s",
        wanted=wanted,
        source=source,
        remedy=remedy,
    )


def drill_stop(
    name: str,
    stopped: Callable[[], str],
    robot: WatchedRobot,
    say: Callable[[str], None],
    patience: float = PATIENCE,
) -> Finding:
    """Waits for a person to press a stop, and checks that its reset is safe.

    Args:
        name: `USER_STOP` for the arm, or `EMERGENCY_STOP` for the base.
        stopped: Function that describes the sign of the stop in the statuses,
            or returns "".
        robot: The robot.
        say: Function that prints an instruction for the person.
        patience: Longest wait for the person [s].
    """
    part = "arm" if name == USER_STOP else "base"
    say(f"press the {name.replace('-', ' ')} of the {part} now")
    found = _wait(robot, stopped, patience)
    wanted = "the statuses show the stop or cease; its reset causes no motion"
    source = "modes in the statuses, or their absence"
    if not found:
        return judged(
            name,
            False,
            found=f"no stop within {patience:.0f} s",
            wanted=wanted,
            source=source,
            remedy="if the driver does not report stops, configure a topic for"
            " them, or an ARCL connection",
        )
    say(f"{found}; now reset the stop, and restart a driver that has ended")
    _wait(robot, lambda: "" if stopped() else "reset", patience)
    moved = _watch_rest(robot)
    return judged(
        name,
        not stopped() and moved < _STANDING,
        found=f"{found}; afterwards the {part} "
        + ("is still stopped" if stopped() else f"moved at {moved:.3f}"),
        wanted=wanted,
        source=source,
        remedy="reset the stop and start the driver again; find out why it"
        " moved",
    )


def _wait(robot: WatchedRobot, done: Callable[[], str], patience: float) -> str:
    end = time.monotonic() + patience
    while time.monotonic() < end:
        robot.listen()
        if text := done():
            return text
    return ""


def _watch_rest(robot: WatchedRobot) -> float:
    """Measures for a second without commands; returns the largest speed."""
    fastest, end = 0.0, time.monotonic() + 1.0
    while time.monotonic() < end:
        robot.listen()
        arm, base = robot.measurement.arm, robot.measurement.base
        if arm is not None:
            fastest = max(fastest, float(np.abs(arm.v).max()))
        if base is not None:
            fastest = max(fastest, float(np.abs(base.velocity).max()))
    return fastest


def check_actuators(robot: RobotModel) -> Finding:
    """Checks that the robot's description contains measured actuators.

    Args:
        robot: The robot.
    """
    measured = bool(robot.description.actuators)
    return judged(
        "actuators",
        measured,
        found="measured" if measured else "cautious defaults",
        wanted="measured actuators, so that the robot is faster near obstacles",
        source=f"actuators in {Path(robot.description.source).name}",
        remedy="run `remosplat identify` as soon as the robot moves",
        otherwise=ADVICE,
    )


def check_thresholds(processes: Path = Path("/proc")) -> Finding:
    """Checks the collision thresholds of the arm's driver.

    Statuses do not contain the thresholds. Those set in Franka's Desk have no
    effect, since the driver sets its own thresholds. If the driver runs on this
    computer, its command line contains them.

    Args:
        processes: Folder of the process information, /proc.
    """
    check = "collision thresholds"
    wanted = "at most 40 N m and 40 N, set by the driver"
    remedy = (
        "start the driver with --joint_torque_limit=20"
        " --cartesian_force_limit=20; its defaults are 100 N m and 100 N"
    )
    for path in sorted(processes.glob("[0-9]*/cmdline")):
        try:
            line = path.read_bytes().decode("utf-8", "replace").split("\0")
        except OSError:
            continue
        limits = driver_limits(line)
        if limits is not None:
            return judged(
                check,
                max(limits) <= 40,
                found=f"{limits[0]:g} N m, {limits[1]:g} N",
                wanted=wanted,
                source=f"command line of process {path.parent.name}",
                remedy=remedy,
                otherwise=ADVICE,
            )
    return Finding(
        check,
        SKIPPED,
        "no driver of an arm runs on this computer",
        wanted,
        "command lines of processes",
        "check the flags of the driver's command line: " + remedy,
    )


def driver_limits(line: Sequence[str]) -> tuple[float, float] | None:
    """Reads the limits with which a driver of an arm was started.

    Args:
        line: A command line.

    Returns:
        The joint torque [N m] and the force [N] at which the driver stops for a
        collision; None for another program.
    """
    if "franka_driver" in Path(line[0]).name:
        otherwise = 100.0
    elif "panda-driver" in line and "--hand" not in line:
        otherwise = 20.0
    else:
        return None
    text = " ".join(line)

    def limit(flag: str) -> float:
        pattern = flag.replace("-", "[-_]") + r"[= ]([\d.]+)"
        match = re.search(pattern, text)
        return float(match[1]) if match else otherwise

    return limit("--joint-torque-limit"), limit("--cartesian-force-limit")
