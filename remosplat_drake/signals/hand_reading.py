"""`HandReading`: a gripper's measured width and force."""

import dataclasses as dc
import math

import numpy as np

STILL = 0.002
"""If the width changes at less than this rate, the fingers are at rest
[m/s]."""

SLIP = 0.005
"""A gripper still holds its object if its width has changed by at most this
length [m]."""


@dc.dataclass(frozen=True)
class HandReading:
    """Measured width, rate and force of a gripper.

    Attributes:
        width: Opening between the fingers [m]; NaN if it is not known.
        rate: Rate of the opening [m/s]; negative while the fingers close.
        force: Force with which each finger presses [N]. Grippers that do not
            measure it report the commanded force while they hold an object.
    """

    width: float
    rate: float
    force: float

    @staticmethod
    def of(values: np.ndarray) -> "HandReading":
        """Makes a reading of a port's value, shape (3,) [m, m/s, N]."""
        return HandReading(*map(float, values))

    @property
    def is_known(self) -> bool:
        """Whether the width is known."""
        return math.isfinite(self.width)

    @property
    def at_rest(self) -> bool:
        """Whether the fingers do not move."""
        return abs(self.rate) < STILL

    def is_narrower(self, held: float) -> bool:
        """Returns whether the fingers are too close to hold the object.

        Only the width is used, since many grippers measure no force.

        Args:
            held: Width of the gripper when it holds the object [m].
        """
        return self.width < held - SLIP

    def has_let_go(self, held: float) -> bool:
        """Returns whether the gripper has lost the object that it held.

        Args:
            held: Width of the gripper when it grasped the object [m].
        """
        return self.is_narrower(held) or self.width > held + SLIP
