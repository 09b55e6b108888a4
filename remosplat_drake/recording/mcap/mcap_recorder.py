"""`McapRecorder`: sends ticks to the recording process without waiting."""

import contextlib
import pickle
import select
import socket
from collections import deque
from pathlib import Path

from remosplat_drake.base.child_process import ChildProcess
from remosplat_drake.base.errors import RemoSplatError
from remosplat_drake.hardware.hardware_config import HardwareConfig
from remosplat_drake.recording.mcap.mcap_file import partial_path
from remosplat_drake.recording.mcap.recording_process import (
    RecordingJob,
    serve,
)
from remosplat_drake.recording.mcap.tick_record import TickRecord
from remosplat_drake.robot.robot_model import RobotModel

LIMIT = 4 << 30
"""Size of a file above which no messages are added [bytes]."""

WAITING = 1000
"""At most this many ticks are queued; further ticks are dropped."""

_NICENESS = 10
_BUFFER = 1 << 22
_START, _END = 120.0, 120.0
"""Two numbers: the recorder waits at most this time until the process has begun
its file, and until it has finished the file [s]."""


class McapRecorder:
    """Sends ticks to a process that writes an MCAP file.

    Ticks wait in a queue until the process accepts them. If the queue is full,
    a tick is dropped and counted. In a simulation, which has no deadlines,
    `append` waits instead. If an error occurs, the recording ends, and the
    robot continues. Then `trouble` states the error, and the file remains at
    its `partial_path`.

    Attributes:
        left_out: Number of dropped ticks.
    """

    def __init__(
        self,
        path: Path,
        robot: RobotModel,
        *,
        camera: HardwareConfig | None = None,
        may_wait: bool = False,
        limit: int = LIMIT,
        live: int | None = None,
        rviz: bool = False,
    ):
        """Starts the process, and waits until it has created the file.

        Args:
            path: The file; it must not exist.
            robot: The robot that is recorded.
            camera: Source of the wrist camera's images; None if there is none.
            may_wait: Whether `append` waits instead of dropping a tick.
            limit: Size of the file above which no messages are added [bytes].
            live: TCP port of the live server for Foxglove; None for none.
            rviz: Whether targets and clearances are published on ROS 2 for
                RViz.

        Raises:
            RemoSplatError: The file cannot be created.
        """
        self._path = path
        self._may_wait = may_wait
        self._waiting: deque[bytes] = deque()
        self.left_out = 0
        self._trouble = ""
        self._socket, theirs = socket.socketpair(
            socket.AF_UNIX, socket.SOCK_SEQPACKET
        )
        self._socket.setsockopt(socket.SOL_SOCKET, socket.SO_SNDBUF, _BUFFER)
        self._socket.setblocking(False)
        self._child = ChildProcess(serve, "recording", _NICENESS)
        job = RecordingJob(path.absolute(), limit, robot, camera, live, rviz)
        self._child.start(theirs, job)
        self._child.wait_until_started()
        theirs.close()
        self._child.wait(_START)
        problem = "the recording process does not start"
        if self._child.has_news():
            try:
                problem = self._news()
            except EOFError:
                problem = "the recording process has crashed"
        if problem:
            self.close()
            raise RemoSplatError(f"--record: {problem}")

    @property
    def trouble(self) -> str:
        """Sentence about what the file lacks; empty if it is complete."""
        with contextlib.suppress(EOFError, OSError):
            while self._child.connection is not None and self._child.has_news():
                self._trouble = self._news()
        if self._trouble:
            rest = partial_path(self._path)
            return (
                f"the recording has ended: {self._trouble}; {rest} contains"
                " what was written before"
            )
        if self.left_out:
            return (
                f"the recording lacks {self.left_out} ticks, since its process"
                " is too slow"
            )
        return ""

    def _news(self) -> str:
        assert self._child.connection is not None
        return self._child.connection.recv()

    def append(self, record: TickRecord) -> None:
        """Queues a tick.

        Args:
            record: The tick.
        """
        while self._may_wait and len(self._waiting) >= WAITING:
            select.select([], [self._socket], [], _END)
            self._send()
        if len(self._waiting) >= WAITING:
            self.left_out += 1
            self._send()
            return
        self._waiting.append(pickle.dumps((self.left_out, record)))
        self._send()

    def _send(self) -> None:
        """Sends queued ticks, until the process accepts no further ticks."""
        try:
            while self._waiting:
                self._socket.send(self._waiting[0])
                self._waiting.popleft()
        except BlockingIOError:
            return
        except OSError as error:
            # The process has died; the robot continues.
            self._waiting.clear()
            self._trouble = self._trouble or error.strerror or str(error)

    def close(self) -> None:
        """Sends queued ticks, and waits until the file is complete."""
        self._socket.settimeout(_END)
        with contextlib.suppress(OSError):
            self._send()
        self._socket.close()
        with contextlib.suppress(EOFError, OSError):  # The process has ended.
            while self._child.connection is not None:
                self._child.wait(_END)
                if not self._child.has_news():
                    break
                self._trouble = self._news()
        self._child.end()
        if not self._path.exists():
            self._trouble = self._trouble or "the file is incomplete"
