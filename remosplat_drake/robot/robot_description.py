"""`RobotDescription`: the YAML file that describes a robot."""

import dataclasses as dc
import re
from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import Annotated

from annotated_types import Interval, Len

from remosplat_drake.base import resources
from remosplat_drake.base.errors import FieldError, FileError, unknown_name
from remosplat_drake.base.ranges import Config, JointPosition, OneOf, joined
from remosplat_drake.base.strict_yaml import load_strict
from remosplat_drake.robot.actuators import Actuator

DIFFERENTIAL, OMNIDIRECTIONAL = "differential", "omnidirectional"
DRIVES = (DIFFERENTIAL, OMNIDIRECTIONAL)
"""Types of drives: forward and turning, or also sideways."""


@dc.dataclass
class MobileBase(Config):
    """A mobile base, modelled by three planar joints."""

    # Type of drive: `differential`, commanded by forward speed and yaw rate, or
    # `omnidirectional`, commanded by speeds forward and to the left and yaw
    # rate.
    drive: Annotated[str, OneOf(DRIVES)] = DIFFERENTIAL
    # Names of the joints x, y (prismatic) and yaw (revolute), in this order.
    joints: list[str] = dc.field(default_factory=list)
    # Name of the base's body, whose x axis is forward.
    body: str = ""


@dc.dataclass
class Arm(Config):
    """A serial arm of revolute or prismatic joints."""

    # Prefix of the names of the arm's ports at the station.
    name: str = "arm"
    # Names of the arm's joints, from the base to the end effector.
    joints: list[str] = dc.field(default_factory=list)
    # Name of the arm's first link, which is fixed to the base.
    mount: str = ""


@dc.dataclass
class Hand(Config):
    """A parallel gripper of two prismatic fingers."""

    # Prefix of the names of the hand's ports at the station.
    name: str = "hand"
    # Names of the two finger joints.
    joints: list[str] = dc.field(default_factory=list)


@dc.dataclass
class RobotDescription(Config):
    """The parts of a robot, its limits and its files; see models/frankie."""

    # Name of the robot, for messages and files.
    name: str = ""
    # URDF, SDF or *.dmd.yaml file of the robot, relative to this file.
    model: str = ""
    # The mobile base; absent for an arm that is fixed to the world.
    base: MobileBase | None = None
    # The arm.
    arm: Arm = dc.field(default_factory=Arm)
    # The gripper; absent for an arm without a gripper.
    hand: Hand | None = None
    # The grippers of several end effectors, keyed by the end effectors' names,
    # in place of `hand`; each gripper has its own name.
    hands: dict[str, Hand] = dc.field(default_factory=dict)
    # Name of the frame E that the controller drives to the target.
    end_effector_frame: str = ""
    # Frames of several end effectors by their names, in place of
    # `end_effector_frame`: {left: left_tool, right: right_tool}. `arm` then
    # lists the joints of all arms, each after the joints that carry it.
    end_effectors: dict[str, str] = dc.field(default_factory=dict)
    # Symmetric bounds on the command u: the base's speeds in the order of
    # `base.drive`, if there is a base, then the arm's joint rates [m/s, rad/s].
    velocity_limits: list[Annotated[float, Interval(gt=0, le=100)]] = dc.field(
        default_factory=list
    )
    # Bounds on the absolute rate of change of the command u [m/s^2, rad/s^2].
    acceleration_limits: list[Annotated[float, Interval(gt=0, le=1000)]] = (
        dc.field(default_factory=list)
    )
    # Bounds on the arm's jerk, the absolute rate of change of du/dt, for
    # reports; empty if unknown [rad/s^3, m/s^3].
    jerk_limits: list[Annotated[float, Interval(gt=0, le=1e6)]] = dc.field(
        default_factory=list
    )
    # Model of each axis' response to its velocity command, in the order of u;
    # empty if not measured. `remosplat identify` writes it.
    actuators: list[Actuator] = dc.field(default_factory=list)
    # Arm configuration to start from [rad, m for prismatic joints].
    home: list[JointPosition] = dc.field(default_factory=list)
    # Constant positions of joints that the controller does not move, by name,
    # such as the fingers [rad, m for prismatic joints].
    locked: dict[str, JointPosition] = dc.field(default_factory=dict)
    # Names of links that stand on the floor: their spheres ignore it.
    floor_links: list[str] = dc.field(default_factory=list)
    # Pairs of links that may touch or overlap: their distances are not checked.
    # Pairs with fewer than two moving joints between them are never checked.
    allowed_collisions: list[Annotated[list[str], Len(2, 2)]] = dc.field(
        default_factory=list
    )
    # SRDF file, relative to this file, whose disabled collisions are also
    # allowed; empty: no SRDF.
    srdf: str = ""
    # Display names of links, such as elbow or wrist, by the links' names. Other
    # links are displayed with their names.
    link_names: dict[str, str] = dc.field(default_factory=dict)
    # Sphere sets by name; names of their files are relative to this file.
    spheres: dict[str, str] = dc.field(default_factory=dict)
    # Table of visual meshes, relative to this file; empty: no table.
    visuals: str = ""
    # Path of this file, filled in by the loader.
    source: str = dc.field(default="", metadata={"yaml": False})

    def check(self) -> Iterator[tuple[str, str]]:
        """Checks that end effectors and hands are given in one way.

        Yields:
            The name of a field and what is wrong with it.
        """
        if self.end_effectors and self.end_effector_frame:
            yield (
                "end_effectors",
                "give `end_effectors` or `end_effector_frame`, not both",
            )
        if self.hands and self.hand:
            yield "hands", "give `hand` or `hands`, not both"
        for name in self.hands:
            if name not in self.end_effectors:
                problem = unknown_effector(name, self.effector_frames)
                yield joined("hands", name), problem
        names = [hand.name for hand in self.hands.values()]
        if len(set(names)) < len(names):
            yield "hands", f"each gripper needs its own name, got {names}"

    @property
    def effector_frames(self) -> dict[str, str]:
        """Frames of the end effectors by name; a single one has the name ""."""
        return self.end_effectors or {"": self.end_effector_frame}

    @property
    def effector_hands(self) -> dict[str, Hand]:
        """Grippers, keyed by their end effectors' names, in this order."""
        effectors = self.effector_frames
        if self.hand is not None:
            return {next(iter(effectors)): self.hand}
        return {e: self.hands[e] for e in effectors if e in self.hands}

    @property
    def n_base(self) -> int:
        """Number of the base's commands: 3, 2, or 0 without a base."""
        if self.base is None:
            return 0
        return 3 if self.base.drive == OMNIDIRECTIONAL else 2

    @property
    def model_path(self) -> Path:
        """Path of the model file that `model` names.

        Raises:
            FieldError: There is no such file.
        """
        return self._file("model", self.model)

    @property
    def visuals_path(self) -> Path | None:
        """Path of the table that `visuals` names; None if it names none.

        Raises:
            FieldError: There is no such file.
        """
        return self._file("visuals", self.visuals) if self.visuals else None

    def spheres_path(self, name: str) -> Path:
        """Returns the path of the file of a sphere set.

        Args:
            name: Name of the sphere set.

        Raises:
            FieldError: There is no such set, or no such file.
        """
        if name not in self.spheres:
            problem = unknown_name("sphere set", name, self.spheres)
            raise FieldError(self.source, "spheres", problem)
        return self._file(joined("spheres", name), self.spheres[name])

    def _file(self, field: str, uri: str) -> Path:
        try:
            return resources.resolve(uri, Path(self.source).parent)
        except FileError as error:
            raise FieldError(self.source, field, str(error)) from error

    def called(self, name: str) -> str:
        """Returns the display name of a link or a joint: elbow, joint 4.

        Args:
            name: Name of the link or joint in the model file.
        """
        if name in self.link_names:
            return self.link_names[name]
        words = name.removeprefix(f"{self.arm.name}_").replace("_", " ")
        return re.sub(r"(?<=[a-z])(?=\d)", " ", words)


def unknown_effector(name: str, effectors: Iterable[str]) -> str:
    """Formats an error about an end effector that a robot does not have.

    Args:
        name: The unknown name.
        effectors: Names of the robot's end effectors; empty for a single end
            effector.
    """
    if any(effectors):
        return unknown_name("end effector", name, effectors)
    return (
        "the robot has one end effector, which has no name; leave this field "
        "out"
    )


def shipped_robots() -> list[str]:
    """Returns the names of the robots that come with the package, sorted."""
    return sorted(
        folder.name
        for folder in resources.models_dir().iterdir()
        if (folder / f"{folder.name}.yaml").is_file()
    )


MODEL_SUFFIXES = (".urdf", ".xacro", ".sdf", ".xml", ".mjcf")
"""Suffixes of robot model files, which are not descriptions."""


def _is_a_model(path: Path) -> str:
    """Returns the error text for a file that is a model, not a description."""
    made = path.name.partition(".")[0]
    return (
        "is a model, not a robot description; run `remosplat import-robot "
        f"{path}`, and name {made}/NAME.yaml in its place"
    )


def load_robot_description(name: str | Path) -> RobotDescription:
    """Reads a robot description.

    Args:
        name: NAME of models/NAME/NAME.yaml, or the path of a file.

    Raises:
        RemoSplatError: There is no such robot, or a field is unusable.
    """
    path = resources.models_dir() / str(name) / f"{name}.yaml"
    if Path(name).suffix.lower() in MODEL_SUFFIXES:
        raise FileError(name, _is_a_model(Path(name)))
    if Path(name).suffix in (".yaml", ".yml"):
        path = resources.resolve(name)
    elif not path.is_file():
        problem = unknown_name("robot", str(name), shipped_robots())
        raise FileError(path, problem)
    description = load_strict(RobotDescription, path)
    description.source = str(path)
    return description
