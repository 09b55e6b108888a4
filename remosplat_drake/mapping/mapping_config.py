"""`MappingConfig`: what is mapped while the robot moves, and how."""

import dataclasses as dc
from collections.abc import Iterator
from typing import Annotated

import numpy as np
from annotated_types import Interval

from remosplat_drake.base.ranges import Config, OneOf, Position
from remosplat_drake.reconstruction.devices import DEVICES

MOST_VOXELS = 2e7
"""Greatest number of voxels: more would take many seconds for each map."""


@dc.dataclass
class MappingConfig(Config):
    """The live map of a teleoperated robot, made of its camera's frames."""

    # Whether there is a live map at all.
    enabled: bool = True
    # Number of camera frames of the first scan.
    frames: Annotated[int, Interval(ge=1, le=1000)] = 8
    # Edge length of the voxels in which seen space is kept [m].
    voxel: Annotated[float, Interval(gt=0, le=1)] = 0.04
    # Lower corner, in the world frame W, of the box in which the map keeps
    # what was seen [m]; outside of it nothing counts as seen.
    volume_lower: Position = dc.field(default_factory=lambda: [-2.5, -2.5, 0.0])
    # Upper corner of that box, in W [m].
    volume_upper: Position = dc.field(default_factory=lambda: [2.5, 2.5, 2.5])
    # Distance around the robot within which space counts as seen wherever it
    # stood for a frame [m]; it should exceed the distance that the controller
    # keeps.
    robot_margin: Annotated[float, Interval(ge=0, le=1)] = 0.05
    # Distance around the robot's start within which space counts as free
    # [m]: without any map the robot keeps to it, so that somebody has to have
    # looked there.
    start_margin: Annotated[float, Interval(ge=0, le=5)] = 0.3
    # Device on which splats are trained: `auto`, `cuda`, `cpu`, or `none` for
    # surfels as they were measured.
    device: Annotated[str, OneOf(DEVICES)] = "cpu"
    # Greatest number of discs that are laid on what the camera measured.
    discs: Annotated[int, Interval(ge=1, le=10_000_000)] = 40_000
    # Greatest distance from the camera of surfaces that are mapped [m].
    max_depth: Annotated[float, Interval(gt=0, le=100)] = 3.0
    # Greatest number of frames that a map is made of. Of two from nearly the
    # same pose the older one is left out first, and then the oldest ones.
    max_frames: Annotated[int, Interval(ge=1, le=10_000)] = 80
    # Standard deviation of how far the base's odometry goes wrong in a second
    # [m/s]; 0 with `odometry_turn: 0`: poses are taken as they are measured.
    # Otherwise frames are aligned to each other, and the base to the map.
    odometry_drift: Annotated[float, Interval(ge=0, le=0.1)] = 0.0
    # The same for its heading [rad/s].
    odometry_turn: Annotated[float, Interval(ge=0, le=0.1)] = 0.0
    # Greatest speed at which the base's pose is corrected [m/s]; its heading
    # follows at as many rad/s.
    correction_speed: Annotated[float, Interval(gt=0, le=0.5)] = 0.05
    # Time after which a map takes effect, exactly, in simulations that run
    # faster than real time [s]; absent: as soon as it is made.
    latency: Annotated[float, Interval(ge=0, le=60)] | None = None

    @property
    def corrects_base(self) -> bool:
        """Whether the odometry of a mobile base is corrected by the map."""
        return self.odometry_drift > 0 or self.odometry_turn > 0

    def check(self) -> Iterator[tuple[str, str]]:
        """Yields an error where the box is empty or has too many voxels."""
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
