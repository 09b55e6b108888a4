"""`AlignmentSummary`: the section of a quality report on the cameras."""

import dataclasses as dc
from typing import Annotated

import numpy as np
from annotated_types import Interval

from remosplat_drake.base.ranges import Config

_SIZE = Annotated[float, Interval(ge=0, le=1e4)]
_SIGNED = Annotated[float, Interval(ge=-1e6, le=1e6)]
_COUNT = Annotated[int, Interval(ge=0, le=10**12)]

_MOST_DIGITS = 4
"""A value is shown with at most this many decimals."""


@dc.dataclass
class ResidualRow(Config):
    """Residuals of the pairs of views whose baselines are in one range."""

    # Lower limit of the distance between the two cameras of a pair [m].
    nearest: _SIZE = 0.0
    # Upper limit of the distance between the two cameras of a pair [m].
    farthest: _SIZE = 0.0
    # Number of pairs of views.
    pairs: _COUNT = 0
    # Number of points.
    points: _COUNT = 0
    # Median distance of a point from the other view's surface, with the given
    # poses [m].
    median_before: _SIZE = 0.0
    # 95th percentile of these distances [m].
    high_before: _SIZE = 0.0
    # Median of these distances after the refinement [m].
    median_after: _SIZE = 0.0
    # 95th percentile of these distances after the refinement [m].
    high_after: _SIZE = 0.0


@dc.dataclass
class CameraError(Config):
    """An error that all images of a camera share."""

    # Name of the erroneous parameter.
    name: str = ""
    # Size of the error [`unit`]: the correction that was made, or the estimate
    # if none was made.
    value: _SIGNED = 0.0
    # Standard deviation of the size [unit].
    deviation: _SIZE = 0.0
    # Unit of size and deviation; empty for a plain number.
    unit: str = ""
    # Whether the error was corrected in the capture; insignificant errors are
    # not corrected.
    undone: bool = False

    def __str__(self) -> str:
        """Formats value, deviation and unit, such as "3.09 ± 0.01 %"."""
        return (
            f"{self.value:+z.{digits(self.deviation)}f}"
            f" {doubt(self.deviation, self.unit)}"
        )


def doubt(deviation: float, unit: str) -> str:
    """Formats a standard deviation, such as "± 0.02 %"."""
    return f"± {deviation:.{digits(deviation)}f} {unit}".rstrip()


def digits(deviation: float) -> int:
    """Returns the number of significant decimals of a value."""
    if deviation <= 0:
        return _MOST_DIGITS
    return int(np.clip(np.ceil(-np.log10(deviation)), 0, _MOST_DIGITS))


@dc.dataclass
class AlignmentSummary(Config):
    """Results of refining the poses, and errors that all images share."""

    # Whether the refinement was accepted, because held-out pairs of views agree
    # better with it.
    accepted: bool = False
    # Factor by which measured depths were multiplied.
    scale: Annotated[float, Interval(ge=0, le=1e4)] = 1.0
    # Standard deviation of `scale`.
    scale_std: _SIZE = 0.0
    # Length that was added to the depths [m].
    offset: Annotated[float, Interval(ge=-1e4, le=1e4)] = 0.0
    # Standard deviation of `offset` [m].
    offset_std: _SIZE = 0.0
    # Median distance by which the refinement moved a camera [m].
    moved: _SIZE = 0.0
    # Median angle by which the refinement rotated a camera [rad].
    turned: _SIZE = 0.0
    # Median of the standard deviations of the cameras' positions [m].
    position_std: _SIZE = 0.0
    # Number of groups of views; views of different groups share no surface.
    groups: Annotated[int, Interval(ge=0, le=10**9)] = 1
    # Residuals before and after the refinement, by the cameras' distance.
    rows: list[ResidualRow] = dc.field(default_factory=list)
    # Errors that all images share; empty in reports of older versions.
    camera: list[CameraError] = dc.field(default_factory=list)
    # Sentences that describe the corrections and the remaining uncertainty.
    words: str = ""
