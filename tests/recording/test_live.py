"""Foxglove's websocket, as a client of its protocol sees it."""

import json
import struct
from argparse import Namespace
from pathlib import Path

import pytest

from remosplat_drake.app.scenario import Scenario
from remosplat_drake.base.errors import FieldError, RemoSplatError
from remosplat_drake.commands.flags import opened_recorder
from remosplat_drake.recording.events import TROUBLE, Event
from remosplat_drake.recording.mcap.live_server import LiveServer
from remosplat_drake.recording.mcap.messages import log

pytest.importorskip("foxglove", reason="needs the extra live")
websockets = pytest.importorskip("websockets.sync.client")

PROTOCOL = "foxglove.sdk.v1"


def test_a_client_sees_what_a_recording_holds():
    server = LiveServer(0)
    message = log(Event(12.5, TROUBLE, "a cable is loose"))
    server.add(message)
    url = f"ws://127.0.0.1:{server.port}"
    with websockets.connect(url, subprotocols=[PROTOCOL]) as client:
        channel = None
        while channel is None:
            said = json.loads(client.recv(timeout=10))
            if said["op"] == "advertise":
                (channel,) = said["channels"]
        assert (channel["topic"], channel["encoding"]) == ("/events", "json")
        assert channel["schemaName"] == "foxglove.Log"
        assert json.loads(channel["schema"])["title"] == "foxglove.Log"
        ask = {"id": 7, "channelId": channel["id"]}
        client.send(json.dumps({"op": "subscribe", "subscriptions": [ask]}))
        data = None
        while not isinstance(data, bytes):
            # A subscription may take a moment; what is sent before is lost.
            server.add(message)
            try:
                data = client.recv(timeout=0.1)
            except TimeoutError:
                continue
    server.close()
    kind, subscription, time = struct.unpack_from("<BIQ", data)
    assert (kind, subscription, time) == (1, 7, 12_500_000_000)
    assert json.loads(data[13:]) == message.content


def test_a_port_that_is_taken_is_told():
    server = LiveServer(0)
    with pytest.raises(RemoSplatError, match=f"--live: port {server.port}: "):
        LiveServer(server.port)
    server.close()


@pytest.mark.parametrize(
    ("live", "record", "problem"),
    [
        (8765, None, "--live: 8765: needs --record"),
        (0, Path("x.mcap"), "must be a port, 1 to 65535"),
        (65536, Path("x.mcap"), "must be a port, 1 to 65535"),
    ],
)
def test_flags_that_make_no_sense_are_told(live, record, problem, frankie):
    flags = Namespace(live=live, record=record, hardware=False)
    with pytest.raises(FieldError, match=problem):
        opened_recorder(flags, Scenario(), frankie)
