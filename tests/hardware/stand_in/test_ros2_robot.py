"""Faults of a stand-in on ROS 2 begin by messages."""

import time

import pytest
from patience import PATIENCE
from pydrake.lcm import DrakeLcm

from remosplat_drake.hardware.driver_config import Ros2Arm
from remosplat_drake.hardware.drivers.ros2_node import Ros2Node
from remosplat_drake.hardware.hardware_config import HardwareConfig
from remosplat_drake.hardware.stand_in.faults import CHANNEL, requested_faults
from remosplat_drake.hardware.stand_in.ros2_robot import (
    FAULTS_TOPIC,
    Ros2Robot,
)
from remosplat_drake.robot.robot_description import load_robot_description

pytest.importorskip("cyclonedds", reason="needs the extra ros2")

from remosplat_drake.hardware.drivers import ros2_messages as ros

DOMAIN = 91


def test_a_fault_begins_by_its_name_and_nonsense_is_told():
    wire, packets, news = DrakeLcm("memq://"), [], []
    wire.Subscribe(CHANNEL, packets.append)
    config = HardwareConfig(arm_driver=Ros2Arm(domain=DOMAIN))
    ur5e = load_robot_description("ur5e")
    robot = Ros2Robot(wire, config, ur5e, news.append)
    writer = Ros2Node(DOMAIN, "a test").writer(FAULTS_TOPIC, ros.String)
    end = time.monotonic() + PATIENCE

    def send(text: str, done) -> None:
        while not done():
            assert time.monotonic() < end
            writer.write(ros.String(text))
            robot.step()
            wire.HandleSubscriptions(0)

    send("status-delay=0.2", lambda: packets)
    (fault,) = requested_faults(packets[0])
    assert (fault.name, fault.value) == ("status-delay", 0.2)
    send("user-stopp", lambda: news)
    assert "unknown fault 'user-stopp'" in news[0]
    assert news[0].startswith(f"{FAULTS_TOPIC}: ")
