"""The launch files of the guide, and the drivers that they start."""

import pytest
from ros2_guide import SECTIONS

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

DOMAIN, LONGEST = 90, 30


def description_of(name: str) -> RobotDescription:
    """The robot of a section; a TIAGo by the joints that a study imports."""
    if name != "TIAGo":
        return load_robot_description("fetch" if name == "Fetch" else "ur5e")
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
    assert list(SECTIONS) == ["Universal", "TIAGo", "Fetch", "UR5e"]


@pytest.mark.parametrize("name", SECTIONS)
def test_a_launch_file_starts_the_drivers_of_its_yaml(name, monkeypatch):
    monkeypatch.setenv("ROS_DOMAIN_ID", str(DOMAIN))
    text = SECTIONS[name].hardware
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
    for program, command, *arguments in SECTIONS[name].commands:
        assert program == "remosplat"
        CommandParser(command).parse_args(arguments)
        started.add(command)
    assert started == drivers
