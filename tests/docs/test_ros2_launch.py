"""The launch files of the guide, and the drivers that they start."""

import re
import shlex
import xml.etree.ElementTree as ElementTree
from pathlib import Path

import pytest

from apps.studies.imports.case import LIST, Robots
from remosplat_drake.app.scenario import load_scenario
from remosplat_drake.base.strict_yaml import load_strict
from remosplat_drake.commands.command_parser import CommandParser
from remosplat_drake.hardware.driver_config import Ros2Arm, Ros2Base, Ros2Hand
from remosplat_drake.robot.robot_description import (
    Arm,
    MobileBase,
    RobotDescription,
    load_robot_description,
)

pytest.importorskip("cyclonedds", reason="needs the extra ros2")

GUIDE = Path(__file__).parents[2] / "docs/guides/ros2_launch.md"
DOMAIN, LONGEST = 90, 30

SECTIONS = re.findall(
    r"^## (\w+).*?```yaml\n(.*?)```.*?```xml\n(.*?)```",
    GUIDE.read_text(),
    re.M | re.S,
)


def description_of(name: str) -> RobotDescription:
    """The robot of a section; a TIAGo by the joints that a study imports."""
    if name != "TIAGo":
        shipped = {"Universal": "ur5e", "Fetch": "fetch"}[name]
        return load_robot_description(shipped)
    robots = load_strict(Robots, LIST).robots
    (joints,) = [robot.joints for robot in robots if robot.name == "tiago"]
    n = 2 + len(joints)
    return RobotDescription(
        name="tiago",
        base=MobileBase(),
        arm=Arm(joints=joints),
        velocity_limits=[1.0] * n,
        acceleration_limits=[1.0] * n,
    )


def test_there_is_a_section_for_each_robot():
    names = [name for name, _, _ in SECTIONS]
    assert names == ["Universal", "TIAGo", "Fetch"]


@pytest.mark.parametrize(
    ("name", "text", "launch"), SECTIONS, ids=[x[0] for x in SECTIONS]
)
def test_a_launch_file_starts_the_drivers_of_its_yaml(
    name, text, launch, monkeypatch
):
    monkeypatch.setenv("ROS_DOMAIN_ID", str(DOMAIN))
    assert len(text.splitlines()) <= LONGEST
    hardware = load_scenario("TableReach", text).hardware
    description, news = description_of(name), []
    drivers = set()
    assert isinstance(hardware.arm_driver, Ros2Arm)
    arm = hardware.arm_driver.connect_arm(description, news.append)
    assert arm.fetch() is None
    drivers.add("arm-driver")
    if hardware.base_driver is not None:
        assert isinstance(hardware.base_driver, Ros2Base)
        base = hardware.base_driver.connect_base(news.append)
        assert base.fetch() == []
        drivers.add("base-driver")
    if hardware.hand_driver is not None:
        assert isinstance(hardware.hand_driver, Ros2Hand)
        hand = hardware.hand_driver.connect_hand(description, news.append)
        assert hand.measure() is None
        drivers.add("hand-driver")
    assert hardware.arm_driver.stops, "driver-check fails without"
    started = set()
    for executable in ElementTree.fromstring(launch).iter("executable"):
        program, command, *arguments = shlex.split(executable.get("cmd", ""))
        assert program == "remosplat"
        CommandParser(command).parse_args(arguments)
        started.add(command)
    assert started == drivers
