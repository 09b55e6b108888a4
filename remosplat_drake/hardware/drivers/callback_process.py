"""`CallbackProcess`: runs the arm's 1 kHz control in a separate process.

The arm's controller requires a command every millisecond, which a callback
computes. The process that exchanges LCM messages cannot delay the callback,
since no other thread uses the callback's Python interpreter, and garbage
collection is off. If the LCM process ends, the callback's process continues
until the arm is at rest.
"""

import signal
import time
from collections.abc import Sequence
from contextlib import suppress
from multiprocessing.connection import Connection

from remosplat_drake.base.child_process import ChildProcess
from remosplat_drake.base.clock import wall_utime
from remosplat_drake.base.errors import RemoSplatError
from remosplat_drake.base.real_time import (
    DRIVER_PRIORITY,
    garbage_collection_disabled,
    realtime_priority,
)
from remosplat_drake.hardware.drivers.arm_record import RECORD_SIZE, arm_record
from remosplat_drake.hardware.drivers.franka_arm import (
    CollisionLimits,
    FrankaArm,
)
from remosplat_drake.hardware.drivers.shared_record import SharedRecord
from remosplat_drake.hardware.drivers.velocity_callback import (
    SETPOINT_SIZE,
    VelocityCallback,
)
from remosplat_drake.hardware.drivers.velocity_servo import VelocityServo

STALLED = 0.1
"""The callback counts as stalled after this time without a state [s]. By then,
the robot has aborted its motion, which it does after 20 ms.
"""

_READY = ""
_AFTERWARDS = 0.05


class CallbackProcess:
    """The driver's connection to the process that runs the 1 kHz callback."""

    def __init__(self, library: str, host: str, limits: CollisionLimits):
        """Starts the process, and waits until it controls the arm.

        Args:
            library: Name of the module with libfranka's interface.
            host: Name or address of the arm's controller.
            limits: Collision thresholds of the arm.

        Raises:
            RemoSplatError: The process cannot control the arm; the error
                contains the reason.
        """
        self._setpoints = SharedRecord(SETPOINT_SIZE)
        self._states = SharedRecord(RECORD_SIZE)
        self._told = self._states.read()
        self._heard = time.monotonic()
        self._child = ChildProcess(_control, "panda callback", 0)
        self._child.start(library, host, limits, self._setpoints, self._states)
        self._connection, _ = self._child.wait_until_started()
        problem = self._answer()
        if problem != _READY:
            self.close()
            raise RemoSplatError(problem)
        self._heard = time.monotonic()

    def command(self, velocity: Sequence[float], end: bool = False) -> None:
        """Passes a setpoint, which expires soon, to the callback.

        Args:
            velocity: Joint rates, seven [rad/s].
            end: Whether to end the motion when the arm is at rest.
        """
        self._setpoints.write((time.monotonic(), float(end), *velocity))

    def fresh_record(self) -> tuple[float, ...] | None:
        """Returns the latest `arm_record`; None if there is no new one."""
        record = self._states.read()
        if record == self._told:
            return None
        self._told = record
        self._heard = time.monotonic()
        return record

    def problem(self) -> str:
        """Returns the reason why the arm is not controlled any more, or ""."""
        if self._child.has_news():
            return self._answer() or "the motion has ended"
        silence = time.monotonic() - self._heard
        if silence > STALLED:
            return (
                f"the 1 kHz callback has been silent for {silence:.2f} s: the"
                " robot aborts its motion after 20 lost packets"
            )
        return ""

    def close(self) -> None:
        """Ends the process; the arm should be at rest before."""
        self._child.end()
        self._setpoints.close()
        self._states.close()

    def _answer(self) -> str:
        try:
            return self._connection.recv()
        except EOFError:
            return "the 1 kHz callback's process has crashed"


def _control(
    connection: Connection,
    library: str,
    host: str,
    limits: CollisionLimits,
    setpoints: SharedRecord,
    states: SharedRecord,
) -> None:
    """The main function of the process, which controls the arm."""
    # The motion ends if a setpoint requests the end, or if no setpoint comes.
    signal.signal(signal.SIGTERM, signal.SIG_IGN)
    try:
        with realtime_priority(DRIVER_PRIORITY), garbage_collection_disabled():
            arm = FrankaArm(library, host)
            arm.take(limits)
            servo = VelocityServo()
            callback = VelocityCallback(
                servo, setpoints, states, arm.library.JointVelocities
            )
            states.write(arm_record(arm.state(), servo.command, wall_utime()))
            connection.send(_READY)
            aborted = arm.move(callback)
            problem = aborted or servo.reason
            if aborted:
                _tell_of_abort(arm, servo, states)
    except RemoSplatError as error:
        problem = str(error)
    finally:
        setpoints.close()
        states.close()
    with suppress(OSError):
        connection.send(problem)


def _tell_of_abort(
    arm: FrankaArm, servo: VelocityServo, states: SharedRecord
) -> None:
    """Sends the arm's mode, which contains the cause of a stop."""
    end = time.monotonic() + _AFTERWARDS
    with suppress(RemoSplatError):
        while time.monotonic() < end:
            record = arm_record(arm.state(), servo.command, wall_utime())
            states.write(record)
