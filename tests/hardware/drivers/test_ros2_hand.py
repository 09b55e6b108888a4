"""A gripper on ROS 2: real DDS participants, and processes, on both sides."""

import contextlib
import os
import threading
import time
from collections.abc import Callable
from pathlib import Path

import pytest
from patience import PATIENCE
from robot_process import Client, running

from remosplat_drake.acceptance.hardware_processes import free_url
from remosplat_drake.base.clock import wall_utime
from remosplat_drake.base.errors import RemoSplatError
from remosplat_drake.commands.main import main
from remosplat_drake.hardware.driver_config import Ros2Hand
from remosplat_drake.hardware.drivers.ros2_hand import Ros2HandLink
from remosplat_drake.hardware.drivers.ros2_node import Ros2Node, taken
from remosplat_drake.robot.robot_description import load_robot_description

pytest.importorskip("cyclonedds", reason="needs the extra ros2")
typesys = pytest.importorskip("rosbags.typesys")

from remosplat_drake.hardware.drivers import ros2_messages as ros

DOMAIN = 88
FETCH = load_robot_description("fetch")
FINGERS = list(FETCH.hand.joints) if FETCH.hand else []
ROBOTS = Path(__file__).parents[3] / "apps" / "examples" / "robots.yaml"


def test_a_command_is_read_by_another_decoder():
    name = "control_msgs/msg/GripperCommand"
    store = typesys.get_typestore(typesys.Stores.ROS2_HUMBLE)
    text = "float64 position\nfloat64 max_effort"
    store.register(typesys.get_types_from_msg(text, name))
    data = ros.GripperCommand(0.04, 25.0).serialize()
    read = store.deserialize_cdr(data, name)
    assert (read.position, read.max_effort) == (0.04, 25.0)
    assert bytes(store.serialize_cdr(read, name)) == data


class Gripper:
    """A gripper on a topic of its own, whose fingers move by steps."""

    def __init__(self, topic: str):
        node = Ros2Node(DOMAIN, "a test")
        commands, states = f"{topic}/command", f"{topic}/joint_states"
        self._reader = node.reader(commands, ros.GripperCommand)
        self._writer = node.writer(states, ros.JointState)
        self.news: list[str] = []
        config = Ros2Hand(DOMAIN, commands, states)
        self.link = Ros2HandLink(config, FETCH, self.news.append)
        self.heard: list[tuple[float, float]] = []
        self.width, self.goal, self.effort = 0.1, 0.1, []

    def step(self) -> None:
        """Moves by 2 mm at most, and tells it."""
        for sample in taken(self._reader):
            self.heard.append((sample.position, sample.max_effort))
            self.goal = sample.position
        self.width += max(-0.002, min(0.002, self.goal - self.width))
        self.tell([0.5 * self.width] * 2)

    def tell(self, position: list[float], utime: int | None = None) -> None:
        utime = wall_utime() if utime is None else utime
        header = ros.Header(ros.stamp(utime))
        self._writer.write(
            ros.JointState(header, FINGERS, position, [], self.effort)
        )

    def step_until(self, done: Callable[[], bool]) -> None:
        end = time.monotonic() + PATIENCE
        while not done():
            assert time.monotonic() < end
            self.step()
            time.sleep(0.005)


def test_a_motion_ends_when_the_fingers_stop():
    gripper = Gripper("/ends")
    assert gripper.link.measure() is None
    gripper.step_until(lambda: gripper.link.measure() is not None)
    assert gripper.link.measure() == pytest.approx((0.1, 0.0))
    gripper.effort = [-12.0, 11.0]
    motion = threading.Thread(target=gripper.link.go_to, args=(0.02, 12.0))
    motion.start()
    gripper.step_until(lambda: not motion.is_alive())
    motion.join()
    assert set(gripper.heard) == {(0.02, 12.0)}
    closed = pytest.approx((0.02, 12.0))
    gripper.step_until(lambda: gripper.link.measure() == closed)


def test_joint_states_that_cannot_be_used_are_told_and_are_no_opening():
    gripper, end = Gripper("/broken"), time.monotonic() + PATIENCE
    for position, utime, said in (
        ([0.01], None, "no position of r_gripper_finger_joint, l_gripper"),
        ([0.01, 0.01], 0, "header.stamp is 0"),
    ):
        count = len(gripper.news)
        while len(gripper.news) == count:
            assert time.monotonic() < end
            gripper.tell(position, utime)
            assert gripper.link.measure() is None
        assert gripper.news[-1].startswith(f"/broken/joint_states: {said}")
    with pytest.raises(RemoSplatError, match="no usable message"):
        gripper.link.go_to(0.02, 12.0)


def test_a_robot_without_a_hand_is_told(capsys):
    text = "{hardware: {hand_driver: !Ros2Hand {}}}"
    line = ["hand-driver", "Ur5eReach", "--scenario-text", text]
    assert main([*line, "--lcm-url", free_url()]) == 2
    said = capsys.readouterr().err
    assert "hand_driver.joints: ur5e has no hand: name the finger" in said
    assert main(["hand-driver", "Ur5eReach"]) == 2
    said = capsys.readouterr().err
    assert "hardware.hand_driver: is absent: name the hand's driver" in said


@pytest.mark.slow
def test_the_hand_of_a_robot_on_ros2_closes_and_is_read_back(lone_robot):
    """Three processes, of which two know each other by ROS 2 only."""
    url, scenario = free_url(), f"{ROBOTS}:Fetch"
    own = dict(os.environ, ROS_DOMAIN_ID=str(DOMAIN))
    with contextlib.ExitStack() as programs:
        for line in (
            ("hardware-sim", scenario, "--ros2"),
            ("hand-driver", scenario, "--lcm-url", url),
        ):
            programs.enter_context(running(*line, environment=own))
        client = Client(url)
        client.wait_for(lambda: bool(client.hand))
        opened = client.hand[-1].actual_position_mm

        def is_at(width: float) -> Callable[[], bool]:
            def done() -> bool:
                client.send_hand(width, 20.0)
                came = client.hand[-1].actual_position_mm
                return abs(came - 1e3 * width) < 1.0

            return done

        assert opened > 60.0
        client.wait_for(is_at(0.03))
        client.wait_for(is_at(0.08))
