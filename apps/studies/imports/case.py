"""The robots to import, with the correct result of each."""

import dataclasses as dc
from functools import cache
from pathlib import Path
from typing import Annotated

from remosplat_drake.base.errors import FileError
from remosplat_drake.base.ranges import Config, OneOf
from remosplat_drake.base.strict_yaml import load_strict
from remosplat_drake.robot.importing.mobile_base import BASES, FIXED

LIST = Path(__file__).with_name("robots.yaml")
"""The file that names the robots."""

ROOTS = {
    "example_robot_data": "example_robot_data/cmeel.prefix/share/"
    "example-robot-data/robots",
    "rtb_data": "rtb_data/rtbdata",
    "pybullet": "pybullet/pybullet_data",
    "robosuite": "robosuite/robosuite/models/assets",
    "fetch": "fetch",
}
"""Folders of robots by their source, in the folder of all unpacked wheels."""


@dc.dataclass
class Robot(Config):
    """A robot, with the correct result of its import."""

    # Name of the robot in tables.
    name: str = ""
    # Source of its file.
    source: Annotated[str, OneOf(tuple(ROOTS))] = "example_robot_data"
    # Path of the file below the source's folder.
    file: str = ""
    # Links whose frames are moved to targets, one for each arm.
    tools: list[str] = dc.field(default_factory=list)
    # The joints of all arms.
    joints: list[str] = dc.field(default_factory=list)
    # Kind of the robot's base.
    base: Annotated[str, OneOf(BASES)] = FIXED


@dc.dataclass
class Robots(Config):
    """Content of `robots.yaml`."""

    # The robots.
    robots: list[Robot] = dc.field(default_factory=list)


@dc.dataclass(frozen=True)
class Case:
    """One robot to import.

    Attributes:
        key: Name of the robot.
        sources: Folder of the unpacked wheels.
        output: Folder that gets the imported robot.
    """

    key: str
    sources: Path
    output: Path

    @property
    def robot(self) -> Robot:
        """The correct result of its import."""
        return {robot.name: robot for robot in known_robots()}[self.key]

    @property
    def path(self) -> Path:
        """The robot's file."""
        robot = self.robot
        return self.sources / ROOTS[robot.source] / robot.file


@cache
def known_robots() -> tuple[Robot, ...]:
    """Reads the robots of the list."""
    return tuple(load_strict(Robots, LIST).robots)


def check_sources(cases: list[Case]) -> None:
    """Checks that the file of each robot exists.

    Args:
        cases: The robots.

    Raises:
        FileError: One is missing.
    """
    for case in cases:
        if not case.path.is_file():
            raise FileError(
                case.path, f"is missing: unpack the wheel of {case.key} there"
            )
