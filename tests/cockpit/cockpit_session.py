"""A session of the program that people start, and a client that operates it."""

import signal
import subprocess
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path

from browser import open_browser
from cockpit_tab import DRAW_NOTHING, CockpitTab
from patience import PATIENCE
from runs import command_line


@contextmanager
def open_session(
    scenario: str,
    session: Path,
    *flags: str,
    size: tuple[int, int] = (900, 900),
    script: str = "",
) -> Iterator[CockpitTab]:
    """Starts `teleop`, operates it in a tab that draws no scene, and ends both.

    Args:
        scenario: The scenario's name.
        session: The session's folder.
        flags: Further flags of the command.
        size: Size of the window [px].
        script: Runs in the page before its own ones.
    """
    command = command_line("teleop", scenario, "--session", session, *flags)
    with subprocess.Popen(
        command, stderr=subprocess.PIPE, text=True
    ) as process:
        try:
            url, code = address(process)
            with open_browser(size) as tab:
                tab.run_first(DRAW_NOTHING + script)
                operator = CockpitTab(tab, url)
                operator.operate(code)
                yield operator
                assert operator.errors == []
            process.send_signal(signal.SIGINT)
            process.wait(PATIENCE)
        finally:
            process.kill()


def insist(operator: CockpitTab, ask: Callable[[], None], result: str):
    """Asks for something; releases a stopped robot, and asks again.

    What is asked of a robot that is stopped is void, and on a busy computer
    the cockpit may fall silent, which stops it.
    """
    end = time.monotonic() + PATIENCE
    asks = True
    while result not in operator.text:
        assert time.monotonic() < end, f"no {result!r} in {operator.text}"
        # The page hides both buttons again if the time to confirm is over, or
        # if an earlier release has had its effect.
        if operator.press_any("Let the robot go", "RELEASE"):
            asks = True
        elif asks:
            ask()
            asks = False
        time.sleep(0.1)


def address(process: subprocess.Popen[str]) -> tuple[str, str]:
    """Address of the page, and the code that makes a client the operator."""
    assert process.stderr is not None
    url = code = ""
    for line in process.stderr:
        if line.startswith("operate at"):
            url = line.split()[2].rstrip(";")
        if "type the code" in line:
            code = line.split("type the code")[1].split()[0]
        if url and code:
            return url, code
    raise AssertionError("the process has gone")
