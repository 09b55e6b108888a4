"""Keep a browser page alive after a command has done its work."""

import argparse
import sys
import time

from rich.console import Console

from remosplat_drake.visualization.page import MeshcatPage

_PERIOD = 0.05
"""Time between two looks at the page's buttons [s]."""


def add_page_arguments(parser: argparse.ArgumentParser) -> None:
    """Declares where a command's page is served and for how long."""
    parser.add_argument(
        "--port", type=int, help="port of the page (default: first free)"
    )
    parser.add_argument(
        "--hold",
        action=argparse.BooleanOptionalAction,
        default=None,
        help="keep the page open afterwards (default: in a terminal)",
    )


def is_held(wanted: bool | None) -> bool:
    """Whether a page stays; None: if somebody sits at a terminal."""
    return sys.stdin.isatty() if wanted is None else wanted


def hold(wanted: bool | None, page: MeshcatPage, console: Console) -> None:
    """Serves a page and its buttons until Ctrl-C.

    Args:
        wanted: See `is_held`.
        page: To be kept.
        console: To say so.
    """
    if not is_held(wanted):
        return
    console.print(f"the page stays at {page.url}; Ctrl-C ends")
    try:
        while True:
            page.poll()
            time.sleep(_PERIOD)
    except KeyboardInterrupt:
        pass
