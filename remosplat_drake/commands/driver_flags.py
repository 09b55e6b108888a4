"""Flags that the commands of arm, base and hand drivers share."""

import argparse

from pydrake.lcm import DrakeLcm
from rich.console import Console

from remosplat_drake.app.scenario import Scenario
from remosplat_drake.base.errors import FieldError
from remosplat_drake.commands.wire import open_wire
from remosplat_drake.hardware.hardware_config import HardwareConfig
from remosplat_drake.hardware.ros_config import Tell


def add_driver_arguments(parser: argparse.ArgumentParser, part: str) -> None:
    """Declares the flags for the robot's scenario and its LCM URL.

    Args:
        parser: The command's parser.
        part: The driven part: `arm`, `base` or `hand`.
    """
    parser.add_argument(
        "scenario",
        help=(
            "NAME, FILE or FILE:NAME (see `remosplat scenarios`): scenario "
            f"whose hardware.{part}_driver defines the connection to the "
            f"{part}"
        ),
    )
    parser.add_argument(
        "--scenario-text",
        default="",
        metavar="YAML",
        help=(
            "YAML of fields that override the scenario's, as in `remosplat run`"
        ),
    )
    parser.add_argument(
        "--lcm-url",
        metavar="URL",
        help=(
            "LCM URL of the controller (default: the scenario's "
            "hardware.lcm_url; ttl=1 reaches other computers)"
        ),
    )


def open_driver_wire(
    arguments: argparse.Namespace, config: HardwareConfig
) -> tuple[DrakeLcm, str]:
    """Joins the LCM network that the command line or the scenario names.

    Returns:
        The LCM interface, and its URL.

    Raises:
        RemoSplatError: The URL is unusable.
    """
    url = arguments.lcm_url or config.url
    return open_wire(url), url


def no_driver(scenario: Scenario, part: str) -> FieldError:
    """Makes the error for a scenario without a driver for a part of the robot.

    Args:
        scenario: The scenario.
        part: The part, as in `add_driver_arguments`.
    """
    return FieldError(
        scenario.source,
        f"hardware.{part}_driver",
        f"is absent: name the {part}'s driver, for example"
        f" !Ros2{part.capitalize()} {{}}",
    )


def teller(console: Console, part: str) -> Tell:
    """Returns a function that prints a driver's messages.

    Args:
        console: The console.
        part: The part, as in `add_driver_arguments`.
    """
    return lambda news: console.print(f"{part}-driver: {news}", highlight=False)


def announce(console: Console, url: str, config: object) -> None:
    """Prints the LCM URL, and the kind of the driver.

    Args:
        console: The console.
        url: The LCM URL.
        config: The driver's settings.
    """
    console.print(f"{url} <-> !{type(config).__name__}; Ctrl-C ends")
