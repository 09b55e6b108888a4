"""`remosplat hand-driver`: connects a gripper with the controller by LCM."""

import argparse

from remosplat_drake.app.scenario import load_scenario
from remosplat_drake.app.scenario_robot import robot_file
from remosplat_drake.base.clock import Pacer, wall_utime
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
from remosplat_drake.hardware.drivers.hand_driver import HandDriver
from remosplat_drake.hardware.drivers.hand_messages import PERIOD
from remosplat_drake.hardware.wire.channels import PANDA_HAND_COMMAND
from remosplat_drake.robot.robot_description import load_robot_description

EXAMPLES = """
remosplat hand-driver my_robot.yaml
"""
"""Examples at the end of `--help`."""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declares the command's flags."""
    add_driver_arguments(parser, "hand")


def run(arguments: argparse.Namespace) -> int:
    """Drives the hand until Ctrl-C; the fingers then stay where they are."""
    scenario = load_scenario(arguments.scenario, arguments.scenario_text)
    config = scenario.hardware
    if config.hand_driver is None:
        raise no_driver(scenario, "hand")
    description = load_robot_description(robot_file(scenario))
    lcm, url = open_driver_wire(arguments, config)
    console = open_console(stderr=True)
    link = config.hand_driver.connect_hand(
        description,
        teller(console, "hand"),
    )
    inbox = leased_inbox(lcm, [PANDA_HAND_COMMAND], "hand-driver", console)
    driver = HandDriver(lcm, link, inbox)
    pacer = Pacer(PERIOD)
    with stop_signals() as request:
        announce(console, url, config.hand_driver)
        while not request.made:
            pacer.wait()
            driver.step(wall_utime())
        request.has_ended = True
    return 0
