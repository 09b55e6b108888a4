"""A cockpit's real process, and what strangers send to its socket."""

import asyncio
import os
import signal
import socket
import time
from importlib.metadata import version
from pathlib import Path

import pytest

pytest.importorskip("viser")

import msgspec
import websockets
from cockpit_rig import Rig
from patience import PATIENCE

from remosplat_drake.base.errors import RemoSplatError
from remosplat_drake.cockpit.cockpit_process import DIED, SILENT


@pytest.fixture
def mortal():
    """A cockpit that a test may end."""
    rig = Rig()
    yield rig
    rig.process.close()


def test_no_other_computer_reaches_it_unless_asked(rig):
    port = int(rig.url.rpartition(":")[2])
    lines = Path("/proc/net/tcp").read_text().splitlines()[1:]
    rows = map(str.split, lines)
    listening = [row[1] for row in rows if row[3] == "0A"]
    assert f"0100007F:{port:04X}" in listening
    assert f"00000000:{port:04X}" not in listening


def test_when_it_dies_the_robot_stops(mortal):
    assert mortal.process.trouble == ""
    os.kill(mortal.process.process.pid, signal.SIGKILL)
    mortal.until(lambda: mortal.process.trouble == DIED)


def test_when_it_hangs_the_robot_stops_and_stays(rig):
    pid = rig.process.process.pid
    os.kill(pid, signal.SIGSTOP)
    rig.until(lambda: rig.process.trouble == SILENT)
    os.kill(pid, signal.SIGCONT)
    rig.until(lambda: rig.process.trouble == "")


def test_it_leaves_with_its_parent(mortal):
    process = mortal.process.process
    mortal.process.close()
    end = time.monotonic() + PATIENCE
    while process.is_alive():
        assert time.monotonic() < end
        time.sleep(0.05)


def test_a_port_that_is_taken_is_named():
    with socket.create_server(("127.0.0.1", 0)) as taken:
        port = taken.getsockname()[1]
        with pytest.raises(RemoSplatError, match=f"--port {port} is taken"):
            Rig(port=port)


@pytest.mark.slow
def test_an_interface_that_is_not_there_is_named():
    with pytest.raises(RemoSplatError, match=r"--host 192\.0\.2\.1"):
        Rig(host="192.0.2.1")


FOREIGN = [
    {"type": "ShareUrlRequest"},
    {
        "type": "GuiUpdateMessage",
        "uuid": "not-yours",
        "updates": {"value": True},
    },
    {
        "type": "TransformControlsUpdateMessage",
        "name": "/gizmo",
        "wxyz": [1, 0, 0, 0],
        "position": [9, 9, 9],
        "owner": "0",
    },
    {
        "type": "ScenePointerMessage",
        "event_type": "click",
        "ray_origin": [0, 0, 2],
        "ray_direction": [0, 0, -1],
        "screen_pos": [[0.5, 0.5]],
        "modifier": None,
        "owner": "0",
    },
    {"type": "GuiButtonHoldMessage", "uuid": "x", "frequency": 1.0},
    {"type": "NoSuchMessage"},
]
"""What another page's script might send."""


def test_strangers_move_nothing(rig):
    """From another origin, without a code: nothing, for any message."""

    async def attack():
        protocol = websockets.Subprotocol(f"viser-v{version('viser')}")
        for message in (*FOREIGN, b"\x00garbage", b""):
            async with websockets.connect(
                rig.url.replace("http", "ws"),
                subprotocols=[protocol],
                origin=websockets.Origin("http://evil.example"),
                max_size=None,
            ) as stranger:
                packet = message
                if isinstance(message, dict):
                    packet = msgspec.msgpack.encode(message)
                await stranger.send(packet)
                await asyncio.sleep(0.1)

    before = rig.requests
    asyncio.run(attack())
    assert rig.requests is before
    assert rig.process.trouble == ""
