"""`Company`: starts another process on the LCM network, as a fault.

Such a process takes seconds to start. The fault begins with the first packet
that the process sends on the network, which the sender's address shows.
"""

import contextlib
import math
import subprocess
import time
from pathlib import Path

from remosplat_drake.acceptance import hardware_processes as processes
from remosplat_drake.acceptance.fault_case import FaultCase, Part
from remosplat_drake.acceptance.motion_judge import (
    CREEP,
    TrueRun,
    distance_moved,
)
from remosplat_drake.hardware.wire import channels
from remosplat_drake.hardware.wire.multicast import MulticastListener
from remosplat_drake.robot.robot_model import RobotModel

REFUSED = 2
"""Exit code of a controller that detects another controller on the network."""


class Company:
    """A process that joins the network, and the record of its effects.

    Attributes:
        began: Wall-clock time of the process's first packet [s]; infinite
            before this packet.
        motion: Record of the second robot's true motion.
    """

    def __init__(self, case: FaultCase, url: str, folder: Path):
        """Stores the arguments; no process joins yet.

        Args:
            case: The case, whose part is the process that joins.
            url: LCM URL of robot and controller.
            folder: Folder for the run's files.
        """
        self._case, self._url = case, url
        self.motion = folder / "second_motion.npz"
        self.began = math.inf
        self._process: subprocess.Popen | None = None

    def join(self, stack: contextlib.ExitStack) -> None:
        """Starts the process, and waits until it has joined or ended."""
        listener = MulticastListener(self._url)
        stack.callback(listener.close)
        known = _senders(listener, 0.3)
        starts = {
            Part.SECOND_ROBOT: lambda: processes.robot(
                self._url, "--record", str(self.motion)
            ),
            Part.SECOND_CONTROLLER: lambda: processes.second_controller(
                self._url
            ),
            Part.STRANGER: lambda: processes.stranger(
                self._url, self._case.fault
            ),
        }
        self._process = stack.enter_context(starts[self._case.part]())
        end = time.monotonic() + processes.START_UP
        while self._process.poll() is None and time.monotonic() < end:
            if self._case.part is not Part.SECOND_CONTROLLER and (
                _senders(listener, 0.005) - known
            ):
                self.began = time.time()
                return

    def leave(self) -> None:
        """Ends the process."""
        if self._process is not None:
            processes.end(self._process)

    def problem(self, robot: RobotModel) -> str:
        """Describes a forbidden effect of the process; empty if there is none.

        Args:
            robot: The robot whose motion is judged.
        """
        if self._process is None:
            return ""
        if self._case.part is Part.SECOND_CONTROLLER:
            code = self._process.returncode
            refused = code == REFUSED
            return (
                "" if refused else f"the second controller exited with {code}"
            )
        if math.isinf(self.began):
            return "no process joined"
        if self._case.part is Part.SECOND_ROBOT:
            moved = distance_moved(TrueRun.read(self.motion), robot)
            if not moved < CREEP:
                return f"the second robot moved by {1e3 * moved:.1f} mm"
        return ""


def _senders(listener: MulticastListener, duration: float) -> set[str]:
    """Returns the addresses that send commands or statuses at present."""
    end, heard = time.monotonic() + duration, set()
    names = {
        channels.PANDA_COMMAND,
        channels.PANDA_STATUS,
        channels.BASE_STATUS,
    }
    while True:
        heard |= {p.sender for p in listener.fetch() if p.channel in names}
        if time.monotonic() >= end:
            return heard
        time.sleep(1e-3)
