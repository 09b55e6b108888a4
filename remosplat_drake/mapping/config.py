"""`MappingConfig`: what is mapped while the robot moves, and how."""

import dataclasses as dc

import numpy as np

from remosplat_drake.errors import FieldError, unknown_name
from remosplat_drake.reconstruction.devices import DEVICES

FREE, OBSTACLE = "free", "obstacle"
UNKNOWN = (FREE, OBSTACLE)
"""What space that no camera has seen may count as."""

MOST_VOXELS = 2e7
"""More would take the mapping process many seconds a map."""


@dc.dataclass
class MappingConfig:
    """The live map of a teleoperated robot."""

    # Whether there is one.
    enabled: bool = True
    # Camera frames of the first scan.
    frames: int = 8
    # What no camera has seen counts as: `free` or `obstacle`.
    unknown: str = FREE
    # Edge of the voxels of seen space [m].
    voxel: float = 0.04
    # The box of W in which is told what was seen; outside nothing was [m].
    volume_lower: list[float] = dc.field(
        default_factory=lambda: [-2.5, -2.5, 0.0]
    )
    volume_upper: list[float] = dc.field(
        default_factory=lambda: [2.5, 2.5, 2.5]
    )
    # Space around the robot that counts as seen wherever it stood for a
    # frame; more than the distance that the controller keeps [m].
    robot_margin: float = 0.05
    # Without any map the robot keeps to the space that is so near to where it
    # stands at the start, which somebody has to have looked at [m].
    start_margin: float = 0.3
    # Where splats are trained: `auto`, `cuda`, `cpu`, or `none` for surfels
    # as they were measured.
    device: str = "cpu"
    # At most as many discs are laid on what the camera measured.
    discs: int = 40_000
    # Measured surfaces that are farther from the camera are left out [m].
    max_depth: float = 3.0
    # At most as many frames; of two from nearly the same pose the older
    # goes, then the oldest.
    max_frames: int = 80
    # In simulations faster than real time a map takes effect exactly so much
    # later; absent: when it is made [s].
    latency: float | None = None


def check_mapping(config: MappingConfig, where: str) -> None:
    """Checks the ranges that types cannot express.

    Raises:
        FieldError: A value is out of range; names the field.
    """

    def require(ok: bool, field: str, problem: str) -> None:
        if not ok:
            raise FieldError(where, f"mapping.{field}", problem)

    for field, valid in (("unknown", UNKNOWN), ("device", DEVICES)):
        name = getattr(config, field)
        require(name in valid, field, unknown_name("choice", name, valid))
    for field in ("frames", "discs", "max_frames"):
        count = getattr(config, field)
        require(count >= 1, field, f"must be at least 1, got {count}")
    for field in ("voxel", "max_depth"):
        value = getattr(config, field)
        require(value > 0, field, f"must be positive, got {value}")
    for field in ("robot_margin", "start_margin"):
        margin = getattr(config, field)
        require(margin >= 0, field, f"must not be negative, got {margin}")
    latency = config.latency
    require(
        latency is None or latency >= 0,
        "latency",
        f"must not be negative, got {latency}",
    )
    for side in ("volume_lower", "volume_upper"):
        values = getattr(config, side)
        require(len(values) == 3, side, f"expected 3 entries, got {values}")
    lower, upper = np.array(config.volume_lower), np.array(config.volume_upper)
    require(
        bool(np.isfinite(upper - lower).all() and (upper > lower).all()),
        "volume_upper",
        f"must exceed volume_lower, got {config.volume_upper}",
    )
    voxels = np.prod((upper - lower) / config.voxel)
    require(
        bool(voxels <= MOST_VOXELS),
        "voxel",
        f"{config.voxel} makes {voxels:.2g} voxels;"
        f" valid: at most {MOST_VOXELS:.2g}",
    )
