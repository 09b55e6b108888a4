"""`RobotDescription`: the YAML file that says which joints are what."""

import dataclasses as dc
from pathlib import Path
from typing import Annotated

from annotated_types import Interval

from remosplat_drake.base import resources
from remosplat_drake.base.errors import FileError, unknown_name
from remosplat_drake.base.ranges import Config, JointPosition
from remosplat_drake.base.strict_yaml import load_strict


@dc.dataclass
class DifferentialBase(Config):
    """A base with two wheels, modelled by three planar joints."""

    # Joints x, y (prismatic) and yaw (revolute), in this order.
    joints: list[str] = dc.field(default_factory=list)
    # The body that drives along its x axis.
    body: str = ""


@dc.dataclass
class Arm(Config):
    """A serial arm of revolute or prismatic joints."""

    # Prefix of the arm's ports at the station.
    name: str = "arm"
    joints: list[str] = dc.field(default_factory=list)
    # The arm's first link, fixed to the base.
    mount: str = ""


@dc.dataclass
class Hand(Config):
    """A parallel gripper of two prismatic fingers."""

    # Prefix of the hand's ports at the station.
    name: str = "hand"
    joints: list[str] = dc.field(default_factory=list)


@dc.dataclass
class RobotDescription(Config):
    """What a robot is made of, and its limits."""

    name: str = ""
    # URDF, SDF or *.dmd.yaml, relative to this file.
    model: str = ""
    # Absent for an arm on a fixed base.
    base: DifferentialBase | None = None
    arm: Arm = dc.field(default_factory=Arm)
    # Absent for an arm without a gripper.
    hand: Hand | None = None
    # Frame E that is driven to the target.
    end_effector_frame: str = ""
    # Symmetric bounds on u = (v, omega, arm rates) [m/s, rad/s].
    velocity_limits: list[Annotated[float, Interval(gt=0, le=100)]] = dc.field(
        default_factory=list
    )
    # Bounds on |du/dt| [m/s^2, rad/s^2].
    acceleration_limits: list[Annotated[float, Interval(gt=0, le=1000)]] = (
        dc.field(default_factory=list)
    )
    # Arm configuration to start from [rad].
    home: list[JointPosition] = dc.field(default_factory=list)
    # Constant positions of further joints, for example the fingers [m].
    locked: dict[str, JointPosition] = dc.field(default_factory=dict)
    # Links that stand on the floor: their spheres do not see it.
    floor_links: list[str] = dc.field(default_factory=list)
    # Named sphere sets, files relative to this one.
    spheres: dict[str, str] = dc.field(default_factory=dict)
    # Table of visual meshes, relative to this file; may be absent.
    visuals: str = ""
    # Path of this file, filled in by the loader.
    source: str = dc.field(default="", metadata={"yaml": False})

    @property
    def model_path(self) -> Path:
        """The model file that `model` names."""
        return resources.resolve(self.model, Path(self.source).parent)


def load_robot_description(name: str | Path) -> RobotDescription:
    """Reads models/NAME/NAME.yaml, or the file at the path `name`.

    Raises:
        RemoSplatError: No such robot, or the file has an unusable field.
    """
    path = resources.models_dir() / str(name) / f"{name}.yaml"
    if Path(name).suffix in (".yaml", ".yml"):
        path = resources.resolve(name)
    elif not path.is_file():
        robots = [
            folder.name
            for folder in resources.models_dir().iterdir()
            if (folder / f"{folder.name}.yaml").is_file()
        ]
        raise FileError(path, unknown_name("robot", str(name), robots))
    description = load_strict(RobotDescription, path)
    description.source = str(path)
    return description
