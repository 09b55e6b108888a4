"""The process that writes an MCAP file; its function is `serve`."""

import contextlib
import dataclasses as dc
import pickle
import select
import socket
import time
from multiprocessing.connection import Connection
from pathlib import Path

from remosplat_drake.base.errors import RemoSplatError
from remosplat_drake.hardware.hardware_config import HardwareConfig
from remosplat_drake.hardware.wire.channels import WRIST_CAMERA
from remosplat_drake.hardware.wire.images import decode_images
from remosplat_drake.hardware.wire.inbox import Inbox
from remosplat_drake.hardware.wire.packets import BrokenMessage
from remosplat_drake.recording.events import TROUBLE, Event
from remosplat_drake.recording.mcap.live_server import LiveServer
from remosplat_drake.recording.mcap.mcap_file import McapFile
from remosplat_drake.recording.mcap.messages import (
    Message,
    image_messages,
    log,
    stamp,
    tick_messages,
    transforms,
)
from remosplat_drake.recording.mcap.ros2_view import Ros2View
from remosplat_drake.recording.mcap.tick_record import TickRecord
from remosplat_drake.robot.robot_model import RobotModel

LARGEST = 1 << 20
"""A packet with a tick has at most this size [bytes]."""

_ROUND = 0.02
"""Time between two polls of the camera's channel [s]."""

_TRANSFORMS, _IMAGES = 1 / 30, 1 / 5
"""Two numbers: the least time between two transforms in a file, and the least
time between two images [s]."""


@dc.dataclass(frozen=True)
class RecordingJob:
    """The settings of the process: its file, and the file's content.

    Attributes:
        path: The file.
        limit: Size of the file above which no messages are added [bytes].
        robot: The robot.
        camera: Source of the wrist camera's images; None if there is none.
        live: TCP port of the live server for Foxglove; None for none.
        rviz: Whether targets and clearances are published on ROS 2 for RViz.
    """

    path: Path
    limit: int
    robot: RobotModel
    camera: HardwareConfig | None = None
    live: int | None = None
    rviz: bool = False


def serve(
    connection: Connection, ticks: socket.socket, job: RecordingJob
) -> None:
    """Writes ticks and images until the other end of `ticks` is closed.

    Args:
        connection: Connection to the parent process. The process first sends an
            empty text when it has created the file, or the reason why it
            cannot. After that it sends a description of each new problem.
        ticks: Packets with pickled pairs: the number of ticks dropped so far,
            and a `TickRecord`. An empty packet marks the end.
        job: The content to write.
    """
    server, view = None, None
    try:
        # The server is started first, so that no file is created if its port is
        # taken.
        server = None if job.live is None else LiveServer(job.live)
        view = Ros2View() if job.rviz else None
        file = McapFile(job.path, job.limit)
    except RemoSplatError as error:
        connection.send(str(error))
        return
    connection.send("")
    recording = _Recording(job, file, server, view)
    told = ""
    try:
        while recording.round(ticks):
            if file.trouble != told:
                told = file.trouble
                connection.send(told)
    except (BrokenPipeError, ConnectionResetError):
        pass  # The parent has died; its ticks are in the file.
    except Exception as error:
        file.trouble = str(error)
        raise
    finally:
        file.close()
        if server is not None:
            server.close()
        if file.trouble != told:
            with contextlib.suppress(OSError):
                connection.send(file.trouble)


class _Recording:
    """Writes received data to the file, and publishes them to live viewers."""

    def __init__(
        self,
        job: RecordingJob,
        file: McapFile,
        server: LiveServer | None,
        view: Ros2View | None,
    ):
        self._job, self._file = job, file
        self._server, self._view = server, view
        self._left_out = 0
        self._complaint = ""
        self._transformed = self._pictured = float("-inf")
        self._inbox = None
        if job.camera is not None:
            names = [job.camera.channels.wrist_camera]
            self._inbox = Inbox(job.camera.open_camera_lcm(), names)

    def round(self, ticks: socket.socket) -> bool:
        """Writes received data; returns whether further data may follow."""
        if self._inbox is not None:
            for _, packet in self._inbox.fetch():
                self._picture(packet)
        if select.select([ticks], [], [], _ROUND)[0]:
            packet = ticks.recv(LARGEST)
            if not packet:
                return False
            self._tick(*pickle.loads(packet))
        self._file.flush()
        return True

    def _add(self, message: Message) -> None:
        self._file.add(message)
        if self._server is not None:
            self._server.add(message)

    def _tick(self, left_out: int, record: TickRecord) -> None:
        add, robot = self._add, self._job.robot
        for message in tick_messages(record, robot):
            add(message)
        if not 0 <= record.time - self._transformed < _TRANSFORMS:
            self._transformed = record.time
            message = transforms(record, robot)
            if message is not None:
                add(message)
            if self._view is not None:
                self._view.show(record, robot)
        if left_out > self._left_out:
            self._left_out = left_out
            content = {"timestamp": stamp(record.time), "left_out": left_out}
            add(Message("/recorder", "remosplat.Recorder", content))

    def _complain(self, text: str) -> None:
        """Logs an image's error, unless the previous image had the same."""
        if text != self._complaint:
            self._complaint = text
            self._add(log(Event(time.time(), TROUBLE, text)))

    def _picture(self, packet: bytes) -> None:
        try:
            images = decode_images(packet)
        except BrokenMessage as error:
            self._complain(f"{WRIST_CAMERA}: {error}")
            return
        if not 0 <= images.stamp - self._pictured < _IMAGES:
            self._pictured = images.stamp
            for message in image_messages(images):
                self._add(message)
