"""`RestConfig`: conditions of rest for a robot at a reached target."""

import dataclasses as dc
import math
from typing import Annotated

import numpy as np
from annotated_types import Interval

from remosplat_drake.base.ranges import Config


@dc.dataclass
class RestConfig(Config):
    """Conditions under which a robot rests at a reached target."""

    # Whether the robot rests. If not, the costs of manipulability, base
    # orientation and active collision continue to move a redundant robot.
    enabled: bool = True
    # Time for which the error must not decrease before the robot rests [s].
    settling_time: Annotated[float, Interval(gt=0, le=60)] = 1.0
    # Increase of the distance to the target that ends the rest [m].
    position_band: Annotated[float, Interval(gt=0, le=0.1)] = 0.002
    # Increase of the angle to the target that ends the rest [deg].
    angle_band: Annotated[float, Interval(gt=0, le=10)] = 0.2

    @property
    def bands(self) -> np.ndarray:
        """The dead bands of distance [m] and angle [rad], shape (2,)."""
        return np.array([self.position_band, math.radians(self.angle_band)])
