"""`remosplat replay`: plays a recorded session in the browser."""

import argparse
import dataclasses as dc
import math
from functools import partial
from pathlib import Path

import numpy as np
from rich.console import Console
from rich.table import Table

from remosplat_drake.app.recorded_run import RecordedRun, load_recorded_run
from remosplat_drake.base.atomic_file import check_writable
from remosplat_drake.base.progress import Progress
from remosplat_drake.base.tcp_port import check_free
from remosplat_drake.commands.hold import add_page_arguments, hold, open_page
from remosplat_drake.commands.number_flags import positive
from remosplat_drake.commands.tables import open_console
from remosplat_drake.recording.events import REQUEST
from remosplat_drake.recording.operator_figure import (
    check_figure_path,
    draw_operator_figure,
    save_figure,
)
from remosplat_drake.visualization.page import MeshcatPage
from remosplat_drake.visualization.page_state import replayed
from remosplat_drake.visualization.replay import record_replay
from remosplat_drake.visualization.saved_page.account import Account, Moment
from remosplat_drake.visualization.truth_view import TruthView

EXAMPLES = """
remosplat replay sessions/monday
remosplat replay sessions/monday --save-html replay.html --figure figure.png
"""
"""Examples at the end of `--help`."""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declares the command's flags."""
    parser.add_argument(
        "session", type=Path, help="session folder of `remosplat teleop`"
    )
    parser.add_argument(
        "--run",
        dest="number",
        type=int,
        metavar="N",
        help="number of the run (default: the session's last run)",
    )
    parser.add_argument(
        "--from",
        dest="start",
        type=float,
        default=-math.inf,
        metavar="T",
        help="begin the replay at this time after the run's first tick [s]",
    )
    parser.add_argument(
        "--to",
        dest="end",
        type=float,
        default=math.inf,
        metavar="T",
        help="end at this time [s]",
    )
    parser.add_argument(
        "--rate",
        type=positive,
        default=1.0,
        metavar="R",
        help="playback speed of the page (1); a saved page plays in real time",
    )
    parser.add_argument(
        "--save-html",
        type=Path,
        metavar="FILE",
        help="write the page with the replay as one static file",
    )
    parser.add_argument(
        "--figure",
        type=Path,
        metavar="FILE",
        help="plot clearance and deviation over time (.png, .svg or .pdf)",
    )
    add_page_arguments(parser)


def run(arguments: argparse.Namespace) -> int:
    """Replays the run, and writes the requested files."""
    console = open_console(stderr=True)
    if arguments.figure:
        check_figure_path(arguments.figure)
    for path in filter(None, (arguments.save_html, arguments.figure)):
        check_writable(path)
    check_free(arguments.host, arguments.port)
    recorded = load_recorded_run(arguments.session, arguments.number)
    recorded = recorded.between(arguments.start, arguments.end)
    console.print(_summary(recorded))
    if arguments.figure:
        _save_figure(recorded, arguments.figure, console)
    page = open_page(arguments)
    _draw(recorded, page, console)
    account = _account(recorded)
    page.end(account.state)
    page.set_account(dc.replace(account, rate=arguments.rate))
    if arguments.save_html:
        page.save_html(arguments.save_html, account)
    console.print(f"watch at [bold]{page.url}[/bold]")
    hold(arguments.hold, page, console)
    return 0


def _draw(recorded: RecordedRun, page: MeshcatPage, console: Console) -> None:
    maps, problems = recorded.maps()
    for problem in problems:
        console.print(f"[yellow]without a map:[/] {problem}")
    with Progress(console, "drawing") as progress:
        record_replay(
            page,
            recorded.world.robot,
            recorded.log,
            maps,
            reach=recorded.scenario.controller.collision.influence,
            events=recorded.events,
            on_frame=partial(progress.report, "drawing"),
        )
    if recorded.world.truth is not None:
        TruthView(page, recorded.world.truth)


def _account(recorded: RecordedRun) -> Account:
    """Returns the summary of the run, with times since the replay's start."""
    rows = recorded.log.rows
    first, last = float(rows["time"][0]), float(rows["time"][-1])
    collision = recorded.scenario.controller.collision
    return Account(
        state=replayed(f"{recorded.folder.name}, {last - first:.1f} s"),
        time=rows["time"] - first,
        q=rows["q"],
        clearance=rows["clearance"],
        stopping=collision.stopping,
        influence=collision.influence,
        moments=[
            Moment(e.time - first, f"{e.kind}: {e.text}")
            for e in recorded.events
            if first <= e.time <= last and e.kind != REQUEST
        ],
        facts=[
            ("run", recorded.folder.name),
            ("time", f"{first:.2f} to {last:.2f} s, {len(rows)} ticks"),
            ("clearance (oracle)", _smallest(rows)),
        ],
    )


def _save_figure(recorded: RecordedRun, path: Path, console: Console) -> None:
    with Progress(console) as progress:
        total = len(recorded.log)
        trace = recorded.trace(
            lambda done: progress.report("measuring", done, total)
        )
    stopping = recorded.scenario.controller.collision.stopping
    figure = draw_operator_figure(
        trace, stopping=stopping, events=recorded.events
    )
    save_figure(figure, path)
    if trace.true_clearance is not None:
        smallest = 1e3 * trace.true_clearance.min()
        console.print(f"true clearance: at least {smallest:.1f} mm")


def _summary(recorded: RecordedRun) -> Table:
    """Makes a short table of the run and its events."""
    rows = recorded.log.rows
    first, last = float(rows["time"][0]), float(rows["time"][-1])
    table = Table(show_header=False, box=None, pad_edge=False)
    table.add_column(no_wrap=True)
    table.add_column(overflow="fold")
    table.add_row("run", str(recorded.folder))
    table.add_row("time", f"{first:.2f} to {last:.2f} s, {len(rows)} ticks")
    table.add_row("clearance (oracle)", _smallest(rows))
    for event in recorded.events:
        if first <= event.time <= last and event.kind != REQUEST:
            table.add_row(f"{event.time:.2f} s", f"{event.kind}: {event.text}")
    return table


def _smallest(rows: np.ndarray) -> str:
    k = int(rows["clearance"].argmin())
    clearance = float(rows["clearance"][k])
    if not math.isfinite(clearance):
        return "never within the influence distance"
    return f"at least {1e3 * clearance:.1f} mm, at {rows['time'][k]:.2f} s"
