"""What the command lines of drivers have in common."""

import argparse
import math

from pydrake.lcm import DrakeLcm

from remosplat_drake.base.errors import RemoSplatError
from remosplat_drake.hardware.hardware_config import beside, check_lcm_url

LOCAL_URL = "udpm://239.255.76.67:7667?ttl=0"
"""LCM's default address, within one computer."""


def add_wire_argument(parser: argparse.ArgumentParser) -> None:
    """Declares the flag `--lcm-url`."""
    parser.add_argument(
        "--lcm-url",
        default=LOCAL_URL,
        metavar="URL",
        help="the station's wire (default: %(default)s; ttl=1 reaches"
        " other computers)",
    )


def add_camera_wire_argument(parser: argparse.ArgumentParser) -> None:
    """Declares the flag `--camera-url` beside `--lcm-url`."""
    parser.add_argument(
        "--camera-url",
        metavar="URL",
        help="the wire of the images (default: that of --lcm-url with the"
        " next port, as the scenario's hardware.camera_url)",
    )


def open_camera_wire(arguments: argparse.Namespace) -> tuple[DrakeLcm, str]:
    """Joins the LCM wire of the wrist camera.

    Args:
        arguments: The command line with `--lcm-url` and `--camera-url`.

    Returns:
        The wire, and its URL.

    Raises:
        RemoSplatError: The URL is unusable.
    """
    url = arguments.camera_url or beside(arguments.lcm_url)
    return open_wire(url, "--camera-url"), url


def positive_rate(text: str) -> float:
    """Parses a positive, finite rate from the command line.

    Raises:
        ArgumentTypeError: The text is no positive, finite number.
    """
    rate = float(text)
    if not (math.isfinite(rate) and rate > 0):
        raise argparse.ArgumentTypeError(f"{text} is not a rate > 0")
    return rate


def open_wire(url: str, flag: str = "--lcm-url") -> DrakeLcm:
    """Joins the LCM wire at a URL.

    Args:
        url: The URL.
        flag: Name of the flag that gave it, for the error's text.

    Raises:
        RemoSplatError: The URL is unusable.
    """
    check_lcm_url(url)
    try:
        return DrakeLcm(url)
    except RuntimeError as error:
        raise RemoSplatError(f"{flag}: {url}: {error}") from error
