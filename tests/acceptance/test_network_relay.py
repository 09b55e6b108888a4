"""The relay between two wires, in one process, by a clock of our own."""

import numpy as np
import pytest
from pydrake.lcm import DrakeLcm

from remosplat_drake.acceptance.network_relay import Relay
from remosplat_drake.hardware.wire import channels
from remosplat_drake.hardware.wire.inbox import Inbox


@pytest.fixture
def wires() -> tuple[DrakeLcm, DrakeLcm]:
    return DrakeLcm("memq://"), DrakeLcm("memq://")


def test_commands_go_one_way_and_statuses_the_other(wires):
    a, b = wires
    relay, rng = Relay(a, b), np.random.default_rng(0)
    to_a = Inbox(a, [channels.PANDA_STATUS])
    to_b = Inbox(b, [channels.BASE_COMMAND])
    a.Publish(channels.BASE_COMMAND, b"command")
    b.Publish(channels.PANDA_STATUS, b"status")
    relay.step(0.0, rng)
    assert to_b.fetch() == [(channels.BASE_COMMAND, b"command")]
    assert (channels.PANDA_STATUS, b"status") in to_a.fetch()


def test_a_message_comes_after_its_delay(wires):
    a, b = wires
    relay, rng = Relay(a, b), np.random.default_rng(0)
    relay.delay = 0.05
    heard = Inbox(b, [channels.PANDA_COMMAND])
    a.Publish(channels.PANDA_COMMAND, b"command")
    relay.step(1.0, rng)
    relay.step(1.049, rng)
    assert heard.fetch() == []
    relay.step(1.051, rng)
    assert heard.fetch() == [(channels.PANDA_COMMAND, b"command")]


def test_the_share_that_gets_lost_is_the_one_asked_for(wires):
    a, b = wires
    relay, rng = Relay(a, b), np.random.default_rng(0)
    relay.loss = 0.2
    heard, count = Inbox(b, [channels.PANDA_COMMAND]), 0
    for i in range(1000):
        a.Publish(channels.PANDA_COMMAND, b"command")
        relay.step(float(i), rng)
        count += len(heard.fetch())
    assert 760 <= count <= 840
