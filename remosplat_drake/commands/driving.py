"""Runs an application's diagram to its end, and prints its progress."""

import math
import time

from rich.console import Console
from rich.live import Live
from rich.text import Text

from remosplat_drake.app.arming import HINT
from remosplat_drake.app.diagram import Application
from remosplat_drake.app.hardware_run import run_on_hardware
from remosplat_drake.app.run_result import RunResult
from remosplat_drake.app.simulation import run as simulate
from remosplat_drake.base.real_time import LoopQuality
from remosplat_drake.hardware.client.hardware_station import HardwareStation
from remosplat_drake.signals import motion_status as states
from remosplat_drake.signals.map_status import MapStatus
from remosplat_drake.signals.motion_status import MotionStatus
from remosplat_drake.signals.supervisor_state import STOPPED, SupervisorState
from remosplat_drake.signals.tick_report import TickReport
from remosplat_drake.visualization.page import MeshcatPage

INCOMPLETE = 2
"""Exit code if the run succeeded, but one of its files is incomplete."""

_FRAME = 0.1
"""Period at which the progress line is updated [s]."""

LONGEST_REPLAY = 600.0
"""Of a real robot's run, the page records at most this time for replay [s]. The
time is limited, since a minute of the recording takes 6 MB and a run may last
for hours."""

_COLOURS = {
    states.WAITING: "cyan",
    states.MOVING: "green",
    states.HELD: "bold yellow",
    states.REACHED: "bold green",
    states.STOPPING: "bold red",
    states.STOPPED: "bold red",
    states.ENDED: "bold red",
}
"""Colour of the text on the robot's state, for each kind of state."""


def drive(
    application: Application,
    console: Console,
    *,
    rate: float | None,
    patience: float,
    page: MeshcatPage | None = None,
) -> tuple[RunResult, LoopQuality | None]:
    """Runs a diagram with a progress line; prints the reason for each stop.

    Args:
        application: The diagram to run.
        console: Console that shows the progress.
        rate: Real-time rate of a simulation, as in `simulation.run`; None if a
            real robot moves.
        patience: Time for which a stopped robot waits until a person releases
            it [s]; then the run ends.
        page: The page, which records the motion for replay. It records at most
            `LONGEST_REPLAY` of a real robot's run. None for no page.

    Returns:
        The result of the run, and the timing of a real robot's loop (None in a
        simulation).
    """
    last = -math.inf
    log, has_told = application.log, False
    with Live(console=console, auto_refresh=False, transient=True) as live:

        def show(t: float, status: MotionStatus, report: TickReport | None):
            nonlocal last, has_told
            now = time.monotonic()
            if now - last < _FRAME or report is None:
                return
            last = now
            if page is not None and rate is None and t > LONGEST_REPLAY:
                page.pause_recording()
            live.update(progress_line(t, status, report), refresh=True)
            if log is not None and log.trouble and not has_told:
                has_told = True
                print_error(log.trouble, console)

        def tell(supervision: SupervisorState):
            if supervision.refusal:
                console.print(f"[bold red]{supervision.refusal}[/]")
            elif supervision.mode == STOPPED:
                console.print(f"[bold red]stopped:[/] {supervision.reason}")
                if rate is None:
                    console.print(HINT)
                elif patience > 0:
                    console.print("press Release on the page to continue")

        def explain(t: float, status: MotionStatus):
            if status.kind == states.HELD:
                # Output to a pipe has no width, so its lines are not broken.
                line = Text(f"{t:.2f} s  ", "dim")
                line.append(status.text, _COLOURS[status.kind])
                console.print(line, soft_wrap=not console.is_terminal)

        def tell_of_map(status: MapStatus):
            line = Text().append("map: ", "dim")
            line.append(status.news, "yellow" if status.trouble else "")
            console.print(line, soft_wrap=not console.is_terminal)

        watchers = {
            "on_progress": show,
            "on_supervision": tell,
            "on_motion_status": explain,
            "on_map": tell_of_map,
        }
        if rate is None:
            done = run_on_hardware(application, patience=patience, **watchers)
            console.print(strangers(application), highlight=False, end="")
            return done.run, done.loop
        done = simulate(
            application, realtime_rate=rate, patience=patience, **watchers
        )
        return done, None


def log_is_whole(application: Application, console: Console) -> bool:
    """Prints which files of a run are incomplete.

    Args:
        application: The diagram that ran; its log is closed.
        console: Console for the line.

    Returns:
        True if all files are complete.
    """
    parts = application.recorder.ticks, application.log
    troubles = [part.trouble for part in parts if part and part.trouble]
    for trouble in troubles:
        print_error(trouble, console)
    return not troubles


def print_error(trouble: str, console: Console) -> None:
    """Prints a message about an incomplete file in one line."""
    console.print(Text(trouble, "bold red"), soft_wrap=True)


def strangers(application: Application) -> str:
    """Returns a line on other programs that send to the robot; "" if none."""
    assert isinstance(application.station, HardwareStation)
    guard = application.station.link.guard
    said = guard.summary() if guard else ""
    return f"other senders: {said}\n" if said else ""


def progress_line(t: float, status: MotionStatus, report: TickReport) -> Text:
    """Formats the robot's state, and the latest tick's clearance and duration.

    Args:
        t: Time since the start of the run [s].
        status: The robot's state.
        report: The controller's report of the latest tick.
    """
    total = report.timings.get("total", math.nan)
    line = Text(f"{t:5.2f} s  ")
    line.append(status.text, _COLOURS[status.kind])
    line.append(f"\nclearance {1e3 * report.clearances.minimum():.1f} mm   ")
    line.append(f"tick {1e3 * total:.2f} ms ({1.0 / total:.0f} Hz)   ")
    line.append(report.status, "green" if not report.reason else "yellow")
    if report.reason:
        line.append(f": {report.reason}")
    return line
