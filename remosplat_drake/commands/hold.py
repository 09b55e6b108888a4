"""Keep a browser page alive after a command has done its work."""

import argparse
import sys
import time

from rich.console import Console

from remosplat_drake.visualization.page import MeshcatPage

_PERIOD = 0.05
"""Period at which the page's buttons are polled [s]."""


def add_page_arguments(parser: argparse.ArgumentParser) -> None:
    """Declares the flags for where and how long a page is served."""
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
    """Whether a page stays; None stands for: if a terminal is attached."""
    return sys.stdin.isatty() if wanted is None else wanted


def hold(wanted: bool | None, page: MeshcatPage, console: Console) -> None:
    """Serves a page and its buttons until Ctrl-C.

    Args:
        wanted: Whether the page stays; None: if a terminal is attached.
        page: Meshcat page to serve.
        console: Console that tells how to end it.
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
