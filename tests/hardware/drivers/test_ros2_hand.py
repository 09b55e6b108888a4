"""A gripper on ROS 2: real DDS participants, and processes, on both sides."""

import contextlib
import os
import shutil
import subprocess
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
from remosplat_drake.hardware.drivers.ros2_gripper_action import (
    ENDED,
    EXECUTING,
    SUCCEEDED,
    GripperAction,
)
from remosplat_drake.hardware.drivers.ros2_hand import Ros2HandLink
from remosplat_drake.hardware.drivers.ros2_node import Ros2Node, taken
from remosplat_drake.hardware.stand_in.gripper_server import GripperServer
from remosplat_drake.robot.robot_description import load_robot_description

pytest.importorskip("cyclonedds", reason="needs the extra ros2")
typesys = pytest.importorskip("rosbags.typesys")

from remosplat_drake.hardware.drivers import ros2_action_messages as actions
from remosplat_drake.hardware.drivers import ros2_messages as ros

ACTION = "remosplat_drake.hardware.drivers.ros2_gripper_action"
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


GOAL = bytes(range(16))


def test_a_goal_and_its_state_are_read_by_another_decoder():
    """Fast DDS's server of the action reads these bytes."""
    store = typesys.get_typestore(typesys.Stores.ROS2_HUMBLE)
    command = "control_msgs/msg/GripperCommand"
    name = "control_msgs/msg/GripperCommand_SendGoal_Request"
    numbers = "float64 position\nfloat64 max_effort"
    store.register(typesys.get_types_from_msg(numbers, command))
    text = f"unique_identifier_msgs/UUID goal_id\n{command} command"
    store.register(typesys.get_types_from_msg(text, name))
    request = actions.GoalRequest.of(GOAL, 0.04, 25.0)
    read = store.deserialize_cdr(request.serialize(), name)
    assert bytes(read.goal_id.uuid) == GOAL
    assert (read.command.position, read.command.max_effort) == (0.04, 25.0)
    assert bytes(store.serialize_cdr(read, name)) == request.serialize()
    info = actions.GoalInfo(actions.UUID(GOAL), ros.Time(7, 8))
    sent = actions.GoalStatusArray([actions.GoalStatus(info, EXECUTING)])
    name = "action_msgs/msg/GoalStatusArray"
    (state,) = store.deserialize_cdr(sent.serialize(), name).status_list
    assert bytes(state.goal_info.goal_id.uuid) == GOAL
    assert (state.goal_info.stamp.sec, state.status) == (7, EXECUTING)


def test_cyclone_servers_get_the_clients_identity_before_the_goal():
    request = actions.GoalRequest.of(GOAL, 0.04, 25.0)
    plain = request.serialize()
    request.client = actions.client_header(b"12345678", 3)
    data = request.serialize()
    assert data[4:20] == b"12345678" + bytes([3, 0, 0, 0, 0, 0, 0, 0])
    assert data[:4] + data[20:] == plain
    read = actions.GoalRequest.deserialize(data)
    assert (read, read.client) == (request, request.client)


class Gripper:
    """A gripper on a topic of its own, whose fingers move by steps."""

    def __init__(self, topic: str, *, acts: bool = False):
        node = Ros2Node(DOMAIN, "a test")
        commands, states = f"{topic}/command", f"{topic}/joint_states"
        self._reader = node.reader(commands, ros.GripperCommand)
        self._writer = node.writer(states, ros.JointState)
        self.news: list[str] = []
        action = f"{topic}/gripper_cmd" if acts else ""
        self.server = GripperServer(node, action) if acts else None
        config = Ros2Hand(DOMAIN, action, commands, states)
        self.link = Ros2HandLink(config, FETCH, self.news.append)
        self.heard: list[tuple[float, float]] = []
        self.width, self.goal, self.effort = 0.1, 0.1, []
        self.stop = 0.0

    def step(self) -> None:
        """Moves by 2 mm at most, and tells it."""
        commands = taken(self._reader)
        if self.server is not None:
            commands = self.server.commands()
        for command in commands:
            self.heard.append((command.position, command.max_effort))
            self.goal = command.position
        step = max(-0.002, min(0.002, self.goal - self.width))
        step = max(step, self.stop - self.width)
        self.width += step
        if self.server is not None:
            self.server.tell(self.width, step / 0.005)
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


@pytest.mark.parametrize("acts", [False, True], ids=["topic", "action"])
def test_a_motion_ends_when_the_fingers_stop(acts):
    gripper = Gripper(f"/ends_{acts}", acts=acts)
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


def test_a_goal_that_is_aborted_at_an_object_ends_the_motion():
    gripper = Gripper("/holds", acts=True)
    gripper.stop = 0.05
    gripper.step_until(lambda: gripper.link.measure() is not None)
    motion = threading.Thread(target=gripper.link.go_to, args=(0.0, 12.0))
    motion.start()
    gripper.step_until(lambda: not motion.is_alive())
    assert gripper.heard == [(0.0, 12.0)]
    assert gripper.link.measure() == pytest.approx((0.05, 0.0))


@pytest.mark.slow
def test_a_server_on_fast_dds_executes_goals(tmp_path, monkeypatch):
    """Another implementation of DDS, and the default one of ROS 2."""
    program = tmp_path / "gripper"
    source = Path(__file__).with_name("fast_dds_gripper.cpp")
    compiler = [shutil.which("g++") or "false", "-std=c++17", source]
    if subprocess.run([*compiler, "-M"], capture_output=True).returncode:
        pytest.skip("needs g++ and Debian's libfastrtps-dev")
    libraries = ["-lfastrtps", "-lfastcdr"]
    subprocess.run([*compiler, "-o", program, *libraries], check=True)
    monkeypatch.setattr(f"{ACTION}._PATIENCE", PATIENCE)
    action = GripperAction(Ros2Node(DOMAIN, "a test"), "/fast/cmd")
    line = [program, str(DOMAIN), "fast/cmd"]
    with subprocess.Popen(line, stdout=subprocess.PIPE, text=True) as server:
        try:
            for position in (0.04, 0.01):
                action.send(position, 25.0)
                end = time.monotonic() + PATIENCE
                while action.state() not in ENDED:
                    assert time.monotonic() < end
                    time.sleep(0.01)
                assert action.state() == SUCCEEDED
                assert server.stdout is not None
                # The prefix, 16 bytes of an identifier, and two numbers.
                assert server.stdout.readline() == f"36 {position:g} 25\n"
        finally:
            server.kill()


def test_an_action_without_a_server_is_named(monkeypatch):
    monkeypatch.setattr(f"{ACTION}._PATIENCE", 0.2)
    action = GripperAction(Ros2Node(DOMAIN, "a test"), "/missing/cmd")
    with pytest.raises(RemoSplatError, match="/missing/cmd: no action server"):
        action.send(0.0, 10.0)


def test_a_goal_that_is_not_accepted_is_an_error(monkeypatch):
    monkeypatch.setattr(f"{ACTION}._PATIENCE", 3.0)
    node = Ros2Node(DOMAIN, "a test")
    server = GripperServer(node, "/deaf/cmd")
    action = GripperAction(node, "/deaf/cmd")
    with pytest.raises(RemoSplatError, match="did not accept the goal"):
        action.send(0.01, 10.0)
    (command,) = server.commands()
    assert (command.position, command.max_effort) == (0.01, 10.0)


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
