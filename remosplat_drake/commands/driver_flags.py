"""Flags that the drivers of arm, base and hand have in common."""

import argparse

from pydrake.lcm import DrakeLcm

from remosplat_drake.commands.wire import open_wire
from remosplat_drake.hardware.hardware_config import HardwareConfig


def add_driver_arguments(parser: argparse.ArgumentParser, part: str) -> None:
    """Declares the flags for the driven robot and its wire.

    Args:
        parser: The command's parser.
        part: The driven part: `arm`, `base` or `hand`.
    """
    parser.add_argument(
        "scenario",
        help="NAME, FILE or FILE:NAME (see `remosplat scenarios`): its"
        f" hardware.{part}_driver defines the connection to the {part}",
    )
    parser.add_argument(
        "--scenario-text",
        default="",
        metavar="YAML",
        help="fields of the scenario to override, as for `remosplat run`",
    )
    parser.add_argument(
        "--lcm-url",
        metavar="URL",
        help="the station's wire (default: the scenario's hardware.lcm_url;"
        " ttl=1 reaches other computers)",
    )


def open_driver_wire(
    arguments: argparse.Namespace, config: HardwareConfig
) -> tuple[DrakeLcm, str]:
    """Joins the wire that the command line or the scenario names.

    Returns:
        The wire, and its URL.

    Raises:
        RemoSplatError: The URL is unusable.
    """
    url = arguments.lcm_url or config.url
    return open_wire(url), url


def driver_name(config: object) -> str:
    """Returns a driver's tag in scenario files, without its settings."""
    return f"!{type(config).__name__}"
