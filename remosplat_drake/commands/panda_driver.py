"""`remosplat panda-driver`: connects a real Panda with the controller."""

import argparse

from pydrake.lcm import DrakeLcm

from remosplat_drake.base.clock import Pacer, wall_utime
from remosplat_drake.base.errors import RemoSplatError
from remosplat_drake.base.real_time import (
    DRIVER_PRIORITY,
    garbage_collection_disabled,
    realtime_priority,
)
from remosplat_drake.base.stop_signals import stop_signals
from remosplat_drake.commands.number_flags import positive
from remosplat_drake.commands.tables import open_console
from remosplat_drake.commands.wire import (
    add_wire_argument,
    leased_inbox,
    open_wire,
)
from remosplat_drake.hardware.drivers.arm_record import (
    arm_record,
    panda_status,
)
from remosplat_drake.hardware.drivers.callback_process import CallbackProcess
from remosplat_drake.hardware.drivers.franka_arm import (
    LIBFRANKA,
    CollisionLimits,
    FrankaArm,
)
from remosplat_drake.hardware.drivers.franka_host import check_reachable
from remosplat_drake.hardware.drivers.hand_driver import HandDriver
from remosplat_drake.hardware.drivers.hand_messages import PERIOD
from remosplat_drake.hardware.drivers.panda_driver import PandaDriver
from remosplat_drake.hardware.drivers.panda_limits import AT_REST, TICK
from remosplat_drake.hardware.drivers.panda_python_hand import PandaPythonHand
from remosplat_drake.hardware.stand_in import fci_library
from remosplat_drake.hardware.wire.channels import (
    COMMAND_RAMP,
    PANDA_COMMAND,
    PANDA_HAND_COMMAND,
    PANDA_STATUS,
)

EXAMPLES = """
remosplat panda-driver 172.16.0.2 --status-only
remosplat panda-driver 172.16.0.2 --hand
"""
"""Examples at the end of `--help`."""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declares the command's flags."""
    parser.add_argument(
        "host",
        help="host name or address of the arm's control unit; with "
        "--simulated, the port of `remosplat hardware-sim --fci PORT`",
    )
    add_wire_argument(parser)
    parser.add_argument(
        "--hand",
        action="store_true",
        help="drive the hand instead of the arm, in a separate process",
    )
    parser.add_argument(
        "--simulated",
        action="store_true",
        help=(
            "drive the simulated arm of `remosplat hardware-sim`, which "
            "aborts a motion like a real arm"
        ),
    )
    parser.add_argument(
        "--status-only",
        action="store_true",
        help=(
            "publish the arm's statuses, in any mode of the arm, and send no "
            "commands to the arm"
        ),
    )
    parser.add_argument(
        "--joint-torque-limit",
        type=positive,
        metavar="N_M",
        help=(
            "smallest external torque on a joint that counts as a collision "
            "(default: 20 N m at joint 1 to 12 N m at joint 7, as in "
            "libfranka's example). It replaces the settings in Franka's web "
            "interface Desk"
        ),
    )
    parser.add_argument(
        "--cartesian-force-limit",
        type=positive,
        metavar="N",
        help=(
            "smallest external force [N] and torque [N m] on the hand that "
            "count as a collision (default: 20 N and 25 N m)"
        ),
    )


def run(arguments: argparse.Namespace) -> int:
    """Drives the arm or the hand until Ctrl-C."""
    drive = _drive_hand if arguments.hand else _drive_arm
    if arguments.status_only:
        drive = _watch_arm
    # The priority is set before any thread starts. The arm's callback runs in a
    # separate process with a higher priority.
    with realtime_priority(DRIVER_PRIORITY - 1):
        drive(open_wire(arguments.lcm_url), arguments)
    return 0


def _drive_arm(lcm: DrakeLcm, arguments: argparse.Namespace) -> None:
    library = _library(arguments)
    arm = CallbackProcess(library, arguments.host, _limits(arguments))
    inbox = leased_inbox(
        lcm,
        [COMMAND_RAMP, PANDA_COMMAND],
        "panda-driver",
        open_console(stderr=True),
    )
    driver = PandaDriver(lcm, arm, inbox)
    pacer = Pacer(TICK)
    with garbage_collection_disabled(), stop_signals() as request:
        _announce(arguments)
        problem = ""
        try:
            while not request.made and not problem:
                pacer.wait()
                driver.step(wall_utime())
                problem = arm.problem()
        finally:
            request.has_ended = True
            _release(arm, driver, pacer)
    if problem:
        raise RemoSplatError(f"the arm has stopped: {problem}")


def _release(arm: CallbackProcess, driver: PandaDriver, pacer: Pacer) -> None:
    """Brings the arm to rest and gives up control."""
    while not arm.problem() and not driver.brake():
        pacer.wait()
    arm.close()


def _watch_arm(lcm: DrakeLcm, arguments: argparse.Namespace) -> None:
    arm = FrankaArm(_library(arguments), arguments.host)
    with stop_signals() as request:
        _announce(arguments)
        while not request.made:
            record = arm_record(arm.state(), AT_REST, wall_utime())
            lcm.Publish(PANDA_STATUS, panda_status(record).encode())


def _library(arguments: argparse.Namespace) -> str:
    """Waits for the arm's answer, and imports libfranka's interface."""
    if arguments.simulated:
        return fci_library.__name__
    check_reachable(arguments.host)
    return LIBFRANKA


def _limits(arguments: argparse.Namespace) -> CollisionLimits:
    torque, force = (
        arguments.joint_torque_limit,
        arguments.cartesian_force_limit,
    )
    limits = CollisionLimits()
    return CollisionLimits(
        (torque,) * 7 if torque else limits.torque,
        (force,) * 6 if force else limits.force,
    )


def _drive_hand(lcm: DrakeLcm, arguments: argparse.Namespace) -> None:
    inbox = leased_inbox(
        lcm,
        [PANDA_HAND_COMMAND],
        "panda-driver --hand",
        open_console(stderr=True),
    )
    driver = HandDriver(lcm, PandaPythonHand(arguments.host), inbox)
    pacer = Pacer(PERIOD)
    with stop_signals() as request:
        _announce(arguments)
        while not request.made:
            pacer.wait()
            driver.step(wall_utime())


def _announce(arguments: argparse.Namespace) -> None:
    """Prints that the driver controls the robot, and how to end it."""
    open_console(stderr=True).print(
        f"{arguments.lcm_url} <-> {arguments.host}; Ctrl-C ends"
    )
