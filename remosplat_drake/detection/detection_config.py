"""`DetectionConfig`: settings of the detection of moving objects."""

import dataclasses as dc
from collections.abc import Iterator
from typing import Annotated

import numpy as np
from annotated_types import Interval

from remosplat_drake.base.ranges import Config, Position


@dc.dataclass
class DetectionConfig(Config):
    """Settings of the detection of moving objects.

    Errors of depth grow with its square, as for triangulation; the defaults are
    those of an Intel RealSense D435.
    """

    # Lower corner, in W, of the box in which movers are detected [m].
    lower: Position = dc.field(default_factory=lambda: [-3.0, -3.0, -0.2])
    # Upper corner, in W, of the box in which movers are detected [m].
    upper: Position = dc.field(default_factory=lambda: [4.0, 3.0, 2.4])
    # Height in W below which all points belong to the floor [m].
    floor_height: Annotated[float, Interval(ge=-100, le=1)] = 0.03
    # Largest number of examined pixels in an image row. In wider images, the
    # step between examined pixels is larger than 1.
    columns: Annotated[int, Interval(ge=16, le=1280)] = 160
    # Largest depth that is used [m].
    range: Annotated[float, Interval(gt=0, le=20)] = 4.0
    # Standard deviation of a depth at the camera itself [m].
    depth_error: Annotated[float, Interval(ge=0, le=0.1)] = 0.002
    # Growth of the depth's standard deviation with the squared depth [1/m].
    depth_growth: Annotated[float, Interval(ge=0, le=0.1)] = 0.0038
    # Number of standard deviations in the bound of a depth error.
    sigmas: Annotated[float, Interval(ge=1, le=10)] = 3.0
    # Bound on position errors due to a camera's pose [m].
    pose_error: Annotated[float, Interval(ge=0, le=0.2)] = 0.01
    # Distance from the robot's spheres within which points belong to the robot
    # [m].
    robot_margin: Annotated[float, Interval(ge=0, le=0.5)] = 0.04
    # Largest distance between neighbouring points of one object [m].
    link: Annotated[float, Interval(ge=0.02, le=1)] = 0.12
    # Least number of points of an object in one image.
    least_points: Annotated[int, Interval(ge=1, le=1000)] = 5
    # Assumed extent of an object behind its visible face [m], unless another
    # camera shows free space there.
    thickness: Annotated[float, Interval(ge=0, le=2)] = 0.3
    # Speed limit of things [m/s].
    max_speed: Annotated[float, Interval(ge=0.1, le=20)] = 2.0
    # Acceleration limit of things [m/s^2].
    max_acceleration: Annotated[float, Interval(ge=0.1, le=100)] = 5.0
    # Time for which hidden parts of objects are remembered [s].
    memory: Annotated[float, Interval(ge=0, le=60)] = 2.0
    # Age of a camera's image from which it is stale [s].
    expiry: Annotated[float, Interval(gt=0, le=5)] = 0.2
    # Speed of objects, at least 0.2 m thick, that may come out of unseen space
    # [m/s]. With 0, unseen space is assumed empty.
    unseen_speed: Annotated[float, Interval(ge=0, le=20)] = 0.0
    # Time after which an object at rest should become part of the map [s].
    settle: Annotated[float, Interval(gt=0, le=60)] = 1.5

    def check(self) -> Iterator[tuple[str, str]]:
        """Checks the size of the box.

        Yields:
            The name of a field and its problem.
        """
        size = np.subtract(self.upper, self.lower)
        if not (size > 0).all():
            yield "upper", f"must exceed lower {self.lower}, got {self.upper}"
        elif np.prod(size) > 1000:
            yield "upper", "makes the box larger than 1000 cubic metres"

    def deviation(self, z: np.ndarray | float) -> np.ndarray | float:
        """Returns the standard deviation of depths z [m]."""
        return self.depth_error + self.depth_growth * np.square(z)

    def margin(self, z: np.ndarray | float) -> np.ndarray | float:
        """Returns bounds on position errors of points at depths z [m]."""
        return self.pose_error + self.sigmas * self.deviation(z)

    def beside(self, error: float) -> float:
        """Returns the distance from the robot within which points belong to it.

        Args:
            error: Bound on the points' position errors, from `margin` [m]. Its
                part for the camera's pose is subtracted, since the robot's
                margin contains it.
        """
        return self.robot_margin + error - self.pose_error
