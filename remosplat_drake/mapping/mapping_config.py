"""`MappingConfig`: what is mapped while the robot moves, and how."""

import dataclasses as dc
from collections.abc import Iterator
from typing import Annotated

import numpy as np
from annotated_types import Interval

from remosplat_drake.base.ranges import Config, OneOf, Position
from remosplat_drake.reconstruction.devices import DEVICES

FREE, OBSTACLE = "free", "obstacle"
UNKNOWN = (FREE, OBSTACLE)
"""What space that no camera has seen may count as."""

MOST_VOXELS = 2e7
"""More would take the mapping process many seconds a map."""


@dc.dataclass
class MappingConfig(Config):
    """The live map of a teleoperated robot."""

    # Whether there is one.
    enabled: bool = True
    # Camera frames of the first scan.
    frames: Annotated[int, Interval(ge=1, le=1000)] = 8
    # What no camera has seen counts as: `free` or `obstacle`.
    unknown: Annotated[str, OneOf(UNKNOWN)] = FREE
    # Edge of the voxels of seen space [m].
    voxel: Annotated[float, Interval(gt=0, le=1)] = 0.04
    # The box of W in which is told what was seen; outside nothing was [m].
    volume_lower: Position = dc.field(default_factory=lambda: [-2.5, -2.5, 0.0])
    volume_upper: Position = dc.field(default_factory=lambda: [2.5, 2.5, 2.5])
    # Space around the robot that counts as seen wherever it stood for a
    # frame; more than the distance that the controller keeps [m].
    robot_margin: Annotated[float, Interval(ge=0, le=1)] = 0.05
    # Without any map the robot keeps to the space that is so near to where it
    # stands at the start, which somebody has to have looked at [m].
    start_margin: Annotated[float, Interval(ge=0, le=5)] = 0.3
    # Where splats are trained: `auto`, `cuda`, `cpu`, or `none` for surfels
    # as they were measured.
    device: Annotated[str, OneOf(DEVICES)] = "cpu"
    # At most as many discs are laid on what the camera measured.
    discs: Annotated[int, Interval(ge=1, le=10_000_000)] = 40_000
    # Measured surfaces that are farther from the camera are left out [m].
    max_depth: Annotated[float, Interval(gt=0, le=100)] = 3.0
    # At most as many frames; of two from nearly the same pose the older
    # goes, then the oldest.
    max_frames: Annotated[int, Interval(ge=1, le=10_000)] = 80
    # In simulations faster than real time a map takes effect exactly so much
    # later; absent: when it is made [s].
    latency: Annotated[float, Interval(ge=0, le=60)] | None = None

    def check(self) -> Iterator[tuple[str, str]]:
        """See `Config`."""
        size = np.subtract(self.volume_upper, self.volume_lower)
        if not (size > 0).all():
            yield (
                "volume_upper",
                f"must exceed volume_lower, got {self.volume_upper}",
            )
        voxels = np.prod(size / self.voxel)
        if voxels > MOST_VOXELS:
            yield (
                "voxel",
                f"{self.voxel} makes {voxels:.2g} voxels;"
                f" valid: at most {MOST_VOXELS:.2g}",
            )
