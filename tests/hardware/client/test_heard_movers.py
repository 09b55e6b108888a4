"""Movers that are heard, badly or not at all: what is known of them then."""

import time

import numpy as np
import pytest
from patience import PATIENCE
from pydrake.lcm import DrakeLcm
from pydrake.systems.framework import DiagramBuilder

from remosplat_drake.acceptance.hardware_processes import free_url
from remosplat_drake.hardware.client.hardware_station import HardwareStation
from remosplat_drake.hardware.client.heard_movers import (
    NONE_HEARD,
    HeardMovers,
    with_movers,
)
from remosplat_drake.hardware.hardware_config import HardwareConfig
from remosplat_drake.hardware.mover_sensing_config import MoverSensingConfig
from remosplat_drake.hardware.wire import channels
from remosplat_drake.hardware.wire.movers import encode_movers
from remosplat_drake.scene.mover import Mover, Movers
from remosplat_drake.signals import station_ports as ports

CONFIG = MoverSensingConfig(max_ahead=0.02)
BALL = Mover.sphere("ball", [0, 0, 1], 0.1, v_WM=[1, 0, 0])


def hear(*packets: tuple[float, bytes]) -> HeardMovers:
    """What is known after packets that came at some times."""
    heard = HeardMovers()
    for received, data in packets:
        heard = with_movers(heard, data, received, CONFIG)
    return heard


def told(stamp: float) -> bytes:
    return encode_movers(Movers(stamp, [BALL]))


GOOD = (10.05, told(10.0))


def test_good_movers_replace_those_before():
    heard = hear(GOOD, (10.10, told(10.07)))
    assert heard.movers.stamp == pytest.approx(10.07)
    assert (heard.movers.problem, heard.refused) == ("", 0)


@pytest.mark.parametrize(
    ("packet", "problem"),
    [
        ((10.1, told(10.2)), "stamped 0.1 s in the future"),
        ((10.1, told(9.9)), "0.1 s older than the previous one"),
        ((10.1, told(10.0)), "0 s older than the previous one"),
        ((10.1, told(0.0)), "no stamp"),
        ((10.1, b"noise"), "not a whole mover_list"),
    ],
)
def test_what_cannot_be_believed_leaves_the_others_to_age(packet, problem):
    heard = hear(GOOD, packet)
    assert heard.movers.stamp == 10.0
    assert problem in heard.movers.problem
    assert heard.refused == 1
    # They can have come nearer since.
    assert heard.movers.at(10.3).age == pytest.approx(0.3)


def test_a_stamp_is_allowed_to_be_a_little_ahead():
    assert hear((10.0, told(10.019))).refused == 0


def test_a_good_one_ends_the_problem():
    heard = hear(GOOD, (10.1, b""), (10.15, told(10.12)))
    assert heard.movers.problem == ""
    assert heard.refused == 1


def test_before_the_first_nothing_is_known():
    assert HeardMovers().movers is NONE_HEARD
    assert NONE_HEARD.problem
    assert hear((10.0, b"noise")).movers.stamp == 0.0


def test_they_come_by_real_packets(three_link):
    """Silence, noise, a thousand of them: what was known stays and ages."""
    url = free_url()
    config = HardwareConfig(lcm_url=url, movers=MoverSensingConfig())
    station = HardwareStation(
        config=config, robot=three_link, wrist_camera=False
    )
    builder = DiagramBuilder()
    builder.AddSystem(station)
    diagram = builder.Build()
    root = diagram.CreateDefaultContext()
    context = station.GetMyContextFromRoot(root)
    sender = DrakeLcm(url)
    box = station.link.movers
    assert box is not None

    def say(data: bytes) -> Movers:
        count, end = box.count, time.monotonic() + PATIENCE
        sender.Publish(channels.MOVERS, data)
        while box.count == count:
            assert time.monotonic() < end
            station.link.lcm.HandleSubscriptions(100)
        station.receive(root)
        return station.GetOutputPort(ports.MOVERS).Eval(context)

    now = time.time()
    movers = say(encode_movers(Movers(now, [BALL])))
    assert movers.stamp == pytest.approx(now, abs=1e-6)
    np.testing.assert_array_equal(movers.movers[0].v_WM, [1, 0, 0])
    for data, problem in (
        (b"noise", "not a whole mover_list"),
        (encode_movers(Movers(now + 60.0, [BALL])), "in the future"),
        (
            encode_movers(Movers(now - 60.0, [BALL])),
            "older than the previous one",
        ),
    ):
        kept = say(data)
        assert (kept.stamp, len(kept)) == (movers.stamp, 1)
        assert problem in kept.problem
    again = say(encode_movers(Movers(time.time(), [BALL])))
    assert again.stamp > movers.stamp
    assert again.problem == ""
