"""`MappingConfig`: settings of the live map."""

import dataclasses as dc
from collections.abc import Iterator
from typing import Annotated

import numpy as np
from annotated_types import Interval

from remosplat_drake.base.ranges import Config, OneOf, Position
from remosplat_drake.reconstruction.devices import DEVICES

MOST_VOXELS = 2e7
"""The mapped box has at most this many voxels. With more voxels, each map would
take many seconds.
"""


@dc.dataclass
class MappingConfig(Config):
    """Settings of the live map, built from frames of the robot's camera."""

    # Whether there is a live map at all.
    enabled: bool = True
    # Number of camera frames of the first scan.
    frames: Annotated[int, Interval(ge=1, le=1000)] = 8
    # Edge length of the voxels in which seen space is recorded [m].
    voxel: Annotated[float, Interval(gt=0, le=1)] = 0.04
    # Lower corner, in the world frame W, of the box in which seen space is
    # recorded [m]; space outside counts as unseen.
    volume_lower: Position = dc.field(default_factory=lambda: [-2.5, -2.5, 0.0])
    # Upper corner, in W, of the box in which seen space is recorded [m].
    volume_upper: Position = dc.field(default_factory=lambda: [2.5, 2.5, 2.5])
    # Distance around the robot within which space counts as seen when a frame
    # is taken [m]. It should exceed the distance that the controller keeps.
    robot_margin: Annotated[float, Interval(ge=0, le=1)] = 0.05
    # Distance around the robot's initial configuration within which space
    # counts as free [m]. Before the first map, the robot stays in this space,
    # so an operator must check that it is free.
    start_margin: Annotated[float, Interval(ge=0, le=5)] = 0.3
    # Device on which splats are trained: `auto`, `cuda`, `cpu`, or `none` for
    # untrained surfels.
    device: Annotated[str, OneOf(DEVICES)] = "cpu"
    # Largest number of discs on measured surfaces.
    discs: Annotated[int, Interval(ge=1, le=10_000_000)] = 40_000
    # Largest depth of surfaces that are mapped [m].
    max_depth: Annotated[float, Interval(gt=0, le=100)] = 3.0
    # Largest number of frames of a map. Older frames from nearly the same poses
    # are removed first, then the oldest frames.
    max_frames: Annotated[int, Interval(ge=1, le=10_000)] = 80
    # Standard deviation of the rate at which the base's odometry drifts in
    # position [m/s]. If this and `odometry_turn` are 0, measured poses are used
    # unchanged. Otherwise, frames are aligned to each other, and the base is
    # localised in the map.
    odometry_drift: Annotated[float, Interval(ge=0, le=0.1)] = 0.0
    # Standard deviation of the rate at which the odometry drifts in heading
    # [rad/s].
    odometry_turn: Annotated[float, Interval(ge=0, le=0.1)] = 0.0
    # Greatest speed at which the base's position is corrected [m/s]; the
    # heading is corrected by at most the same number of rad/s.
    correction_speed: Annotated[float, Interval(gt=0, le=0.5)] = 0.05
    # Fixed time after which a map takes effect, for simulations that run faster
    # than real time [s]. If absent, a map takes effect as soon as it is built.
    latency: Annotated[float, Interval(ge=0, le=60)] | None = None

    @property
    def corrects_base(self) -> bool:
        """Whether the map corrects the odometry of a mobile base."""
        return self.odometry_drift > 0 or self.odometry_turn > 0

    def check(self) -> Iterator[tuple[str, str]]:
        """Yields an error if the box is empty or has too many voxels."""
        size = np.subtract(self.volume_upper, self.volume_lower)
        if not (size > 0).all():
            yield (
                "volume_upper",
                "must exceed volume_lower in each axis, got "
                f"{self.volume_upper}",
            )
        voxels = np.prod(size / self.voxel)
        if voxels > MOST_VOXELS:
            yield (
                "voxel",
                f"{self.voxel} makes {voxels:.2g} voxels;"
                f" valid: at most {MOST_VOXELS:.2g}",
            )
