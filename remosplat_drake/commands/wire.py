"""Flags and checks of commands that use LCM."""

import argparse
from collections.abc import Collection

from pydrake.lcm import DrakeLcm
from rich.console import Console

from remosplat_drake.app.hardware_run import prepare_for_hardware
from remosplat_drake.app.scenario import Scenario
from remosplat_drake.base.errors import RemoSplatError
from remosplat_drake.commands.flags import add_doctor_arguments, check_report
from remosplat_drake.commands.tables import open_console
from remosplat_drake.hardware.drivers.leased_inbox import LeasedInbox
from remosplat_drake.hardware.hardware_config import (
    REHEARSAL_URL,
    ROBOT_URL,
    beside,
    check_lcm_url,
    leaves_computer,
)


def add_wire_argument(
    parser: argparse.ArgumentParser, url: str = ROBOT_URL
) -> None:
    """Declares the flag `--lcm-url`.

    Args:
        parser: The command's parser.
        url: The default.
    """
    parser.add_argument(
        "--lcm-url",
        default=url,
        metavar="URL",
        help=(
            "LCM URL of the controller (default: %(default)s; ttl=1 reaches "
            "other computers)"
        ),
    )


def add_robot_arguments(parser: argparse.ArgumentParser) -> None:
    """Declares `--hardware`, `--shadow` and the flags that select the robot."""
    parser.add_argument(
        "--hardware",
        action="store_true",
        help=(
            "drive a real robot, or the simulated one of `remosplat "
            "hardware-sim`, over LCM; it does not move until a person arms it"
        ),
    )
    add_robot_choice(parser)
    parser.add_argument(
        "--shadow",
        action="store_true",
        help=(
            "with --hardware: compute, show and record everything, but send "
            "no commands"
        ),
    )


def add_robot_choice(parser: argparse.ArgumentParser) -> None:
    """Declares `--lcm-url` and `--rehearsal`, which select the robot."""
    parser.add_argument(
        "--lcm-url",
        metavar="URL",
        help="LCM URL of the robot's drivers (default: the scenario's"
        " hardware.lcm_url)",
    )
    parser.add_argument(
        "--rehearsal",
        action="store_true",
        help=(
            "drive the simulated robot of `remosplat hardware-sim`, at "
            f"{REHEARSAL_URL}"
        ),
    )
    add_doctor_arguments(parser)


def prepare_robot(
    arguments: argparse.Namespace, scenario: Scenario, console: Console
) -> None:
    """Prepares a scenario for the robot that the flags select.

    Args:
        arguments: The arguments of `add_robot_arguments`. A command that always
            moves a robot sets `hardware` to True and `shadow` to False.
        scenario: The scenario, which is changed in place.
        console: Console for a warning if messages leave this computer.

    Raises:
        RemoSplatError: The flags contradict each other or select no robot, or
            the scenario is not permitted on a real robot.
    """
    if not arguments.hardware:
        for flag in ("lcm_url", "rehearsal", "shadow"):
            if getattr(arguments, flag):
                name = flag.replace("_", "-")
                raise RemoSplatError(f"--{name}: only with --hardware")
        return
    if arguments.rehearsal and arguments.lcm_url:
        raise RemoSplatError(
            "--rehearsal: it selects the simulated robot; leave out --lcm-url"
        )
    url = REHEARSAL_URL if arguments.rehearsal else arguments.lcm_url
    prepare_for_hardware(scenario, url, shadow=arguments.shadow)
    if url is None and scenario.hardware.url == REHEARSAL_URL:
        raise RemoSplatError(
            "no robot is selected: give --rehearsal for the simulated robot, "
            f"or --lcm-url URL for a real one, for example {ROBOT_URL}"
        )
    check_report(arguments, scenario)
    announce_wire(scenario.hardware.url, console)


def announce_wire(url: str, console: Console) -> None:
    """Prints a warning if messages leave this computer."""
    if leaves_computer(url):
        console.print(
            f"[bold yellow]messages to {url} leave this computer[/]: every "
            "robot that listens there receives them"
        )


def leased_inbox(
    lcm: DrakeLcm,
    channels: Collection[str],
    name: str,
    console: Console,
    *,
    open_channels: Collection[str] = (),
) -> LeasedInbox:
    """Makes the inbox of a driver that obeys one controller at a time.

    Args:
        lcm: The LCM network.
        channels: Channels of commands.
        name: Name of the driver.
        console: Console on which accepted and rejected sessions are printed.
        open_channels: Channels that every program may use.
    """
    return LeasedInbox(
        lcm,
        channels,
        name=name,
        open_channels=open_channels,
        on_news=lambda news: console.print(f"{name} {news}", highlight=False),
    )


def add_camera_wire_argument(parser: argparse.ArgumentParser) -> None:
    """Declares the flag `--camera-url`, in addition to `--lcm-url`."""
    parser.add_argument(
        "--camera-url",
        metavar="URL",
        help=(
            "LCM URL of the images (default: --lcm-url with the next port, "
            "as the scenario's hardware.camera_url)"
        ),
    )


def open_camera_wire(arguments: argparse.Namespace) -> tuple[DrakeLcm, str]:
    """Joins the LCM network of the wrist camera's images.

    Args:
        arguments: The command line with `--lcm-url` and `--camera-url`.

    Returns:
        The LCM network, and its URL.

    Raises:
        RemoSplatError: The URL is unusable.
    """
    url = arguments.camera_url or beside(arguments.lcm_url)
    return open_wire(url, "--camera-url"), url


def open_wire(url: str, flag: str = "--lcm-url") -> DrakeLcm:
    """Joins the LCM network at a URL.

    Args:
        url: The URL.
        flag: Name of the flag that stated the URL, for the error's text.

    Raises:
        RemoSplatError: The URL is unusable.
    """
    check_lcm_url(url)
    announce_wire(url, open_console(stderr=True))
    try:
        return DrakeLcm(url)
    except RuntimeError as error:
        raise RemoSplatError(f"{flag}: {url}: {error}") from error
