"""Packets with senders, off a real wire."""

import struct
import time

import pytest
from hypothesis import given
from hypothesis import strategies as st
from pydrake.lcm import DrakeLcm

from remosplat_drake.acceptance.hardware_processes import free_url, wire_works
from remosplat_drake.base.errors import RemoSplatError
from remosplat_drake.hardware.wire.multicast import MulticastListener, parsed

needs_a_wire = pytest.mark.skipif(
    not wire_works(), reason="this computer hears none of its own multicasts"
)


def heard(listener: MulticastListener, count: int) -> list:
    """The next packets that are not LCM's own."""
    packets, end = [], time.monotonic() + 10.0
    while len(packets) < count and time.monotonic() < end:
        packets += [p for p in listener.fetch() if p.channel.startswith("T_")]
        time.sleep(1e-3)
    return packets


@needs_a_wire
def test_each_sender_has_an_address_of_its_own():
    url = free_url()
    listener, a, b = MulticastListener(url), DrakeLcm(url), DrakeLcm(url)
    a.Publish("T_ONE", b"1")
    b.Publish("T_TWO", b"\0\0")
    a.Publish("T_THREE", b"")
    one, two, three = heard(listener, 3)
    assert [one[:2], two[:2]] == [("T_ONE", b"1"), ("T_TWO", b"\0\0")]
    assert three.data == b""
    assert one.sender == three.sender != two.sender
    assert one.sender.split(":")[1].isdecimal()


@needs_a_wire
def test_a_packet_has_the_time_of_its_arrival_not_of_the_look():
    url = free_url()
    listener, sender = MulticastListener(url), DrakeLcm(url)
    before = time.time()
    sender.Publish("T_ONE", b"1")
    after = time.time()
    while time.time() < after + 0.1:
        pass
    (packet,) = heard(listener, 1)
    assert before <= packet.received <= after + 0.05


@needs_a_wire
def test_images_are_left_out():
    url = free_url()
    listener, sender = MulticastListener(url), DrakeLcm(url)
    sender.Publish("T_IMAGE", bytes(300_000))
    sender.Publish("T_SMALL", b"x")
    assert [packet.channel for packet in heard(listener, 1)] == ["T_SMALL"]


@given(st.binary(max_size=80))
def test_bytes_that_are_no_packet_are_none(datagram):
    assert parsed(datagram) is None or datagram.startswith(b"LC02")


def test_a_packet_is_a_magic_a_number_a_name_and_a_message():
    assert parsed(b"LC02" + struct.pack(">I", 7) + b"NAME\0ab\0") == (
        "NAME",
        b"ab\0",
    )
    assert parsed(b"LC02") is None


@pytest.mark.parametrize("url", ["memq://", "udpm://127.0.0.1:7667"])
def test_a_wire_without_addresses_is_refused(url):
    with pytest.raises(RemoSplatError, match="LCM URL"):
        MulticastListener(url)
