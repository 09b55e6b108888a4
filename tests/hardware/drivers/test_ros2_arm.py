"""An arm behind ros2_control: real DDS participants on both sides."""

import dataclasses as dc
import time
from collections.abc import Callable, Sequence

import numpy as np
import pytest
from patience import PATIENCE
from pydrake.lcm import DrakeLcm
from robot_process import Client, running

from remosplat_drake.acceptance.hardware_processes import free_url
from remosplat_drake.base.clock import wall_utime
from remosplat_drake.hardware.driver_config import Ros2Arm
from remosplat_drake.hardware.drivers.arm_driver import ArmDriver
from remosplat_drake.hardware.drivers.arm_stops import ArmStops
from remosplat_drake.hardware.drivers.ros2_arm import Ros2ArmLink
from remosplat_drake.hardware.drivers.ros2_node import Ros2Node
from remosplat_drake.hardware.stand_in.simulated_arm import RobotMode
from remosplat_drake.robot.robot_description import load_robot_description

pytest.importorskip("cyclonedds", reason="needs the extra ros2")

from cyclonedds.core import Policy, Qos
from cyclonedds.domain import DomainParticipant
from cyclonedds.pub import DataWriter
from cyclonedds.sub import DataReader
from cyclonedds.topic import Topic

from remosplat_drake.hardware.drivers import ros2_messages as ros

DOMAIN = 79
ARM = Ros2Arm(domain=DOMAIN)
UR5E = load_robot_description("ur5e")
RATES = np.array([0.2, 0.0, 0.0, 0.1, 0.0, -0.3])
NAMES = [
    *("wrist_3_joint", "shoulder_pan_joint", "shoulder_lift_joint"),
    *("elbow_joint", "wrist_1_joint", "wrist_2_joint", "gripper"),
]
LATE = 20_000
"""Age of joint states when they are sent [us]."""

NOW = 1_700_000_000_000_000
"""The time by the driver's clock [us]."""


class Controller:
    """ros2_control, with a velocity controller and a broadcaster."""

    def __init__(self):
        self._participant = DomainParticipant(DOMAIN)
        self._states = self.writer("/joint_states", ros.JointState)
        self._commands = DataReader(
            self._participant,
            Topic(
                self._participant,
                "rt/velocity_controller/commands",
                ros.Float64MultiArray,
            ),
        )
        # The gripper has no velocity, which is nothing to the arm.
        self.q, self.v = np.arange(7.0), np.append(np.zeros(6), np.nan)
        self.stamps: set[int] = set()

    def writer(self, topic: str, kind) -> DataWriter:
        """Makes a writer of a topic."""
        name = ros.dds_topic(topic)
        return DataWriter(
            self._participant, Topic(self._participant, name, kind)
        )

    def obey(self) -> None:
        """Moves as it was told last."""
        for sample in self._commands.take(N=50):
            rates = list(sample.data)
            self.v[:6] = rates[-1:] + rates[:-1]
        self.q = self.q + 0.01 * self.v

    def tell(
        self,
        velocity: Sequence[float] | None = None,
        position: Sequence[float] | None = None,
        utime: int | None = None,
    ) -> None:
        """Sends joint states.

        Args:
            velocity: Their velocities; None for the true ones [rad/s].
            position: Their positions, likewise [rad].
            utime: Their stamp; None for a moment ago [us].
        """
        utime = wall_utime() - LATE if utime is None else utime
        self.stamps.add(utime)
        message = ros.JointState(name=NAMES)
        message.position = list(self.q if position is None else position)
        message.velocity = list(self.v if velocity is None else velocity)
        message.header.stamp = ros.stamp(utime)
        self._states.write(message)


@pytest.mark.slow
def test_an_arm_behind_ros2_control_is_driven():
    controller, url = Controller(), free_url()
    arm = f"{{hardware: {{arm_driver: !Ros2Arm {{domain: {DOMAIN}}}}}}}"
    with running(
        *("arm-driver", "Ur5eReach", "--scenario-text", arm),
        *("--lcm-url", url),
    ) as driver:
        client = Client(url)

        def tells(done: Callable[[], bool]) -> Callable[[], bool]:
            def told() -> bool:
                assert driver.poll() is None
                controller.obey()
                controller.tell()
                return done()

            return told

        client.wait_for(tells(lambda: bool(client.arm)))
        # In the description's order, for any order of the broadcaster.
        np.testing.assert_allclose(
            client.latest.joint_position, [1, 2, 3, 4, 5, 0]
        )
        obeys = tells(lambda: np.allclose(client.latest.joint_velocity, RATES))
        client.drive(obeys, RATES)
        client.wait_for(tells(lambda: not np.any(client.latest.joint_velocity)))
        assert client.latest.utime in controller.stamps, "the source's stamp"
        assert client.latest.robot_mode == RobotMode.MOVE
        driver.terminate()
        _, said = driver.communicate(timeout=PATIENCE)
    assert "setting `emergency_stop` is empty" in said
    assert "setting `mode` is empty" in said


def test_joint_states_are_read_by_another_decoder():
    typesys = pytest.importorskip("rosbags.typesys")
    store = typesys.get_typestore(typesys.Stores.ROS2_HUMBLE)
    message = ros.JointState(name=["a", "b"], position=[1, 2], velocity=[3, 4])
    read = store.deserialize_cdr(
        message.serialize(), "sensor_msgs/msg/JointState"
    )
    assert (read.name, list(read.velocity)) == (["a", "b"], [3, 4])
    array = ros.Float64MultiArray(data=[0.5, -1.0])
    read = store.deserialize_cdr(
        array.serialize(), "std_msgs/msg/Float64MultiArray"
    )
    assert list(read.data) == [0.5, -1.0]
    for message, name in (
        (ros.String("hold"), "String"),
        (ros.Int32(7), "Int32"),
    ):
        read = store.deserialize_cdr(
            message.serialize(), f"std_msgs/msg/{name}"
        )
        assert read.data == message.data


class Bench:
    """A driver of the arm in this process; its commands never expire."""

    def __init__(self, topics: Ros2Arm):
        self.controller, self.news = Controller(), []
        self._arm = Ros2ArmLink(topics, UR5E, self.news.append)
        self.news.clear()
        self._wire = DrakeLcm("memq://")
        self.client = Client(self._wire, lambda: NOW)
        self._driver = ArmDriver(self._wire, self._arm, joints=6)
        self._steps = 0

    def run_until(
        self,
        done: Callable[[], bool],
        tell: Callable[[], None] = lambda: None,
        rates: np.ndarray | None = None,
    ) -> None:
        """Runs the driver until something is so.

        Args:
            done: What ends it.
            tell: What the robot tells besides its joint states.
            rates: What is commanded, shape (6,); None for nothing [rad/s].
        """

        def step() -> bool:
            tell()
            self.controller.obey()
            self.controller.tell()
            if rates is not None:
                self.client.send_arm(rates)
            self._steps += 1
            self._driver.step(NOW, 0.01 * self._steps)
            return done()

        self.client.wait_for(step)

    def run_until_mode(self, mode: int, *arguments) -> None:
        """Runs until statuses tell a mode, as `run_until`."""
        self.client.arm.clear()
        self.run_until(lambda: mode in self.modes, *arguments)

    @property
    def modes(self) -> set[int]:
        """The modes that statuses have told since the last were cleared."""
        return {status.robot_mode for status in self.client.arm}


def test_a_status_is_as_old_as_its_joint_state():
    """However late it comes."""
    bench = Bench(ARM)
    bench.run_until(lambda: len(bench.client.arm) > 5)
    for status in bench.client.arm:
        assert status.utime in bench.controller.stamps
        assert status.utime == status.robot_utime


@pytest.mark.parametrize(
    ("fields", "said"),
    [
        ({"velocity": []}, "no velocity of shoulder_pan_joint, shoulder_lift"),
        ({"velocity": [np.nan] + [0.0] * 6}, "no velocity of wrist_3_joint: "),
        ({"position": []}, "no position of shoulder_pan_joint"),
        ({"utime": 0}, "header.stamp is 0"),
    ],
)
def test_joint_states_that_cannot_be_used_are_told(fields, said):
    """None of them is taken for a standstill."""
    controller, news, reports = Controller(), [], []
    arm = Ros2ArmLink(ARM, UR5E, news.append)
    news.clear()
    end = time.monotonic() + PATIENCE
    while not news:
        assert time.monotonic() < end
        controller.tell(**fields)
        reports.append(arm.fetch())
    assert news[0].startswith(f"/joint_states: {said}")
    assert len(news) == 1
    assert not any(reports)


TOPICS = Ros2Arm(
    domain=DOMAIN,
    emergency_stop="/e_stop",
    mode="/arm_mode",
    running_modes=["RUNNING", "SLOW"],
    stop_expiry=PATIENCE,
)


def test_named_topics_hold_the_arm():
    bench = Bench(TOPICS)
    stop = bench.controller.writer("/e_stop", ros.Bool)
    mode = bench.controller.writer("/arm_mode", ros.String)

    def say(pressed: bool, text: str | None) -> Callable[[], None]:
        def tell() -> None:
            stop.write(ros.Bool(pressed))
            if text is not None:
                mode.write(ros.String(text))

        return tell

    # What was never heard holds it, commands or not.
    bench.run_until_mode(RobotMode.OTHER, lambda: None, RATES)
    bench.run_until_mode(RobotMode.OTHER, say(False, None), RATES)
    bench.run_until(
        lambda: any("/arm_mode: nothing came yet" in n for n in bench.news),
        say(False, None),
        RATES,
    )
    assert not bench.controller.v[:6].any()

    def free(text: str) -> None:
        """Ends what holds the arm, which is commanded to rest."""
        bench.run_until_mode(RobotMode.MOVE, say(False, text), 0 * RATES)
        rest = len(bench.client.arm) + 5
        bench.run_until(
            lambda: len(bench.client.arm) > rest, say(False, text), 0 * RATES
        )

    free("SLOW")

    def moves() -> bool:
        return np.allclose(bench.client.latest.joint_velocity, RATES)

    def rests() -> bool:
        return not np.any(bench.client.latest.joint_velocity)

    bench.run_until(moves, say(False, "RUNNING"), RATES)
    bench.run_until_mode(RobotMode.USER_STOPPED, say(True, "RUNNING"), RATES)
    bench.run_until(rests, say(True, "RUNNING"), RATES)
    # Its release starts no motion: only after a command to rest it moves.
    bench.run_until_mode(RobotMode.MOVE, say(False, "RUNNING"), RATES)
    bench.run_until(
        lambda: len(bench.client.arm) > 20, say(False, "RUNNING"), RATES
    )
    assert rests()
    free("RUNNING")
    bench.run_until(moves, say(False, "RUNNING"), RATES)
    bench.run_until_mode(RobotMode.OTHER, say(False, "FAULT"), RATES)
    bench.run_until(rests, say(False, "FAULT"), RATES)
    assert [line for line in bench.news if "no longer" not in line] == [
        "/e_stop: nothing came yet; the arm counts as stopped",
        "/arm_mode: nothing came yet; the arm counts as stopped",
        "/e_stop: emergency stop; the arm counts as stopped",
        "/arm_mode: 'FAULT', not 'RUNNING' or 'SLOW'; the arm counts as"
        " stopped",
    ]


@pytest.mark.parametrize(
    ("old", "new", "problem"),
    [
        ("", "", ""),
        ("elbow_joint", "elbow", "has no joint elbow_joint"),
        ('velocity="3.14159"', 'velocity="1.5"', "shoulder_pan_joint: is lim"),
    ],
)
def test_an_arm_moves_only_by_a_model_that_its_urdf_agrees_with(
    old, new, problem
):
    topic = f"/robot_description_{len(old)}"
    node = Ros2Node(DOMAIN, "a test")
    writer = node.writer(topic, ros.String, latched=True)
    bench = Bench(dc.replace(ARM, description=topic))
    bench.run_until_mode(RobotMode.OTHER)
    said = f"{topic}: nothing came yet; the arm counts as stopped"
    assert bench.news == [said]
    text = UR5E.model_path.read_text()
    writer.write(ros.String(text.replace(old, new)))
    bench.run_until(lambda: len(bench.news) == 2)
    if problem:
        assert bench.news[-1].startswith(f"{topic}: {problem}")
        return
    bench.run_until_mode(RobotMode.MOVE)
    writer.write(ros.String(f"{text} "))
    bench.run_until_mode(RobotMode.OTHER)
    assert "has changed: restart the driver" in bench.news[-1]


def test_a_latched_mode_is_heard_by_who_comes_late():
    """ur_robot_driver tells once, before we are there, that a program runs."""
    participant = DomainParticipant(DOMAIN)
    writer = DataWriter(
        participant,
        Topic(participant, "rt/program_running", ros.Bool),
        qos=Qos(
            Policy.Reliability.Reliable(10_000_000),
            Policy.Durability.TransientLocal,
            Policy.History.KeepLast(1),
        ),
    )
    writer.write(ros.Bool(True))
    bench = Bench(
        dc.replace(
            ARM,
            mode="/program_running",
            mode_type="Bool",
            running_modes=["true"],
            stop_expiry=None,
        )
    )
    bench.run_until_mode(RobotMode.MOVE)
    writer.write(ros.Bool(False))
    bench.run_until_mode(RobotMode.OTHER)


def test_a_topic_that_falls_silent_holds_the_arm():
    bench = Bench(
        dc.replace(TOPICS, mode="", running_modes=[], stop_expiry=0.5)
    )
    stop = bench.controller.writer("/e_stop", ros.Bool)
    bench.run_until_mode(RobotMode.MOVE, lambda: stop.write(ros.Bool(False)))
    bench.run_until_mode(RobotMode.OTHER)
    said = (
        "/e_stop: nothing came for more than 0.5 s; the arm counts as stopped"
    )
    assert bench.news[-1] == said


@pytest.mark.parametrize(
    ("kind", "running", "values"),
    [
        ("Int32", "7", [ros.Int32(7), ros.Int32(3)]),
        ("Bool", "true", [ros.Bool(True), ros.Bool(False)]),
    ],
)
def test_a_mode_may_be_a_number_or_a_flag(kind, running, values):
    topic = f"/mode_{kind}"
    bench = Bench(
        dc.replace(ARM, mode=topic, mode_type=kind, running_modes=[running])
    )
    mode = bench.controller.writer(topic, type(values[0]))
    good, bad = ((lambda v=v: mode.write(v)) for v in values)
    bench.run_until_mode(RobotMode.MOVE, good)
    bench.run_until_mode(RobotMode.OTHER, bad)
    assert bench.news[-1].startswith(f"{topic}: ")


def test_a_pressed_stop_is_told_before_a_silent_mode():
    stops = ArmStops(dc.replace(TOPICS, stop_expiry=1.0))
    assert stops.hold(0.0).reason == "/e_stop: nothing came yet"
    stops.put("emergency_stop", True, 0.0)
    assert stops.hold(0.5) == (
        RobotMode.USER_STOPPED,
        "/e_stop: emergency stop",
    )
    assert stops.hold(1.5).reason == "/e_stop: nothing came for more than 1.0 s"
    stops.put("emergency_stop", False, 2.0)
    assert stops.hold(2.0).reason == "/arm_mode: nothing came yet"
    stops.put("mode", "SLOW", 2.0)
    assert stops.hold(2.5) == (RobotMode.MOVE, "")
    assert ArmStops(ARM).hold(9.0) == (RobotMode.MOVE, "")
