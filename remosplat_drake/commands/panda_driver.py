"""`remosplat panda-driver`: between the station's wire and a real Panda."""

import argparse
import gc

from pydrake.lcm import DrakeLcm
from rich.console import Console

from remosplat_drake.base.clock import Pacer, wall_utime
from remosplat_drake.base.errors import RemoSplatError
from remosplat_drake.base.real_time import DRIVER_PRIORITY, realtime_priority
from remosplat_drake.base.stop_signals import stop_signals
from remosplat_drake.commands.wire import (
    add_wire_argument,
    leased_inbox,
    open_wire,
)
from remosplat_drake.hardware.drivers.hand_driver import HandDriver
from remosplat_drake.hardware.drivers.hand_messages import PERIOD
from remosplat_drake.hardware.drivers.panda_driver import PandaDriver
from remosplat_drake.hardware.drivers.panda_limits import TICK
from remosplat_drake.hardware.drivers.panda_python_arm import PandaPythonArm
from remosplat_drake.hardware.drivers.panda_python_hand import PandaPythonHand
from remosplat_drake.hardware.wire.channels import (
    PANDA_COMMAND,
    PANDA_HAND_COMMAND,
)


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declares the command's flags."""
    parser.add_argument("host", help="name or address of the arm's controller")
    add_wire_argument(parser)
    parser.add_argument(
        "--hand",
        action="store_true",
        help="drive the hand in place of the arm: it needs a process of its"
        " own",
    )


def run(arguments: argparse.Namespace) -> int:
    """Drives the arm or the hand until Ctrl-C."""
    drive = _drive_hand if arguments.hand else _drive_arm
    # Before there are threads: libfranka gives its own a priority.
    with realtime_priority(DRIVER_PRIORITY):
        drive(open_wire(arguments.lcm_url), arguments)
    return 0


def _drive_arm(lcm: DrakeLcm, arguments: argparse.Namespace) -> None:
    arm = PandaPythonArm(arguments.host)
    inbox = leased_inbox(
        lcm, [PANDA_COMMAND], "panda-driver", Console(stderr=True)
    )
    driver = PandaDriver(lcm, arm, inbox)
    pacer = Pacer(TICK)
    gc.collect()
    gc.freeze()
    with stop_signals() as request:
        _announce(arguments)
        try:
            while not request.made:
                pacer.wait()
                driver.step(wall_utime())
                problem = arm.problem()
                if problem:
                    raise RemoSplatError(f"the arm has stopped: {problem}")
        finally:
            request.is_heeded = True
            _release(arm, driver, pacer)


def _release(arm: PandaPythonArm, driver: PandaDriver, pacer: Pacer) -> None:
    """Brings the arm to rest and gives up control, even if it resists."""
    try:
        while not driver.brake():
            pacer.wait()
    finally:
        arm.close()


def _drive_hand(lcm: DrakeLcm, arguments: argparse.Namespace) -> None:
    inbox = leased_inbox(
        lcm,
        [PANDA_HAND_COMMAND],
        "panda-driver --hand",
        Console(stderr=True),
    )
    driver = HandDriver(lcm, PandaPythonHand(arguments.host), inbox)
    pacer = Pacer(PERIOD)
    with stop_signals() as request:
        _announce(arguments)
        while not request.made:
            pacer.wait()
            driver.step(wall_utime())


def _announce(arguments: argparse.Namespace) -> None:
    """Prints that the robot is under control, and how to end that."""
    Console(stderr=True).print(
        f"{arguments.lcm_url} <-> {arguments.host}; Ctrl-C ends"
    )
