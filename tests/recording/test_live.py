"""Foxglove's websocket and RViz's topics, as clients of theirs see them."""

import json
import struct
import time
from argparse import Namespace
from pathlib import Path

import numpy as np
import pytest
from patience import PATIENCE
from ticks import tick

from remosplat_drake.app.scenario import Scenario
from remosplat_drake.base.errors import FieldError, RemoSplatError
from remosplat_drake.commands.flags import opened_recorder
from remosplat_drake.hardware.drivers.ros2_node import Ros2Node, taken
from remosplat_drake.recording.events import TROUBLE, Event
from remosplat_drake.recording.mcap.live_server import LiveServer
from remosplat_drake.recording.mcap.messages import log
from remosplat_drake.recording.mcap.ros2_view import MARKERS, Ros2View

pytest.importorskip("foxglove", reason="needs the extra live")
websockets = pytest.importorskip("websockets.sync.client")

PROTOCOL = "foxglove.sdk.v1"
DOMAIN = 84


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
    kind, subscription, at = struct.unpack_from("<BIQ", data)
    assert (kind, subscription, at) == (1, 7, 12_500_000_000)
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
    flags = Namespace(live=live, record=record, hardware=False, rviz=False)
    with pytest.raises(FieldError, match=problem):
        opened_recorder(flags, Scenario(), frankie)


def test_rviz_is_shown_what_a_tick_holds(frankie):
    """Read on the wire by DDS, and decoded by rosbags."""
    pytest.importorskip("cyclonedds", reason="needs the extra ros2")
    typesys = pytest.importorskip("rosbags.typesys")
    from remosplat_drake.hardware.drivers import ros2_messages as ros

    node = Ros2Node(DOMAIN, "a test")
    readers = {
        "markers": node.reader(MARKERS, ros.MarkerArray),
        "tf": node.reader("/tf", ros.TFMessage),
    }
    view, heard = Ros2View(DOMAIN), {}
    record = tick(frankie, 100.0)
    end = time.monotonic() + PATIENCE
    while len(heard) < len(readers):
        assert time.monotonic() < end
        view.show(record, frankie)
        for name, reader in readers.items():
            for sample in taken(reader):
                heard[name] = sample
    (found,) = heard["tf"].transforms
    assert found.child_frame_id == "remosplat_target"
    assert found.header.stamp.sec == 100
    shapes = {(m.ns, m.text): m for m in heard["markers"].markers}
    link = frankie.spheres.links[3]
    named = [text for ns, text in shapes if ns == "clearance"]
    # 0.3 m is not near; of a link only the nearest sphere counts.
    assert named == [f"{link} 100 mm"]
    assert ("motion_status", "running") in shapes
    store = typesys.get_typestore(typesys.Stores.ROS2_HUMBLE)
    name = "visualization_msgs/msg/MarkerArray"
    read = store.deserialize_cdr(heard["markers"].serialize(), name)
    assert [m.text for m in read.markers] == [t for _, t in shapes]
    sphere = shapes[("clearance", named[0])]
    p_WS = frankie.spheres_at(record.q).p_WS[3]
    position = sphere.pose.position
    np.testing.assert_allclose([position.x, position.y, position.z], p_WS)
