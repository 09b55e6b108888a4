"""What the command lines of drivers have in common."""

import argparse
import math

from pydrake.lcm import DrakeLcm

from remosplat_drake.base.errors import RemoSplatError
from remosplat_drake.hardware.hardware_config import check_lcm_url

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


def positive_rate(text: str) -> float:
    """Parses a positive, finite rate from the command line.

    Raises:
        ArgumentTypeError: The text is no positive, finite number.
    """
    rate = float(text)
    if not (math.isfinite(rate) and rate > 0):
        raise argparse.ArgumentTypeError(f"{text} is not a rate > 0")
    return rate


def open_wire(url: str) -> DrakeLcm:
    """Joins the LCM wire at a URL.

    Raises:
        RemoSplatError: The URL is unusable.
    """
    check_lcm_url(url)
    try:
        return DrakeLcm(url)
    except RuntimeError as error:
        raise RemoSplatError(f"--lcm-url: {url}: {error}") from error
