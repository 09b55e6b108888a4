"""`remosplat base-driver`: connects a mobile base with the controller."""

import argparse
import contextlib
import time
from collections.abc import Iterator
from pathlib import Path

from remosplat_drake.app.scenario import load_scenario
from remosplat_drake.app.scenario_robot import robot_file
from remosplat_drake.base.clock import Pacer, wall_utime
from remosplat_drake.base.errors import FieldError, FileError
from remosplat_drake.base.real_time import (
    DRIVER_PRIORITY,
    realtime_priority,
)
from remosplat_drake.base.stop_signals import stop_signals
from remosplat_drake.commands.driver_flags import (
    add_driver_arguments,
    announce,
    no_driver,
    open_driver_wire,
    teller,
)
from remosplat_drake.commands.tables import open_console
from remosplat_drake.commands.wire import leased_inbox
from remosplat_drake.hardware.drivers.arcl_monitor import (
    ArclMonitor,
    split_address,
)
from remosplat_drake.hardware.drivers.base_commands import BaseMaxima
from remosplat_drake.hardware.drivers.base_driver import (
    PERIOD,
    BaseDriver,
    BaseLink,
)
from remosplat_drake.hardware.ros_config import Tell
from remosplat_drake.hardware.wire.channels import BASE_COMMAND, COMMAND_RAMP
from remosplat_drake.robot.robot_description import (
    OMNIDIRECTIONAL,
    load_robot_description,
)

_LAST_ZEROS = 10

EXAMPLES = """
remosplat base-driver my_base.yaml
remosplat base-driver my_base.yaml --arcl 10.0.0.5 --arcl-password-file pw
"""
"""Examples at the end of `--help`."""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declares the command's flags."""
    add_driver_arguments(parser, "base")
    parser.add_argument(
        "--arcl",
        metavar="HOST[:PORT]",
        help=(
            "address of an Omron base; the driver then also queries the base "
            "over ARCL (Omron's text protocol) for permission to move"
        ),
    )
    parser.add_argument(
        "--arcl-password-file",
        type=Path,
        metavar="FILE",
        help="file that contains the password for ARCL",
    )


def run(arguments: argparse.Namespace) -> int:
    """Drives the base until Ctrl-C, and then stops it."""
    scenario = load_scenario(arguments.scenario, arguments.scenario_text)
    config = scenario.hardware
    if config.base_driver is None:
        raise no_driver(scenario, "base")
    description = load_robot_description(robot_file(scenario))
    if description.base is None:
        problem = f"{description.name} has no base"
        raise FieldError(scenario.source, "robot.model", problem)
    is_omni = description.base.drive == OMNIDIRECTIONAL
    maxima = BaseMaxima(
        config.base_forward_upper,
        -config.base_forward_lower,
        config.base_sideways if is_omni else 0.0,
        config.base_yaw_rate,
    )
    lcm, url = open_driver_wire(arguments, config)
    console = open_console(stderr=True)
    tell = teller(console, "base")
    link = config.base_driver.connect_base(tell)
    inbox = leased_inbox(
        lcm, [COMMAND_RAMP, BASE_COMMAND], "base-driver", console
    )
    pacer = Pacer(PERIOD)
    with (
        realtime_priority(DRIVER_PRIORITY),
        stop_signals() as request,
        _arcl(arguments, tell) as sources,
    ):
        driver = BaseDriver(lcm, link, maxima, sources, inbox, tell)
        announce(console, url, config.base_driver)
        try:
            while not request.made:
                pacer.wait()
                driver.step(wall_utime(), time.monotonic())
        finally:
            request.has_ended = True
            _leave(driver, link, pacer)
    return 0


def _leave(driver: BaseDriver, link: BaseLink, pacer: Pacer) -> None:
    """Stops the base with several messages, since a message may be lost."""
    try:
        for _ in range(_LAST_ZEROS):
            driver.stop()
            pacer.wait()
    finally:
        link.close()


@contextlib.contextmanager
def _arcl(
    arguments: argparse.Namespace, tell: Tell
) -> Iterator[list[ArclMonitor]]:
    """Queries the base over ARCL in the `with` block if `--arcl` is given."""
    if arguments.arcl is None:
        yield []
        return
    host, port = split_address(arguments.arcl)
    monitor = ArclMonitor(host, port, _password(arguments), tell)
    try:
        yield [monitor]
    finally:
        monitor.close()


def _password(arguments: argparse.Namespace) -> str:
    """Reads the password for ARCL; a file hides it from other users."""
    path = arguments.arcl_password_file
    if path is None:
        raise FieldError("--arcl", arguments.arcl, "needs --arcl-password-file")
    try:
        return path.read_text().strip()
    except (OSError, UnicodeDecodeError) as error:
        raise FileError(path, f"cannot be read: {error}") from error
