"""`LocalizationConfig`: settings of a base's localisation."""

import dataclasses as dc
from collections.abc import Iterator
from typing import Annotated

from annotated_types import Interval, Len

from remosplat_drake.base.ranges import Config

FrameName = Annotated[str, Len(1, 100)]
"""Name of a frame, as in ROS: 1 to 100 characters."""


@dc.dataclass
class LocalizationConfig(Config):
    """Settings of a localisation of the base, which is fused with odometry.

    Without a localisation, the pose in the base's status is used as the pose in
    the map.
    """

    # Name of the map's frame. The robot is stopped if a localisation is in
    # another frame.
    map_frame: FrameName = "map"
    # Name of the base's frame.
    base_frame: FrameName = "base_link"
    # Name of the odometry's frame. A localisation may contain the pose of this
    # frame in the map, in place of the base's pose.
    odometry_frame: FrameName = "odom"
    # Time without a localisation after which the robot is stopped [s].
    expiry: Annotated[float, Interval(gt=0, le=60)] = 1.0
    # Number of standard deviations in the bound on the base's pose error.
    sigmas: Annotated[float, Interval(ge=1, le=6)] = 3.0
    # Least standard deviation of a localised position [m], since localisations
    # often report too small covariances.
    least_shift: Annotated[float, Interval(gt=0, le=0.1)] = 0.003
    # Least standard deviation of a localised heading [rad].
    least_turn: Annotated[float, Interval(gt=0, le=0.1)] = 0.002
    # Standard deviation of the position by odometry after one metre [m]; it
    # grows with the square root of the distance.
    odometry_drift: Annotated[float, Interval(gt=0, le=0.2)] = 0.005
    # Standard deviation of the heading by odometry after one metre, and after a
    # turn by one radian [rad]; its square is proportional to the sum of
    # distance and turn.
    odometry_turn: Annotated[float, Interval(gt=0, le=0.2)] = 0.005
    # The robot may move while the bound on the base's position error is at most
    # this [m].
    max_shift: Annotated[float, Interval(gt=0, le=1)] = 0.1
    # The robot may move while the bound on the base's heading error is at most
    # this [rad].
    max_turn: Annotated[float, Interval(gt=0, le=1)] = 0.1
    # Greatest speed at which the base's position is corrected [m/s], and the
    # same number for its heading [rad/s]. The remaining correction is added to
    # the bound on the error.
    correction_speed: Annotated[float, Interval(gt=0, le=0.5)] = 0.05

    def check(self) -> Iterator[tuple[str, str]]:
        """Yields an error if two frames have the same name."""
        names = (self.map_frame, self.base_frame, self.odometry_frame)
        if len(set(names)) < len(names):
            yield "map_frame", f"must differ from the others, got {names}"
