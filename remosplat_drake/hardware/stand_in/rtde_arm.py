"""`RtdeArm`: the simulated controller of a Universal Robots arm."""

import socket
from collections.abc import Callable

import numpy as np

from remosplat_drake.base.errors import RemoSplatError
from remosplat_drake.hardware.drivers.panda_limits import TICK
from remosplat_drake.hardware.stand_in.rtde_packets import (
    Kind,
    Recipe,
    packet,
    split,
)
from remosplat_drake.hardware.stand_in.simulated_arm import (
    ArmMeasurement,
    RobotMode,
)
from remosplat_drake.hardware.stand_in.ur_rules import (
    JOINTS,
    SafetyMode,
    UrRules,
)

RTDE_PORT, DASHBOARD_PORT = 30004, 29999
"""Ports of the Real-Time Data Exchange and of the dashboard server."""

SCRIPT_PORTS = (30001, 30002, 30003)
"""Ports that accept programs."""

CYCLE = 0.002
"""Cycle time of an e-Series controller: 500 Hz [s]."""

VERSION = (5, 11, 0, 108249)
"""Version of the software that the simulated controller reports."""

_POWERED, _PROGRAM = 1, 2
_RUNNING, _IDLE, _PLAYING, _STOPPED = 7, 5, 2, 1
_PROTECTIVE, _EMERGENCY, _NORMAL = 1 << 2, 1 << 6 | 1 << 7, 1
"""Values of `safety_status_bits`: a protective stop, an emergency stop by the
robot's own button, and normal operation."""

_ANSWERS = {
    "polyscopeversion": f"URSoftware {'.'.join(map(str, VERSION))}",
    "is in remote control": "true",
    "robotmode": "Robotmode: RUNNING",
    "get robot model": "UR5",
    "get serial number": "20195500001",
    "quit": "Disconnected",
    "stop": "Stopped",
}
"""Answers of the dashboard server."""


class RtdeArm:
    """Simulates the network interfaces of a Universal Robots controller.

    It has ports for RTDE, for the dashboard server and for uploaded programs.
    `UrRules` determines how the robot reacts. Each call of `step` advances the
    robot's clock.

    Attributes:
        rules: The rules of the robot's controller.
    """

    def __init__(self, host: str):
        """Opens the ports; the arm is powered and runs no program.

        Args:
            host: Address of this computer. The port numbers are fixed, so each
                arm needs its own address, such as 127.0.0.2.

        Raises:
            RemoSplatError: A port is not available.
        """
        self.rules = UrRules()
        self._registers: dict[str, float] = {}
        self._is_fresh = False
        self._ticks = 0
        self._servers = [_Server(host, RTDE_PORT, self._rtde_client)]
        self._servers.append(_Server(host, DASHBOARD_PORT, _Dashboard))
        for port in SCRIPT_PORTS:
            self._servers.append(_Server(host, port, self._script_client))
        self._exchanges: list[_Exchange] = []

    def stop(self, mode: RobotMode) -> None:
        """Makes the arm brake with a protective or an emergency stop."""
        pressed = mode == RobotMode.USER_STOPPED
        self.rules.stop(
            SafetyMode.ROBOT_EMERGENCY_STOP
            if pressed
            else SafetyMode.PROTECTIVE_STOP
        )

    def recover(self) -> None:
        """Unlocks the stop; a client has to upload its program again."""
        self.rules.recover()

    def step(self, measured: ArmMeasurement) -> np.ndarray:
        """Advances the arm by one millisecond.

        Args:
            measured: The present measurements of the arm's sensors.

        Returns:
            Joint rates, shape (6,) [rad/s].
        """
        for server in self._servers:
            server.serve()
        self._ticks += 1
        every = round(CYCLE / TICK)
        if self._ticks % every == 0:
            values = [
                self._registers.get(f"input_double_register_{i}", 0.0)
                for i in range(JOINTS + 2)
            ]
            command = int(self._registers.get("input_int_register_0", 0))
            self.rules.step(CYCLE, command, values, self._is_fresh)
            self._is_fresh = False
            told = self._told(measured)
            self._exchanges = [x for x in self._exchanges if x.is_open]
            for exchange in self._exchanges:
                exchange.tell(told)
        return self.rules.velocity

    def close(self) -> None:
        """Closes the ports."""
        for server in self._servers:
            server.close()

    def _told(self, measured: ArmMeasurement) -> dict:
        """Values of the variables that are not always zero."""
        rules, mode = self.rules, self.rules.safety_mode
        q, v = measured.position.tolist(), measured.velocity.tolist()
        safety = {
            SafetyMode.PROTECTIVE_STOP: _PROTECTIVE,
            SafetyMode.ROBOT_EMERGENCY_STOP: _EMERGENCY,
        }.get(mode, _NORMAL)
        return {
            "timestamp": TICK * self._ticks,
            "actual_q": q,
            "target_q": q,
            "actual_qd": v,
            "target_qd": rules.velocity.tolist(),
            "robot_mode": _RUNNING,
            "safety_mode": int(mode),
            "safety_status_bits": safety,
            "robot_status_bits": _POWERED + _PROGRAM * rules.is_running,
            "runtime_state": _PLAYING if rules.is_running else _STOPPED,
            "speed_scaling": 1.0,
            "target_speed_fraction": 1.0,
            "output_int_register_0": rules.state,
        }

    def _rtde_client(self, connection: "_Connection") -> "_Exchange":
        exchange = _Exchange(connection, self._write)
        self._exchanges.append(exchange)
        return exchange

    def _write(self, values: dict[str, list[float]]) -> None:
        self._registers |= {name: v[0] for name, v in values.items()}
        self._is_fresh = True

    def _script_client(self, connection: "_Connection") -> "_Program":
        return _Program(connection, self.rules.start_script)


class _Connection:
    """A client's socket, which does not block."""

    def __init__(self, connection: socket.socket):
        connection.setblocking(False)
        connection.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        self._socket = connection
        self.is_open = True

    def receive(self) -> bytes:
        try:
            data = self._socket.recv(65536)
        except BlockingIOError:
            return b""
        except OSError:
            data = b""
        if not data:
            self.close()
        return data

    def send(self, data: bytes) -> None:
        try:
            self._socket.sendall(data)
        except OSError:  # Gone, or too slow to read: a robot does not wait.
            self.close()

    def close(self) -> None:
        self.is_open = False
        self._socket.close()


class _Server:
    """Accepts clients on one port, and receives their messages."""

    def __init__(self, host: str, port: int, make: Callable):
        self._make, self._clients = make, []
        self._socket = socket.socket(socket.AF_INET, socket.SOCK_STREAM)
        self._socket.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        try:
            self._socket.bind((host, port))
        except OSError as error:
            raise RemoSplatError(
                f"{host}, TCP port {port}: {error.strerror}"
            ) from error
        self._socket.listen()
        self._socket.setblocking(False)

    def serve(self) -> None:
        try:
            connection, _ = self._socket.accept()
            self._clients.append(self._make(_Connection(connection)))
        except BlockingIOError:
            pass
        for client in self._clients:
            client.hear()
        self._clients = [client for client in self._clients if client.is_open]

    def close(self) -> None:
        self._socket.close()
        for client in self._clients:
            client.connection.close()


class _Client:
    """A connection of a client, with its messages."""

    def __init__(self, connection: _Connection):
        self.connection = connection
        self.buffer = bytearray()

    @property
    def is_open(self) -> bool:
        return self.connection.is_open

    def hear(self) -> None:
        """Processes new messages."""
        data = self.connection.receive()
        if data:
            self.buffer += data
            self.answer()

    def answer(self) -> None:
        """Answers the complete requests in the buffer."""
        raise NotImplementedError


class _Exchange(_Client):
    """A client of the Real-Time Data Exchange."""

    def __init__(
        self,
        connection: _Connection,
        on_data: Callable[[dict[str, list[float]]], None],
    ):
        super().__init__(connection)
        self._on_data = on_data
        self._outputs = Recipe([])
        self._inputs: list[Recipe] = []
        self._every, self._cycles, self._is_started = 1, 0, False

    def tell(self, values: dict) -> None:
        """Sends a data package, if its period has passed."""
        self._cycles += 1
        if self._is_started and self._cycles % self._every == 0:
            data = b"\1" + self._outputs.pack(values)
            self.connection.send(packet(Kind.DATA, data))

    def answer(self) -> None:
        try:
            for kind, payload in split(self.buffer):
                self._take(kind, payload)
        except (ValueError, IndexError, UnicodeDecodeError):
            self.connection.close()  # As the controller does.

    def _take(self, kind: int, payload: bytes) -> None:
        if kind == Kind.DATA:
            recipe = self._inputs[payload[0] - 1]
            self._on_data(recipe.unpack(payload[1:]))
            return
        answer = b"\1"
        if kind == Kind.CONTROLLER_VERSION:
            answer = b"".join(n.to_bytes(4, "big") for n in VERSION)
        elif kind == Kind.REQUEST_VERSION:
            answer = bytes([payload == b"\0\2"])
        elif kind == Kind.SETUP_OUTPUTS:
            frequency = Recipe(["timestamp"]).unpack(payload[:8])["timestamp"]
            self._every = max(round(1 / (CYCLE * max(frequency[0], 1.0))), 1)
            self._outputs = Recipe(_names(payload[8:]))
            answer = b"\1" + ",".join(self._outputs.types).encode()
        elif kind == Kind.SETUP_INPUTS:
            self._inputs.append(Recipe(_names(payload)))
            number = bytes([len(self._inputs)])
            answer = number + ",".join(self._inputs[-1].types).encode()
        elif kind in (Kind.START, Kind.PAUSE):
            self._is_started = kind == Kind.START
        self.connection.send(packet(Kind(kind), answer))


def _names(payload: bytes) -> list[str]:
    """Splits a client's list of variables, which may end with a comma."""
    return [name for name in payload.decode().split(",") if name]


class _Dashboard(_Client):
    """A client of the dashboard server, with text lines."""

    def __init__(self, connection: _Connection):
        super().__init__(connection)
        self._say("Connected: Universal Robots Dashboard Server")

    def answer(self) -> None:
        while b"\n" in self.buffer:
            line, _, rest = self.buffer.partition(b"\n")
            self.buffer = bytearray(rest)
            asked = line.decode(errors="replace").strip().lower()
            self._say(_ANSWERS.get(asked, f"could not understand: {asked}"))

    def _say(self, line: str) -> None:
        self.connection.send(f"{line}\n".encode())


class _Program(_Client):
    """A client that sends a program, which counts as ur_rtde's script."""

    def __init__(self, connection: _Connection, on_program: Callable[[], None]):
        super().__init__(connection)
        self._on_program = on_program

    def answer(self) -> None:
        if b"rtde_control()" in self.buffer and self.buffer.rstrip().endswith(
            b"end"
        ):
            self.buffer.clear()
            self._on_program()
