"""`Scenario`: one experiment as data, and how it is read from YAML.

A scenario file is a mapping of names to scenarios; its first entry is its
default. On the command line a scenario is NAME, FILE or FILE:NAME.
"""

import dataclasses as dc
from collections.abc import Sequence
from pathlib import Path

import numpy as np
from pydrake.math import RigidTransform, RollPitchYaw, RotationMatrix

from remosplat_drake import resources
from remosplat_drake.controller.config import (
    ReactiveControllerConfig,
    check_config,
    gain_set,
)
from remosplat_drake.errors import FieldError, FileError, unknown_name
from remosplat_drake.mapping.config import MappingConfig, check_mapping
from remosplat_drake.oracle.config import (
    DepthRasterization,
    GroundTruth,
    SphereToEllipsoid,
)
from remosplat_drake.safety.config import (
    SupervisorConfig,
    check_supervisor,
)
from remosplat_drake.station.config import (
    DynamicStation,
    KinematicStation,
    WristCameraConfig,
)
from remosplat_drake.station.hardware.config import (
    HardwareConfig,
    check_hardware_config,
)
from remosplat_drake.strict_yaml import entries, load_strict
from remosplat_drake.task.arrival import ArrivalConfig, check_arrival
from remosplat_drake.teleop.config import TeleopConfig, check_teleop

DEFAULT_SCENARIO = "TableReach"
"""What `remosplat run` runs when nothing is named."""


@dc.dataclass
class PoseConfig:
    """A pose; its rotation is given as angles or as a matrix, not both."""

    translation: list[float] = dc.field(default_factory=lambda: [0.0] * 3)
    # Roll, pitch, yaw [deg].
    rpy_deg: list[float] | None = None
    # Rows of the rotation matrix.
    rotation: list[list[float]] | None = None


@dc.dataclass
class CropConfig:
    """A box in W; splats whose centres lie outside are left out [m]."""

    lower: list[float] = dc.field(default_factory=lambda: [-1e3] * 3)
    upper: list[float] = dc.field(default_factory=lambda: [1e3] * 3)


@dc.dataclass
class SceneConfig:
    """What surrounds the robot. Files are relative to the scenario's."""

    # Splat file (.ply, or any that `remosplat convert` reads), in frame G;
    # empty for none.
    splat: str = ""
    # Pose of the splat's frame in the world.
    X_WG: PoseConfig = dc.field(default_factory=PoseConfig)
    crop: CropConfig | None = None
    # True geometry (RMMI JSON) for metrics, contact and !GroundTruth.
    truth: str = ""
    # What the true geometry becomes when somebody changes the scene during a
    # simulated teleoperation (RMMI JSON); empty: it stays.
    truth_later: str = ""
    # Largest over-estimate of a distance by the splat; the quality report
    # beside the splat counts, too, the larger of both. Stopping distances must
    # exceed it [m].
    map_error: float | None = None
    # The robot's floor links do not see the scene below this height [m].
    floor_height: float = 0.03


@dc.dataclass
class RobotConfig:
    """Which robot, and where it starts."""

    # A folder of models/, or a robot description file.
    model: str = "frankie"
    # One of the sphere sets of its description.
    spheres: str = "covering"
    # x, y, yaw [m, m, rad]; absent: where the truth file says, or zeros.
    base_pose: list[float] | None = None
    # Arm configuration [rad]; absent: the description's home.
    arm: list[float] | None = None


@dc.dataclass
class Scenario:
    """One experiment."""

    scene: SceneConfig = dc.field(default_factory=SceneConfig)
    robot: RobotConfig = dc.field(default_factory=RobotConfig)
    # Target poses of the end effector in W, one after the other; absent:
    # where the truth file says.
    targets: list[PoseConfig] = dc.field(default_factory=list)
    arrival: ArrivalConfig = dc.field(default_factory=ArrivalConfig)
    oracle: SphereToEllipsoid | DepthRasterization | GroundTruth = dc.field(
        default_factory=SphereToEllipsoid
    )
    controller: ReactiveControllerConfig = dc.field(
        default_factory=ReactiveControllerConfig
    )
    supervisor: SupervisorConfig = dc.field(default_factory=SupervisorConfig)
    station: KinematicStation | DynamicStation = dc.field(
        default_factory=KinematicStation
    )
    wrist_camera: WristCameraConfig | None = None
    # The real robot, in place of `station` with `remosplat run --hardware`.
    hardware: HardwareConfig = dc.field(default_factory=HardwareConfig)
    # What `remosplat teleop` needs besides: who moves the target and how,
    # and the map that grows meanwhile.
    teleop: TeleopConfig = dc.field(default_factory=TeleopConfig)
    mapping: MappingConfig = dc.field(default_factory=MappingConfig)
    # Time between two control ticks [s].
    control_period: float = 0.01
    # The run is given up after this long [s].
    time_limit: float = 15.0
    # Seed of everything random.
    seed: int = 0
    # File and name it was read from, filled in by the loader.
    source: str = dc.field(default="", metadata={"yaml": False})

    @property
    def folder(self) -> Path:
        """The directory that relative files refer to."""
        return Path(self.source.partition(":")[0]).parent


def LoadScenario(spec: str | None = None, override: str = "") -> Scenario:
    """Reads and checks the scenario that a command line names.

    Args:
        spec: NAME (in the shipped files), FILE (its first entry) or
            FILE:NAME; None means `DEFAULT_SCENARIO`.
        override: YAML laid over it, for example "{time_limit: 5}".

    Raises:
        RemoSplatError: Nothing of that name, or a field is unusable.
    """
    path, name = find_scenario(spec or DEFAULT_SCENARIO)
    # The gain set must be known before the fields laid over it are read.
    draft = load_strict(Scenario, path, name, override)
    where = f"{path}:{name}"
    defaults = Scenario(controller=gain_set(draft.controller.gains, where))
    scenario = load_strict(Scenario, path, name, override, defaults)
    scenario.source = where
    check_scenario(scenario)
    return scenario


def find_scenario(spec: str) -> tuple[Path, str]:
    """File and entry of a scenario's name on the command line."""
    file, _, name = spec.partition(":")
    if Path(file).suffix in (".yaml", ".yml"):
        path = resources.resolve(file)
        names = entries(path)
        if not names:
            raise FileError(path, "holds no scenarios")
        if name and name not in names:
            raise FileError(path, unknown_name("scenario", name, names))
        return path, name or names[0]
    shipped = shipped_scenarios()
    if spec not in shipped:
        raise FileError("scenario", unknown_name("scenario", spec, shipped))
    return shipped[spec], spec


def shipped_scenarios() -> dict[str, Path]:
    """The files of all shipped scenarios, by scenario name."""
    return {
        name: path
        for path in sorted(resources.scenarios_dir().glob("*.yaml"))
        for name in entries(path)
    }


def check_scenario(scenario: Scenario) -> None:
    """Checks the ranges that types cannot express.

    Raises:
        FieldError: A value is out of range; names the field.
    """
    where = scenario.source
    for field in ("control_period", "time_limit"):
        value = getattr(scenario, field)
        if not value > 0:
            raise FieldError(where, field, f"must be positive, got {value}")
    check_config(scenario.controller, where)
    check_supervisor(scenario.supervisor, where)
    check_hardware_config(scenario.hardware, where)
    check_teleop(scenario.teleop, where)
    check_mapping(scenario.mapping, where)
    check_arrival(scenario.arrival, where)
    make_transform(scenario.scene.X_WG, where, "scene.X_WG")
    for i, target in enumerate(scenario.targets):
        make_transform(target, where, f"targets[{i}]")
    if scenario.robot.base_pose is not None:
        _check_length(scenario.robot.base_pose, 3, where, "robot.base_pose")
    if scenario.scene.crop is not None:
        for side in ("lower", "upper"):
            values = getattr(scenario.scene.crop, side)
            _check_length(values, 3, where, f"scene.crop.{side}")


def make_transform(
    config: PoseConfig, where: str, field: str
) -> RigidTransform:
    """The rigid transform that a pose in a scenario stands for.

    Raises:
        FieldError: A list has the wrong length, both rotations are given, or
            the matrix is not a rotation.
    """
    _check_length(config.translation, 3, where, f"{field}.translation")
    if config.rpy_deg is not None and config.rotation is not None:
        raise FieldError(where, field, "give `rpy_deg` or `rotation`, not both")
    R = RotationMatrix()
    if config.rpy_deg is not None:
        _check_length(config.rpy_deg, 3, where, f"{field}.rpy_deg")
        R = RotationMatrix(RollPitchYaw(np.radians(config.rpy_deg)))
    if config.rotation is not None:
        R = _make_rotation(config.rotation, where, f"{field}.rotation")
    return RigidTransform(R, config.translation)


def _make_rotation(
    rows: list[list[float]], where: str, field: str
) -> RotationMatrix:
    _check_length(rows, 3, where, field)
    for i, row in enumerate(rows):
        _check_length(row, 3, where, f"{field}[{i}]")
    matrix = np.array(rows)
    deviation = np.abs(matrix @ matrix.T - np.eye(3)).max()
    if deviation > 1e-3 or np.linalg.det(matrix) < 0:
        raise FieldError(
            where,
            field,
            "is not a rotation matrix (rows must be orthonormal"
            " and right-handed)",
        )
    return RotationMatrix.ProjectToRotationMatrix(matrix)


def _check_length(values: Sequence, n: int, where: str, field: str) -> None:
    if len(values) != n:
        raise FieldError(
            where, field, f"expected {n} entries, got {len(values)}"
        )
