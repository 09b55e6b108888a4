"""`FciArm`: simulates a Franka arm's controller for a separate driver."""

import contextlib
import socket
from collections.abc import Iterator

import numpy as np

from remosplat_drake.base.errors import RemoSplatError
from remosplat_drake.hardware.drivers.panda_limits import TICK
from remosplat_drake.hardware.stand_in.fci_packets import (
    LARGEST,
    Kind,
    Request,
    State,
)
from remosplat_drake.hardware.stand_in.fci_rules import FciRules
from remosplat_drake.hardware.stand_in.simulated_arm import (
    ArmMeasurement,
    RobotMode,
)


class FciArm:
    """Simulates an arm's controller for one UDP client, in steps of 1 ms.

    Its rules are those of `FciRules`. A command is valid if it answers the
    latest state and arrives before the next step. The calls of `step` advance
    the robot's clock.

    Attributes:
        rules: The rules of the arm's own controller.
        port: UDP port of this computer on which it receives packets.
    """

    def __init__(self, port: int = 0):
        """Opens the port; the arm is idle.

        Args:
            port: UDP port, on this computer only; 0 for any free port.

        Raises:
            RemoSplatError: The port is not available.
        """
        self.rules = FciRules()
        self._socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        try:
            self._socket.bind(("127.0.0.1", port))
        except OSError as error:
            raise RemoSplatError(
                f"UDP port {port}: {error.strerror}"
            ) from error
        self._socket.setblocking(False)
        self.port: int = self._socket.getsockname()[1]
        self._number = 0
        self._client: tuple[str, int] | None = None
        self._moved = False

    def stop(self, mode: RobotMode) -> None:
        """Makes the arm brake and ignore commands, in the given mode."""
        self.rules.abort("", mode)

    def recover(self) -> None:
        """Makes the arm idle, ready for a new motion."""
        self.rules.recover()

    def step(self, measured: ArmMeasurement) -> np.ndarray:
        """Advances the arm by one millisecond.

        Args:
            measured: The present measurements of the arm's sensors.

        Returns:
            Joint rates, shape (7,) [rad/s].
        """
        packet, is_last, readers, begins = self._hear()
        command = self.rules.step(measured, packet, is_last)
        if begins is not None and self.rules.mode == RobotMode.IDLE:
            self._client = begins
            self.rules.begin()
        self._number += 1
        moves = self.rules.mode == RobotMode.MOVE
        if (moves or self._moved) and self._client not in readers:
            readers.append(self._client)
        self._moved = moves
        state = self._state(measured).encode() if readers else b""
        for reader in readers:
            self._send(state, reader)
        return command.velocity

    def close(self) -> None:
        """Closes the port."""
        self._socket.close()

    def _hear(self):
        """Processes packets: commands, requests, and starts of motions."""
        packet, is_last, readers, begins = None, False, [], None
        for request, address in self._requests():
            if request.kind not in (Kind.COMMAND, Kind.LAST):
                readers.append(address)
            elif address == self._client and request.number == self._number:
                packet = np.array(request.values[:7])
                is_last = request.kind == Kind.LAST
            if request.kind == Kind.COLLISION:
                self.rules.collision_torque = np.array(request.values[:7])
            elif request.kind == Kind.BEGIN:
                begins = address
        return packet, is_last, readers, begins

    def _requests(self) -> Iterator[tuple[Request, tuple[str, int]]]:
        while True:
            try:
                data, address = self._socket.recvfrom(LARGEST)
                yield Request.decode(data), address
            except BlockingIOError:
                return
            except (ConnectionError, ValueError):
                continue

    def _state(self, measured: ArmMeasurement) -> State:
        rules, torque = self.rules, measured.torque
        desired = measured.position + TICK * rules.command.velocity
        vectors = (
            measured.position,
            desired,
            measured.velocity,
            rules.command.velocity,
            rules.command.acceleration,
            torque,
            torque,
            measured.external,
        )
        return State(
            self._number,
            rules.mode,
            rules.success_rate,
            rules.error,
            tuple(np.concatenate(vectors)),
        )

    def _send(self, data: bytes, address: tuple[str, int]) -> None:
        # Sending to a client that has ended causes an error, which is ignored.
        with contextlib.suppress(OSError):
            self._socket.sendto(data, address)
