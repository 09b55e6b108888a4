"""`TeleopConfig`: how an operator may move the target."""

import dataclasses as dc
import math

import numpy as np
from pydrake.math import RigidTransform, RollPitchYaw

from remosplat_drake.errors import FieldError, RemoSplatError
from remosplat_drake.station.hardware.config import check_lcm_url


@dc.dataclass
class SavedPose:
    """A pose of the end effector in W that an operator can pick."""

    translation: list[float] = dc.field(default_factory=lambda: [0.0] * 3)
    # Roll, pitch, yaw [deg]; the default points a gripper down.
    rpy_deg: list[float] = dc.field(default_factory=lambda: [180.0, 0.0, 0.0])

    def matrix(self) -> np.ndarray:
        """The pose X_WE, shape (4, 4)."""
        R = RollPitchYaw(np.radians(self.rpy_deg))
        return RigidTransform(R, self.translation).GetAsMatrix4()


@dc.dataclass
class GamepadConfig:
    """A gamepad in the browser, by the standard layout's numbers."""

    # The button without which nothing moves: 5 is the right shoulder.
    dead_man: int = 5
    # Speeds with a stick fully pushed [m/s], [rad/s].
    speed: float = 0.15
    rotation: float = 0.6
    # A stick counts as released so near to its centre.
    dead_zone: float = 0.1
    # The target gets no farther ahead of the end effector, lest it run away
    # from one that an obstacle holds back [m].
    max_lead: float = 0.2


@dc.dataclass
class PoseStreamConfig:
    """Target poses that another program sends by LCM."""

    # Where the messages are: ttl=0 is this machine only.
    lcm_url: str = "udpm://239.255.76.67:7667?ttl=0"
    channel: str = "POSE_TARGET"
    # A stream that is silent for so long is not followed any more [s].
    expiry: float = 0.3


@dc.dataclass
class ScanConfig:
    """Looking around for the first map."""

    # The wrist camera looks so far to either side, in two rows: so far below
    # the horizon [deg].
    pan_deg: float = 60.0
    steep_deg: float = 60.0
    flat_deg: float = 25.0
    # Time at a pose before its frame is taken [s].
    dwell: float = 0.3
    # A robot that has not come to a pose so long after the target has its
    # frame taken where it is [s].
    timeout: float = 2.0


@dc.dataclass
class TeleopConfig:
    """Bounds of the target's motion, and where an operator's wishes come from.

    The page is one of the sources wherever there is one.
    """

    # The target moves no faster [m/s], [rad/s].
    max_speed: float = 0.25
    max_rotation: float = 1.0
    # It gains and loses speed no faster [m/s^2], [rad/s^2].
    max_acceleration: float = 0.5
    max_rotation_acceleration: float = 2.0
    # Box in W in which the target stays [m].
    workspace_lower: list[float] = dc.field(
        default_factory=lambda: [-5.0, -5.0, 0.05]
    )
    workspace_upper: list[float] = dc.field(
        default_factory=lambda: [5.0, 5.0, 2.0]
    )
    # Poses to pick from, by the names on their buttons.
    poses: dict[str, SavedPose] = dc.field(default_factory=dict)
    gamepad: GamepadConfig = dc.field(default_factory=GamepadConfig)
    scan: ScanConfig = dc.field(default_factory=ScanConfig)
    # A file of timed poses and presses, relative to the scenario's: see
    # teleop/trajectory_file.py. Empty for none.
    trajectory: str = ""
    # Poses by LCM; absent: nobody listens.
    pose_stream: PoseStreamConfig | None = None


def check_teleop(config: TeleopConfig, where: str) -> None:
    """Checks the ranges that types cannot express.

    Raises:
        FieldError: A value is out of range; names the field.
    """
    for field in (
        "max_speed",
        "max_rotation",
        "max_acceleration",
        "max_rotation_acceleration",
    ):
        _require_positive(getattr(config, field), where, field)
    _check_workspace(config, where)
    for name, pose in config.poses.items():
        for field in ("translation", "rpy_deg"):
            values = getattr(pose, field)
            _check_vector(values, where, f"poses.{name}.{field}")
        _check_inside(pose, config, where, f"poses.{name}.translation")
    _check_gamepad(config.gamepad, where)
    _check_scan(config.scan, where)
    if config.pose_stream is not None:
        _check_stream(config.pose_stream, where)


def _check_workspace(config: TeleopConfig, where: str) -> None:
    lower, upper = config.workspace_lower, config.workspace_upper
    _check_vector(lower, where, "workspace_lower")
    _check_vector(upper, where, "workspace_upper")
    for axis, low, high in zip("xyz", lower, upper, strict=True):
        if not low < high:
            _fail(
                where,
                "workspace_upper",
                f"must exceed workspace_lower: {axis} of {high} is not"
                f" above {low}",
            )


def _check_inside(
    pose: SavedPose, config: TeleopConfig, where: str, field: str
) -> None:
    bounds = config.workspace_lower, config.workspace_upper
    for x, low, high in zip(pose.translation, *bounds, strict=True):
        if not low <= x <= high:
            _fail(
                where,
                field,
                f"{pose.translation} is outside the workspace from"
                f" {bounds[0]} to {bounds[1]}",
            )


def _check_gamepad(config: GamepadConfig, where: str) -> None:
    _require_positive(config.speed, where, "gamepad.speed")
    _require_positive(config.rotation, where, "gamepad.rotation")
    _require_positive(config.max_lead, where, "gamepad.max_lead")
    if config.dead_man < 0:
        _fail(
            where,
            "gamepad.dead_man",
            f"is the number of a button from 0, got {config.dead_man}",
        )
    if not 0 <= config.dead_zone < 1:
        _fail(
            where,
            "gamepad.dead_zone",
            f"must lie in [0, 1), got {config.dead_zone}",
        )


def _check_scan(config: ScanConfig, where: str) -> None:
    for field in ("pan_deg", "steep_deg", "flat_deg"):
        value = getattr(config, field)
        if not 0 <= value <= 90:
            _fail(where, f"scan.{field}", f"must lie in [0, 90], got {value}")
    if not config.dwell >= 0:
        _fail(where, "scan.dwell", f"must not be negative, got {config.dwell}")
    _require_positive(config.timeout, where, "scan.timeout")


def _check_stream(config: PoseStreamConfig, where: str) -> None:
    try:
        check_lcm_url(config.lcm_url)
    except RemoSplatError as error:
        _fail(where, "pose_stream.lcm_url", str(error))
    if not config.channel:
        _fail(where, "pose_stream.channel", "must not be empty")
    _require_positive(config.expiry, where, "pose_stream.expiry")


def _require_positive(value: float, where: str, field: str) -> None:
    if not (math.isfinite(value) and value > 0):
        _fail(where, field, f"must be positive, got {value}")


def _check_vector(values: list[float], where: str, field: str) -> None:
    if len(values) != 3:
        _fail(where, field, f"expected 3 entries, got {len(values)}")


def _fail(where: str, field: str, problem: str):
    raise FieldError(where, f"teleop.{field}", problem)
