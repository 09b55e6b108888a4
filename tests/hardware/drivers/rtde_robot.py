"""A process: an arm behind Universal Robots' ports, which does as it is told.

    python rtde_robot.py ADDRESS RECORD

SIGUSR1 is a protective stop. RECORD holds time, safety mode, positions and
rates of every millisecond. The arm says "rests" when its program has ended and
it has come to rest.

Its clock runs slower than the wall's and stands still while the computer has no
time for it: the controller's watchdog of 0.1 s shall see a driver that has
ended, not a computer that is busy.
"""

import signal
import sys
import time

import numpy as np

from remosplat_drake.base.clock import Pacer
from remosplat_drake.base.real_time import DRIVER_PRIORITY, realtime_priority
from remosplat_drake.base.stop_signals import stop_signals
from remosplat_drake.hardware.drivers.panda_limits import TICK
from remosplat_drake.hardware.stand_in.rtde_arm import RtdeArm
from remosplat_drake.hardware.stand_in.simulated_arm import (
    ArmMeasurement,
    RobotMode,
)

SLOWER = 4.0
"""Time by the wall clock in a time of the robot."""

Q_START = np.array([0.0, -1.8, 1.9, -1.67, -1.57, 0.0])


def main(address: str, record: str) -> None:
    arm, pacer = RtdeArm(address), Pacer(SLOWER * TICK, patience=TICK)
    q, v, zero = Q_START.copy(), np.zeros(6), np.zeros(6)
    rows, was_running = [], False
    signal.signal(signal.SIGUSR1, lambda *_: arm.stop(RobotMode.REFLEX))
    with realtime_priority(DRIVER_PRIORITY), stop_signals() as request:
        print("ready", flush=True)
        while not request.made:
            pacer.wait()
            v = arm.step(ArmMeasurement(q, v, zero, zero))
            q = q + TICK * v
            was_running |= arm.rules.is_running
            if was_running and not arm.rules.is_running and not v.any():
                was_running = False
                print("rests", flush=True)
            rows.append((time.time(), arm.rules.safety_mode, *q, *v))
    np.save(record, np.array(rows))


if __name__ == "__main__":
    main(*sys.argv[1:])
