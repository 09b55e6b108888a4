"""A process: an arm behind the stand-in's FCI, which does what it is told.

    python fci_robot.py PORT RECORD

SIGUSR1 is its user stop. RECORD holds time, mode, positions and rates of every
millisecond.
"""

import signal
import sys
import time

import numpy as np

from remosplat_drake.base.clock import Pacer
from remosplat_drake.base.real_time import DRIVER_PRIORITY, realtime_priority
from remosplat_drake.base.stop_signals import stop_signals
from remosplat_drake.hardware.drivers.panda_limits import TICK
from remosplat_drake.hardware.stand_in.fci_arm import FciArm
from remosplat_drake.hardware.stand_in.simulated_arm import (
    ArmMeasurement,
    RobotMode,
)

PERIOD = 5e-3
"""How long the robot's millisecond lasts here [s]: the machine that runs the
tests may be busy for longer than a real robot would bear."""

Q_START = np.array([0.0, -0.6, 0.0, -2.2, 0.0, 1.6, 0.8])


def main(port: str, record: str) -> None:
    arm, pacer = FciArm(int(port)), Pacer(PERIOD)
    q, v, zero = Q_START.copy(), np.zeros(7), np.zeros(7)
    rows = []
    signal.signal(signal.SIGUSR1, lambda *_: arm.stop(RobotMode.USER_STOPPED))
    with realtime_priority(DRIVER_PRIORITY), stop_signals() as request:
        print("ready", flush=True)
        while not request.made:
            pacer.wait()
            v = arm.step(ArmMeasurement(q, v, zero, zero))
            q = q + TICK * v
            rows.append((time.time(), arm.rules.mode, *q, *v))
    np.save(record, np.array(rows))


if __name__ == "__main__":
    main(*sys.argv[1:])
