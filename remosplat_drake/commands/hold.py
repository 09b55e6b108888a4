"""Serves a browser page, and keeps it open before and after a run."""

import argparse
import sys
import time

from rich.console import Console

from remosplat_drake.base.errors import RemoSplatError
from remosplat_drake.base.terminal import TerminalLines
from remosplat_drake.commands.number_flags import port_number
from remosplat_drake.visualization.page import MeshcatPage
from remosplat_drake.visualization.page_state import START, waiting

LOCALHOST = "localhost"
"""Network interface that other computers cannot reach."""

_PERIOD = 0.05
"""Time between two checks of the page's buttons [s]."""


def add_page_arguments(parser: argparse.ArgumentParser) -> None:
    """Declares the flags for a page's address and for how long it is open."""
    parser.add_argument(
        "--port",
        type=port_number,
        help="port of the page (default: first free)",
    )
    parser.add_argument(
        "--host",
        default=LOCALHOST,
        metavar="ADDRESS",
        help=(
            "network interface on which the page is served; 0.0.0.0 for all "
            "(default: one that only this computer can reach)"
        ),
    )
    parser.add_argument(
        "--hold",
        action=argparse.BooleanOptionalAction,
        default=None,
        help="keep the page open after the run (default: if started in a "
        "terminal)",
    )


def open_page(arguments: argparse.Namespace) -> MeshcatPage:
    """Opens the page that the flags describe.

    Args:
        arguments: The command line with `add_page_arguments`.

    Raises:
        RemoSplatError: The port is taken, or other computers could reach the
            page of a real robot.
    """
    host = arguments.host
    if host != LOCALHOST and getattr(arguments, "hardware", False):
        raise RemoSplatError(
            "--host: with --hardware, only this computer may open the page, "
            "since it cannot identify its visitors; leave out --host"
        )
    # Meshcat's default.
    host = "*" if host == "0.0.0.0" else host
    return MeshcatPage(port=arguments.port, host=host)


def is_held(wanted: bool | None) -> bool:
    """Returns whether a page stays open.

    Args:
        wanted: Whether it shall stay open. If None, it stays open if there is a
            terminal.
    """
    return sys.stdin.isatty() if wanted is None else wanted


def add_viewer_argument(parser: argparse.ArgumentParser) -> None:
    """Declares the flag `--wait-for-viewer`."""
    parser.add_argument(
        "--wait-for-viewer",
        action=argparse.BooleanOptionalAction,
        default=None,
        help="begin only when a person presses Start on the page (default: if "
        "started in a terminal)",
    )


def is_waited_for(arguments: argparse.Namespace) -> bool:
    """Returns whether a run waits for a viewer of its page before it begins.

    Args:
        arguments: The command line, with `wait_for_viewer`, `headless` and
            `hardware`.

    Raises:
        RemoSplatError: `--wait-for-viewer` is given with `--headless` or
            `--hardware`.
    """
    wanted = arguments.wait_for_viewer
    if wanted and arguments.headless:
        raise RemoSplatError(
            "--wait-for-viewer: a run with --headless has no page; leave one "
            "of the two out"
        )
    if wanted and arguments.hardware:
        raise RemoSplatError(
            "--wait-for-viewer: a real robot waits in any case until a person "
            "arms it; leave this flag out"
        )
    if arguments.headless or arguments.hardware:
        return False
    return sys.stdin.isatty() if wanted is None else wanted


def wait_for_start(page: MeshcatPage, goal: str, console: Console) -> None:
    """Waits until a person presses Start on the page, or Enter in the terminal.

    Args:
        page: The page, which shows the goal and the button.
        goal: Purpose of the run, in a sentence.
        console: Console for the instructions.
    """
    before, clicks = page.state, page.clicks(START)
    console.print(goal, soft_wrap=True)
    page.show(waiting(goal))
    lines = TerminalLines()
    here = ", or Enter here" if lines.is_open else ""
    console.print(f"open it and press Start{here}; Ctrl-C ends")
    seen = False
    while page.clicks(START) == clicks and lines.fetch() is None:
        if not seen and page.meshcat.GetNumActiveConnections():
            seen = True
            console.print("a viewer is connected")
        time.sleep(_PERIOD)
    if before is not None:
        page.show(before)


def hold(wanted: bool | None, page: MeshcatPage, console: Console) -> None:
    """Serves a page until Ctrl-C.

    Args:
        wanted: Whether the page stays open. If None, it stays open if there is
            a terminal.
        page: The page.
        console: Console for instructions.
    """
    if not is_held(wanted):
        return
    console.print(f"the page stays at {page.url}; Ctrl-C ends")
    try:
        while True:
            time.sleep(_PERIOD)
    except KeyboardInterrupt:
        pass
