"""`remosplat arm-driver`: connects a real arm with the controller by LCM."""

import argparse
import time

from remosplat_drake.app.scenario import load_scenario
from remosplat_drake.app.scenario_robot import robot_file
from remosplat_drake.base.clock import Pacer, wall_utime
from remosplat_drake.base.errors import RemoSplatError
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
from remosplat_drake.hardware.drivers.arm_driver import (
    COMMAND_PERIOD,
    ArmDriver,
    ArmLink,
)
from remosplat_drake.hardware.wire.channels import COMMAND_RAMP, PANDA_COMMAND
from remosplat_drake.robot.robot_description import load_robot_description

_PATIENCE = 3.0
"""Before the driver ends, it waits at most this long until the arm is at rest
[s]."""

_AFTERWARDS = 0.2
"""If the arm has stopped by itself, the driver sends the arm's mode for this
time before it ends [s]."""

EXAMPLES = """
remosplat arm-driver my_arm.yaml
remosplat arm-driver my_arm.yaml --lcm-url 'udpm://239.255.76.67:7667?ttl=1'
"""
"""Examples at the end of `--help`."""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declares the command's flags."""
    add_driver_arguments(parser, "arm")


def run(arguments: argparse.Namespace) -> int:
    """Drives the arm until Ctrl-C, or until the arm stops by itself."""
    scenario = load_scenario(arguments.scenario, arguments.scenario_text)
    config = scenario.hardware
    if config.arm_driver is None:
        raise no_driver(scenario, "arm")
    description = load_robot_description(robot_file(scenario))
    lcm, url = open_driver_wire(arguments, config)
    console = open_console(stderr=True)
    link = config.arm_driver.connect_arm(
        description,
        teller(console, "arm"),
    )
    inbox = leased_inbox(
        lcm, [COMMAND_RAMP, PANDA_COMMAND], "arm-driver", console
    )
    driver = ArmDriver(lcm, link, len(description.arm.joints), inbox)
    pacer = Pacer(min(COMMAND_PERIOD, config.arm_status_period))
    problem = ""
    with realtime_priority(DRIVER_PRIORITY), stop_signals() as request:
        announce(console, url, config.arm_driver)
        try:
            while not request.made and not problem:
                pacer.wait()
                report = driver.step(wall_utime(), time.monotonic())
                problem = report.problem if report else ""
        finally:
            request.has_ended = True
            _leave(driver, link, pacer, bool(problem))
    if problem:
        raise RemoSplatError(f"the arm has stopped: {problem}")
    return 0


def _leave(
    driver: ArmDriver, link: ArmLink, pacer: Pacer, has_stopped: bool
) -> None:
    """Brings the arm to rest, or sends the reason for its stop for a moment."""
    try:
        end = time.monotonic() + (_AFTERWARDS if has_stopped else _PATIENCE)
        while time.monotonic() < end:
            if driver.brake(wall_utime()) and not has_stopped:
                break
            pacer.wait()
    finally:
        link.close()
