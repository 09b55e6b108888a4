"""`Scenario`: the settings of one experiment, and their YAML reader.

A scenario file is a YAML mapping of names to scenarios; the first entry is the
default of the file. On the command line a scenario is NAME, FILE or FILE:NAME.
"""

import dataclasses as dc
from collections.abc import Iterator
from pathlib import Path
from typing import Annotated

from annotated_types import Interval, Len
from pydrake.systems.analysis import SimulatorConfig
from pydrake.systems.sensors import CameraConfig

from remosplat_drake.app.object_config import ObjectConfig
from remosplat_drake.app.other_robot_config import OtherRobot
from remosplat_drake.app.recorded_movers import RecordedMovers
from remosplat_drake.app.scene_config import SceneConfig
from remosplat_drake.app.target_config import TargetConfig
from remosplat_drake.base import resources
from remosplat_drake.base.errors import (
    FieldError,
    FileError,
    RemoSplatError,
    unknown_name,
)
from remosplat_drake.base.ranges import (
    Config,
    JointPosition,
    OneOf,
    Position,
    Seed,
    check_ranges,
    joined,
)
from remosplat_drake.base.reading import reads_file
from remosplat_drake.base.strict_yaml import entries, load_strict
from remosplat_drake.camera.drake_camera import (
    camera_problems,
    make_wrist_camera,
)
from remosplat_drake.camera.wrist_camera_config import WristCameraConfig
from remosplat_drake.controller.controller_config import (
    ReactiveControllerConfig,
)
from remosplat_drake.controller.tick.reactive_law import LONGEST_VERIFIED
from remosplat_drake.detection.detection_camera_config import (
    DetectionCameraConfig,
)
from remosplat_drake.detection.detection_config import DetectionConfig
from remosplat_drake.hardware.hardware_config import HardwareConfig
from remosplat_drake.mapping.mapping_config import MappingConfig
from remosplat_drake.oracle.oracle_config import (
    DepthRasterization,
    GroundTruth,
    OracleMaker,
    SphereToEllipsoid,
)
from remosplat_drake.safety.supervisor_config import SupervisorConfig
from remosplat_drake.scene.mover import MOST
from remosplat_drake.scene.moving.door import SwingingDoor
from remosplat_drake.scene.moving.mover_track import MoverConfig
from remosplat_drake.scene.moving.person import Person
from remosplat_drake.station.mover_sensing import (
    KnownMovers,
    MoverSensing,
    StandingMovers,
    UnknownMovers,
)
from remosplat_drake.station.station_config import (
    DynamicStation,
    KinematicStation,
    StationMaker,
    simulator_problems,
)
from remosplat_drake.task.arrival import ArrivalConfig
from remosplat_drake.task.step_configs import AnyStep
from remosplat_drake.task.targets import TargetsMaker
from remosplat_drake.teleop.teleop_config import TeleopConfig

YAML_SUFFIXES = (".yaml", ".yml")

LONGEST_RUN = 1e9
"""The time limit of a run may be at most this [s], which is several decades."""

_SPECS = "a NAME that `remosplat scenarios` lists, FILE.yaml or FILE.yaml:NAME"

DEFAULT_SCENARIO = "TableReach"
"""The scenario that `remosplat run` uses without a name."""


TRUTH, CAMERAS = "truth", "cameras"
MOVERS_FROM = (TRUTH, CAMERAS)
"""Choices of `movers_from`, the source of a simulated robot's movers."""

MOST_CAMERAS = 8
"""At most this many cameras may detect movers."""


@dc.dataclass
class RobotConfig(Config):
    """The robot and its start configuration."""

    # Name of a shipped robot (a folder of models/), or a robot description
    # file, relative to the scenario's file.
    model: str = "frankie"
    # Name of one of the sets of collision spheres in the robot's description.
    spheres: str = "covering"
    # Start pose x, y, yaw of the base in W [m, m, rad]; absent: the pose in the
    # truth file, or zeros.
    base_pose: Position | None = None
    # Start positions of the arm's joints [rad]; absent: the home posture of the
    # robot's description.
    arm: list[JointPosition] | None = None


@dc.dataclass
class Scenario(Config):
    """One experiment: robot, scene, targets, controller and run settings.

    Example:
        >>> import remosplat_drake as rs
        >>> scenario = rs.Scenario()
        >>> scenario.control_period
        0.01
        >>> rs.Scenario(control_period=-1.0)
        Traceback (most recent call last):
        ...
        remosplat_drake.base.errors.FieldError: Scenario: control_period: ...
    """

    scene: SceneConfig = dc.field(default_factory=SceneConfig)
    robot: RobotConfig = dc.field(default_factory=RobotConfig)
    # Targets of the end effectors in W, in their order. Absent: the target of
    # the truth file. Your own class that outputs targets is possible, too, as
    # for `oracle`.
    targets: Annotated[list[TargetConfig], Len(0, 10_000)] | TargetsMaker = (
        dc.field(default_factory=list)
    )
    # Tasks with objects, such as picking and placing, that the robot executes
    # instead of `targets`.
    tasks: Annotated[list[AnyStep], Len(0, 1000)] = dc.field(
        default_factory=list
    )
    # The objects of the scene that a task may name.
    objects: Annotated[list[ObjectConfig], Len(0, 1000)] = dc.field(
        default_factory=list
    )
    arrival: ArrivalConfig = dc.field(default_factory=ArrivalConfig)
    # Movers of a simulation, which are moving obstacles that the splat does not
    # contain: rounded boxes, `!Person`, `!SwingingDoor`, `!RecordedMovers`,
    # `!OtherRobot`.
    movers: Annotated[
        list[MoverConfig | Person | SwingingDoor | RecordedMovers | OtherRobot],
        Len(0, MOST),
    ] = dc.field(default_factory=list)
    # Simulated perception of movers without cameras: one of the package's
    # classes, or your own class, as for `oracle`.
    mover_sensing: (
        KnownMovers | StandingMovers | UnknownMovers | MoverSensing
    ) = dc.field(default_factory=KnownMovers)
    # Depth cameras that detect movers. They are fixed in the room or to the
    # robot.
    cameras: Annotated[list[DetectionCameraConfig], Len(0, MOST_CAMERAS)] = (
        dc.field(default_factory=list)
    )
    # Settings of the detection of movers with `cameras`.
    detection: DetectionConfig = dc.field(default_factory=DetectionConfig)
    # Source of the movers that a simulated robot avoids: the `truth`, or the
    # detections of its simulated `cameras`.
    movers_from: Annotated[str, OneOf(MOVERS_FROM)] = TRUTH
    # The oracle, which measures distances to the map: one of the package's
    # oracles, or your own class as `!package.module:Class {field: value}`.
    oracle: (
        SphereToEllipsoid | DepthRasterization | GroundTruth | OracleMaker
    ) = dc.field(default_factory=SphereToEllipsoid)
    controller: ReactiveControllerConfig = dc.field(
        default_factory=ReactiveControllerConfig
    )
    supervisor: SupervisorConfig = dc.field(default_factory=SupervisorConfig)
    # The station, which simulates the robot: one of the package's stations, or
    # your own class, as for `oracle`.
    station: KinematicStation | DynamicStation | StationMaker = dc.field(
        default_factory=KinematicStation
    )
    # Drake's settings of the simulation. A rate on the command line overrides
    # `target_realtime_rate`. Absent: fixed time steps, with which
    # !KinematicStation is exact.
    simulator: SimulatorConfig | None = None
    # The camera on the wrist. It has this package's settings, or Drake's as
    # `!CameraConfig {X_PB: {base_frame: wrist_camera}}`. Absent: no camera.
    wrist_camera: WristCameraConfig | CameraConfig | None = None
    # The real robot, which replaces `station` with `remosplat run --hardware`.
    hardware: HardwareConfig = dc.field(default_factory=HardwareConfig)
    # Settings of `remosplat teleop`: the inputs that move the target, and
    # limits of the target's motion.
    teleop: TeleopConfig = dc.field(default_factory=TeleopConfig)
    mapping: MappingConfig = dc.field(default_factory=MappingConfig)
    # Control period, the time between two ticks [s].
    control_period: Annotated[float, Interval(ge=0.001, le=1)] = 0.01
    # Time after which the run fails [s].
    time_limit: Annotated[float, Interval(gt=0, le=LONGEST_RUN)] = 15.0
    # Seed of all random numbers.
    seed: Seed = 0
    # Folder of your own modules that this file names. Python searches it after
    # installed packages. Empty: the folder of this file.
    modules: str = ""
    # File and name that the scenario was read from, filled in by the loader.
    source: str = dc.field(default="", metadata={"yaml": False})

    MODULES = "modules"

    @property
    def folder(self) -> Path:
        """The folder that relative file names refer to."""
        file, _ = split_spec(self.source) or ("", "")
        return Path(file).parent

    @property
    def name(self) -> str:
        """Name of the scenario's entry in its file; empty without a file."""
        _, name = split_spec(self.source) or ("", "")
        return name

    @property
    def own_stopping(self) -> dict[str, float]:
        """Stopping distances of links from touched objects, by field [m]."""
        return {
            f"tasks[{i}].touch[{j}].stopping": touch.stopping
            for i, step in enumerate(self.tasks)
            for j, touch in enumerate(step.touch)
            if touch.stopping is not None
        }

    @property
    def camera(self) -> WristCameraConfig | None:
        """The wrist camera's settings; Drake's settings are converted.

        None if there is no wrist camera.
        """
        if isinstance(self.wrist_camera, CameraConfig):
            return make_wrist_camera(self.wrist_camera)
        return self.wrist_camera

    def detection_camera(self, name: str) -> DetectionCameraConfig:
        """Returns one of the cameras that detect movers.

        Args:
            name: The camera's name.

        Raises:
            FieldError: There is no such camera.
        """
        for camera in self.cameras:
            if camera.name == name:
                return camera
        names = [camera.name for camera in self.cameras]
        problem = unknown_name("camera", name, names)
        raise FieldError(self.source, "cameras", problem)

    def check(self) -> Iterator[tuple[str, str]]:
        """Checks Drake's structs, cameras, control period and last targets.

        This package must support Drake's camera and simulator settings. With
        verification, the control period must not be longer than
        `LONGEST_VERIFIED`. An end effector must hold its last target, not pass
        it.

        Yields:
            The name of a field and its problem.
        """
        if isinstance(self.wrist_camera, CameraConfig):
            for name, problem in camera_problems(self.wrist_camera):
                yield f"wrist_camera.{name}", problem
        if self.simulator is not None:
            for name, problem in simulator_problems(self.simulator):
                yield joined("simulator", name), problem
        for field in ("name", "channel_name"):
            values = [getattr(camera, field) for camera in self.cameras]
            for i, value in enumerate(values):
                if value in values[:i]:
                    where = f"cameras[{i}].{field.removesuffix('_name')}"
                    yield (
                        where,
                        (
                            "must be unique, but another camera has "
                            f"{value!r}, too"
                        ),
                    )
        if self.movers_from == CAMERAS and not self.cameras:
            yield (
                "movers_from",
                ("is `cameras`, but the list `cameras` is empty; add a camera"),
            )
        if self.controller.verify and self.control_period > LONGEST_VERIFIED:
            yield (
                "control_period",
                f"must be at most {LONGEST_VERIFIED} with controller.verify,"
                f" got {self.control_period}",
            )
        if self.tasks and self.targets:
            yield "tasks", "give `tasks` or `targets`, not both"
        listed = self.targets if isinstance(self.targets, list) else []
        last = {target.effector: i for i, target in enumerate(listed)}
        for i in last.values():
            if listed[i].pass_within is not None:
                yield (
                    f"targets[{i}].pass_within",
                    "must be absent at the last target, which is held and "
                    "not passed",
                )


@reads_file
def load_scenario(
    spec: str | None = None,
    override: str = "",
    defaults: Scenario | None = None,
) -> Scenario:
    """Reads and checks the scenario that a command line names.

    Args:
        spec: NAME (in the shipped files), FILE (its first entry) or
            FILE:NAME; None means `DEFAULT_SCENARIO`.
        override: YAML of fields that override the scenario's, such as
            "{time_limit: 5}".
        defaults: Values of fields that neither the file nor `override` states;
            None means the defaults of `Scenario`.

    Raises:
        RemoSplatError: There is no scenario of that name, or a field is
            unusable.

    Example:
        >>> import remosplat_drake as rs
        >>> scenario = rs.load_scenario("TableReach", "{time_limit: 5}")
        >>> scenario.time_limit
        5.0
    """
    path, name = find_scenario(spec or DEFAULT_SCENARIO)
    scenario = load_strict(Scenario, path, name, override, defaults)
    scenario.source = f"{path}:{name}"
    check_scenario(scenario)
    return scenario


def find_scenario(spec: str) -> tuple[Path, str]:
    """Finds the file and the entry of a scenario.

    Args:
        spec: NAME, FILE or FILE:NAME, as on the command line.

    Raises:
        RemoSplatError: There is no such file, or no such scenario.
    """
    found = split_spec(spec)
    if found is not None:
        path, name = resources.resolve(found[0]), found[1]
        names = entries(path)
        if not names:
            raise FileError(path, "holds no scenarios")
        if name and name not in names:
            raise FileError(path, unknown_name("scenario", name, names))
        return path, name or names[0]
    shipped = shipped_scenarios()
    if spec in shipped:
        return shipped[spec], spec
    path = Path(spec)
    if path.exists():
        what = "a folder" if path.is_dir() else "no scenario file"
        raise FileError(path, f"is {what}; valid: {_SPECS}")
    if path.suffix or len(path.parts) > 1:
        raise FileError(path, f"no such file; valid: {_SPECS}")
    raise RemoSplatError(unknown_name("scenario", spec, shipped))


def split_spec(spec: str) -> tuple[str, str] | None:
    """Splits FILE:NAME into FILE and NAME; None if no YAML file is named.

    FILE and NAME may contain colons. If several splits are possible, the
    function chooses the split whose FILE exists.

    Args:
        spec: NAME, FILE or FILE:NAME, as on the command line.
    """
    parts = spec.split(":")
    splits = [
        (":".join(parts[:n]), ":".join(parts[n:]))
        for n in range(len(parts), 0, -1)
        if Path(":".join(parts[:n])).suffix in YAML_SUFFIXES
    ]
    existing = (split for split in splits if Path(split[0]).is_file())
    return next(existing, splits[-1] if splits else None)


def shipped_scenarios() -> dict[str, Path]:
    """Returns the files of all shipped scenarios, keyed by scenario name."""
    return {
        name: path
        for path in sorted(resources.scenarios_dir().glob("*.yaml"))
        for name in entries(path)
    }


def check_scenario(scenario: Scenario) -> None:
    """Checks all values of a scenario.

    Args:
        scenario: The scenario, whose fields may have been assigned.

    Raises:
        RemoSplatError: A value is out of range; the text names its field.
    """
    check_ranges(scenario, scenario.source)
