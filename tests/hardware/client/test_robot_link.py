"""The link to a robot: a second end of the wire plays its drivers."""

import itertools
import pickle
import time

import numpy as np
import pytest
from drake import (
    lcmt_panda_command,
    lcmt_schunk_wsg_command,
    lcmt_schunk_wsg_status,
)
from pydrake.lcm import DrakeLcm, DrakeLcmParams
from pydrake.systems.analysis import Simulator
from wire_messages import arm_message, base_message

from remosplat_drake.acceptance.hardware_processes import free_url
from remosplat_drake.base.errors import RemoSplatError
from remosplat_drake.hardware.client.hardware_station import HardwareStation
from remosplat_drake.hardware.client.measurement import Measurement
from remosplat_drake.hardware.client.robot_link import RobotLink
from remosplat_drake.hardware.hardware_config import HardwareConfig
from remosplat_drake.hardware.wire import channels
from remosplat_drake.hardware.wire.inbox import Inbox
from remosplat_drake.hardware.wire.messages.base_command import base_command
from remosplat_drake.hardware.wire.ramp import Ramp, decode_ramp
from remosplat_drake.signals.station_status import RUNNING, STOPPED

MARK = "MARK"
"""The channel of a message for which only the test waits."""


class Drivers:
    """The robot's end of the wire."""

    def __init__(self, url: str):
        self.lcm = DrakeLcm(url)
        self._inbox = Inbox(
            self.lcm,
            [
                channels.COMMAND_RAMP,
                channels.PANDA_COMMAND,
                channels.BASE_COMMAND,
                channels.PANDA_HAND_COMMAND,
                MARK,
            ],
        )

    def tell_arm(self, time: float, **fields) -> None:
        data = arm_message(utime=round(time * 1e6), **fields)
        self.lcm.Publish(channels.PANDA_STATUS, data)

    def tell_base(self, time: float, **fields) -> None:
        fields = {"left": 0.0, "utime": round(time * 1e6)} | fields
        data = base_message(**fields)
        self.lcm.Publish(channels.BASE_STATUS, data)

    def hear(self, link: RobotLink) -> dict[str, bytes]:
        """What the link has sent, by channel: all that comes before a mark."""
        link.lcm.Publish(MARK, b"")
        heard = {}
        while MARK not in heard:
            heard.update(self._inbox.fetch(1.0))
        del heard[MARK]
        return heard


@pytest.fixture
def url() -> str:
    return free_url()


@pytest.fixture
def drivers(url) -> Drivers:
    return Drivers(url)


@pytest.fixture
def link(url, frankie) -> RobotLink:
    config = HardwareConfig(lcm_url=url, connect_timeout=0.1)
    return RobotLink(config, frankie)


def q0(link: RobotLink) -> float:
    """The first joint by the newest status."""
    arm = link.updated(Measurement()).arm
    assert arm is not None
    return float(arm.q[0])


def take_in(link: RobotLink, drivers: Drivers) -> None:
    """Lets the link receive what is under way: all that comes before a mark."""
    came = []
    mark = link.lcm.Subscribe(MARK, came.append)
    drivers.lcm.Publish(MARK, b"")
    while not came:
        link.lcm.HandleSubscriptions(1000)
    del mark


def test_of_the_packets_that_wait_the_oldest_is_handed_out(link, drivers):
    """Why `flush` waits for one more, which no driver sends here."""
    marks = []
    mark = link.lcm.Subscribe(MARK, marks.append)
    for attempt in itertools.count():
        assert attempt < 12, "no more than one packet waits"
        count = link.arm.count
        for i in range(1, 4):
            drivers.tell_arm(5.0, joint_position=[0.1 * i] + [0.0] * 6)
        drivers.lcm.Publish(MARK, b"%d" % attempt)
        # They wait for as long as a busy computer needs to fetch them all.
        time.sleep(0.01 * 2**attempt)
        link.take_out()
        if b"%d" % attempt in marks and link.arm.count == count + 1:
            break
        take_in(link, drivers)
    del mark
    assert q0(link) == pytest.approx(0.1)
    assert not link.flush(0.05)
    assert q0(link) == pytest.approx(0.1)
    drivers.tell_arm(5.0, joint_position=[0.9] + [0.0] * 6)
    take_in(link, drivers)
    assert q0(link) == pytest.approx(0.9)


def test_only_new_packets_are_taken(link, drivers):
    drivers.tell_arm(5.0)
    take_in(link, drivers)
    first = link.updated(Measurement())
    assert link.updated(first).arm is first.arm
    drivers.tell_arm(6.0)
    take_in(link, drivers)
    assert link.arm.stamp == pytest.approx(6.0)
    assert link.updated(first).arm.stamp == pytest.approx(6.0)


def test_silent_drivers_are_named(link):
    with pytest.raises(
        RemoSplatError, match="no PANDA_STATUS and no BASE_STATUS on udpm"
    ):
        link.wait_for_statuses()


def test_a_command_goes_to_arm_and_base_with_one_stamp(link, drivers):
    u = np.array([-0.5, 0.1, 0.2, 0, 0, 0, 0, 0, 0])
    before = time.time()
    link.send(u)
    heard = drivers.hear(link)
    arm = lcmt_panda_command.decode(heard[channels.PANDA_COMMAND])
    base = base_command.decode(heard[channels.BASE_COMMAND])
    assert before - 1e-3 <= arm.utime * 1e-6 <= time.time() + 1e-3
    assert arm.utime == base.utime == round(link.sent * 1e6)
    # Twice too fast backwards: the whole command is halved.
    assert (base.forward, base.yaw_rate) == (-0.25, 0.05)
    np.testing.assert_allclose(arm.joint_velocity, u[2:] / 2)
    np.testing.assert_allclose(link.u, u / 2)


def test_a_ramp_goes_before_a_command_with_its_stamp(link, drivers, frankie):
    u = np.array([0.1, 0.1, 0.2, 0, 0, 0, 0, 0, 0])
    link.send(u)
    assert channels.COMMAND_RAMP not in drivers.hear(link)
    link.period = 0.02
    link.send(u)
    heard = drivers.hear(link)
    assert next(iter(heard)) == channels.COMMAND_RAMP
    arm = lcmt_panda_command.decode(heard[channels.PANDA_COMMAND])
    assert decode_ramp(heard[channels.COMMAND_RAMP]) == Ramp(
        arm.utime, 0.02, (np.abs(u) / frankie.acceleration_limit).max()
    )


def test_a_command_that_is_not_finite_is_sent_as_zeros(link, drivers):
    link.send(np.array([0.1, np.nan, *[0.2] * 7]))
    heard = drivers.hear(link)
    arm = lcmt_panda_command.decode(heard[channels.PANDA_COMMAND])
    base = base_command.decode(heard[channels.BASE_COMMAND])
    assert not np.any(arm.joint_velocity)
    assert base.forward == base.yaw_rate == 0


def test_the_hand_is_not_told_more_often_than_it_listens(link, drivers):
    link.send_hand(0.08, 20.0)
    link.send_hand(0.02, 20.0)
    heard = drivers.hear(link)[channels.PANDA_HAND_COMMAND]
    assert lcmt_schunk_wsg_command.decode(heard).target_position_mm == 80


class Bench:
    """A hardware station at a time of our choice."""

    def __init__(self, url, frankie):
        config = HardwareConfig(lcm_url=url)
        self.station = HardwareStation(
            config=config, robot=frankie, wrist_camera=None
        )
        self.simulator = Simulator(self.station)
        self.context = self.simulator.get_mutable_context()
        self.command(np.zeros(9))

    def command(self, u: np.ndarray) -> None:
        for name, value in (
            ("base.velocity_commanded", u[:2]),
            ("panda.velocity_commanded", u[2:]),
            ("hand.command", [0.08, 20.0]),
        ):
            self.station.GetInputPort(name).FixValue(self.context, value)

    def eval(self, name: str):
        return self.station.GetOutputPort(name).Eval(self.context)


def test_before_the_first_message_nothing_is_known(url, frankie):
    bench = Bench(url, frankie)
    for name in ("base.pose_measured", "panda.position_measured", "hand.state"):
        assert np.isnan(bench.eval(name)).all()
    assert bench.eval("status").mode == STOPPED


def test_the_ports_tell_what_the_messages_told(url, frankie, drivers):
    bench = Bench(url, frankie)
    t = 1_700_000_000.0
    link = bench.station.link
    drivers.tell_arm(t)
    drivers.tell_base(t - 0.1, pose=[1.0, 2.0, 0.0], yaw_rate=0.0)
    hand = lcmt_schunk_wsg_status()
    hand.actual_position_mm, hand.actual_force = 60.0, 15.0
    hand.utime = round(1e6 * t)
    drivers.lcm.Publish(channels.PANDA_HAND_STATUS, hand.encode())
    take_in(link, drivers)
    # As if the packets had come when they were stamped.
    for box in (link.arm, link.base, link.hand):
        box.received = t
    bench.context.SetTime(t)
    bench.simulator.Initialize()
    np.testing.assert_allclose(
        bench.eval("panda.position_measured"), 0.1 * np.arange(7)
    )
    np.testing.assert_allclose(
        bench.eval("panda.velocity_measured"), -0.2 * np.arange(7)
    )
    # 0.3 m/s for the 0.1 s since the odometry.
    np.testing.assert_allclose(
        bench.eval("base.pose_measured"), [1.03, 2.0, 0.0], atol=1e-6
    )
    np.testing.assert_allclose(bench.eval("base.velocity_measured"), [0.3, 0])
    np.testing.assert_allclose(bench.eval("hand.state"), [0.06, 0, 15])
    bench.context.SetTime(t + 0.6)
    assert np.isnan(bench.eval("hand.state")).all()
    bench.context.SetTime(t)
    assert bench.eval("status").mode == RUNNING
    bench.command(np.full(9, np.nan))
    assert "not finite" in bench.eval("status").stop_reason
    # Rounding is no fault, anything else is.
    bench.command(np.array([0.5 + 1e-6, -0.87 - 1e-6, *np.zeros(7)]))
    assert bench.eval("status").mode == RUNNING
    bench.command(np.array([0.52, 0.0, *np.zeros(7)]))
    assert bench.eval("status").mode == STOPPED
    assert bench.eval("status").stop_reason == (
        "the base's forward speed is commanded to be 0.520 m/s, beyond"
        " 0.500 m/s"
    )
    bench.command(np.array([0.0, -0.9, *np.zeros(7)]))
    assert "yaw rate" in bench.eval("status").stop_reason


def test_nothing_is_heard_unless_it_is_told_to(url, frankie, drivers):
    bench = Bench(url, frankie)
    bench.simulator.Initialize()
    drivers.tell_arm(5.0)
    take_in(bench.station.link, drivers)
    # Others wait meanwhile: Drake must leave them to Python.
    drivers.tell_arm(6.0)
    bench.simulator.AdvanceTo(0.1)
    assert np.isnan(bench.eval("panda.position_measured")).all()
    bench.station.receive(bench.context)
    np.testing.assert_allclose(
        bench.eval("panda.position_measured"), 0.1 * np.arange(7)
    )


def test_nothing_is_sent_unless_it_is_told_to(url, frankie, drivers):
    bench = Bench(url, frankie)
    bench.command(np.full(9, 0.1))
    bench.simulator.AdvanceTo(0.1)
    assert drivers.hear(bench.station.link) == {}
    bench.station.ForcedPublish(bench.context)
    heard = drivers.hear(bench.station.link)
    assert heard.keys() == {
        channels.PANDA_COMMAND,
        channels.BASE_COMMAND,
        channels.PANDA_HAND_COMMAND,
    }


def test_drakes_lcm_settings_choose_network_and_channels(url, frankie):
    params = DrakeLcmParams(lcm_url=url, channel_suffix="_2")
    config = pickle.loads(pickle.dumps(HardwareConfig(lcm=params)))
    assert config.url == url
    link = RobotLink(config, frankie)
    drivers = DrakeLcm(url)
    # Said again until it is heard: a socket that is just open loses some.
    heard, answers = [], []
    mark = drivers.Subscribe("MARK_2", heard.append)
    while b"to them" not in heard:
        link.lcm.Publish("MARK", b"to them")
        drivers.HandleSubscriptions(100)
    mark = link.lcm.Subscribe("MARK", answers.append)
    while b"to us" not in answers:
        drivers.Publish("MARK_2", b"to us")
        link.lcm.HandleSubscriptions(100)
    del mark


def test_a_shadow_sends_nothing(url, drivers, frankie):
    shadow = RobotLink(HardwareConfig(lcm_url=url, shadow=True), frankie)
    shadow.take_command()
    shadow.send(np.full(9, 0.1))
    shadow.send_hand(0.04, 10.0)
    assert drivers.hear(shadow) == {}
    np.testing.assert_allclose(shadow.u, 0.1)


def test_the_hand_stands_until_the_robot_is_armed(link, drivers):
    link.is_armed = False
    link.send_hand(0.04, 10.0)
    assert drivers.hear(link) == {}
    link.is_armed = True
    link.send_hand(0.04, 10.0)
    assert channels.PANDA_HAND_COMMAND in drivers.hear(link)


def test_who_else_commands_is_the_stations_problem(link, drivers, url):
    drivers.tell_arm(time.time())
    drivers.tell_base(time.time())
    stranger = DrakeLcm(url)
    stranger.Publish(channels.PANDA_COMMAND, b"")
    heard, end = Measurement(), time.monotonic() + 5.0
    while not heard.intruder and time.monotonic() < end:
        link.take_out()
        heard = link.updated(heard)
    assert heard.intruder.startswith(f"{channels.PANDA_COMMAND}: ")
    assert link.guard is not None
    assert "also sends commands" in link.guard.take_command(0.0)


def test_another_network_keeps_the_names_of_channels():
    there, here = (f"udpm://239.255.76.67:{port}?ttl=0" for port in (1, 2))
    lcm = DrakeLcmParams(lcm_url=there, channel_suffix="_2")
    config = HardwareConfig(lcm=lcm)
    config.use_url(here)
    assert config.url == here and config.suffix == "_2"
    assert not list(config.check())
    with pytest.raises(RemoSplatError, match="nonsense"):
        config.use_url("nonsense")
    assert config.url == here
