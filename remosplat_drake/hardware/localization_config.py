"""`LocalizationConfig`: the source of a base's pose, and trust in it."""

import dataclasses as dc
from collections.abc import Iterator
from typing import Annotated

from annotated_types import Interval, Len

from remosplat_drake.base.ranges import Config

FrameName = Annotated[str, Len(1, 100)]
"""Name of a frame in ROS's sense: 1 to 100 characters."""


@dc.dataclass
class LocalizationConfig(Config):
    """A localisation of the base in the map, fused with its odometry.

    Without one, the pose in the base's status is taken to be that in the map.
    """

    # Name of the map's frame; a pose in another one stops the robot.
    map_frame: FrameName = "map"
    # Name of the base's frame.
    base_frame: FrameName = "base_link"
    # Name of the odometry's frame; its pose in the map is as good as the
    # base's.
    odometry_frame: FrameName = "odom"
    # Time without a localisation after which the robot is stopped [s].
    expiry: Annotated[float, Interval(gt=0, le=60)] = 1.0
    # Number of standard deviations by which the base may be off.
    sigmas: Annotated[float, Interval(ge=1, le=6)] = 3.0
    # Least standard deviation of a localised position: what localisers say of
    # themselves is often too good [m].
    least_shift: Annotated[float, Interval(gt=0, le=0.1)] = 0.003
    # Least standard deviation of a localised heading [rad].
    least_turn: Annotated[float, Interval(gt=0, le=0.1)] = 0.002
    # Standard deviation of the position by odometry after a metre [m]; it
    # grows with the root of the way.
    odometry_drift: Annotated[float, Interval(gt=0, le=0.2)] = 0.005
    # Standard deviation of the heading by odometry after a metre, and after a
    # radian [rad]; it grows with the root of either.
    odometry_turn: Annotated[float, Interval(gt=0, le=0.2)] = 0.005
    # Greatest distance by which the base may be off while the robot moves [m].
    max_shift: Annotated[float, Interval(gt=0, le=1)] = 0.1
    # Greatest angle by which it may be off [rad].
    max_turn: Annotated[float, Interval(gt=0, le=1)] = 0.1
    # Greatest speed at which the base's pose is corrected [m/s]; its heading
    # follows at as many rad/s. What is still to be corrected counts as
    # uncertain.
    correction_speed: Annotated[float, Interval(gt=0, le=0.5)] = 0.05

    def check(self) -> Iterator[tuple[str, str]]:
        """Yields an error where one name stands for two frames."""
        names = (self.map_frame, self.base_frame, self.odometry_frame)
        if len(set(names)) < len(names):
            yield "map_frame", f"must differ from the others, got {names}"
