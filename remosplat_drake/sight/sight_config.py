"""`SightConfig`: what counts as new before a camera, and how it may move."""

import dataclasses as dc
from collections.abc import Iterator
from typing import Annotated

import numpy as np
from annotated_types import Interval

from remosplat_drake.base.ranges import Config, Position


@dc.dataclass
class SightConfig(Config):
    """How cameras tell things that move from the scene that they know.

    Errors of depth grow with its square, as triangulation has it; the defaults
    are those of an Intel RealSense D435.
    """

    # Lower corner of the box in W in which something may move [m].
    lower: Position = dc.field(default_factory=lambda: [-3.0, -3.0, -0.2])
    # Upper corner of that box [m].
    upper: Position = dc.field(default_factory=lambda: [4.0, 3.0, 2.4])
    # Height in W up to which there is only floor [m].
    floor_height: Annotated[float, Interval(ge=-100, le=1)] = 0.03
    # Pixels in a row of an image that are looked at; of wider images every
    # second, third, ... counts.
    columns: Annotated[int, Interval(ge=16, le=1280)] = 160
    # Depths beyond this are not trusted [m].
    range: Annotated[float, Interval(gt=0, le=20)] = 4.0
    # Standard deviation of a depth at the camera itself [m].
    depth_error: Annotated[float, Interval(ge=0, le=0.1)] = 0.002
    # Growth of that standard deviation with the squared depth [1/m].
    depth_growth: Annotated[float, Interval(ge=0, le=0.1)] = 0.0038
    # Standard deviations that a measurement may be off.
    sigmas: Annotated[float, Interval(ge=1, le=10)] = 3.0
    # How far what a camera sees may be misplaced by its own pose [m].
    pose_error: Annotated[float, Interval(ge=0, le=0.2)] = 0.01
    # How far from the robot's spheres what is seen is still the robot [m].
    robot_margin: Annotated[float, Interval(ge=0, le=0.5)] = 0.04
    # Distance at which two points may still belong to one thing [m].
    link: Annotated[float, Interval(ge=0.02, le=1)] = 0.12
    # Fewest points of a thing, in one image.
    least_points: Annotated[int, Interval(ge=1, le=1000)] = 5
    # How deep a thing may be behind its seen face, where no other camera looks
    # [m].
    thickness: Annotated[float, Interval(ge=0, le=2)] = 0.3
    # What is seen never moves faster [m/s].
    max_speed: Annotated[float, Interval(ge=0.1, le=20)] = 2.0
    # What is seen never accelerates more [m/s^2].
    max_acceleration: Annotated[float, Interval(ge=0.1, le=100)] = 5.0
    # How long something is remembered that is hidden from view [s].
    memory: Annotated[float, Interval(ge=0, le=60)] = 2.0
    # Age at which a camera's image tells nothing any more [s].
    expiry: Annotated[float, Interval(gt=0, le=5)] = 0.2
    # Speed at which something may come out of space that no camera sees, 0.2 m
    # thick at least; 0: nothing is hidden there [m/s].
    unseen_speed: Annotated[float, Interval(ge=0, le=20)] = 0.0
    # Time after which what stays where it is should become part of the map [s].
    settle: Annotated[float, Interval(gt=0, le=60)] = 1.5

    def check(self) -> Iterator[tuple[str, str]]:
        """Checks that the box has an inside, and no more than it need have.

        Yields:
            The name of a field and what is wrong with it.
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
        """Returns by how much points at depths z may be misplaced [m]."""
        return self.pose_error + self.sigmas * self.deviation(z)

    def beside(self, error: float) -> float:
        """Returns how far from its spheres something is taken for the robot.

        Args:
            error: By how much it may be misplaced, from `margin` [m]; the
                camera's pose is in the robot's margin already.
        """
        return self.robot_margin + error - self.pose_error
