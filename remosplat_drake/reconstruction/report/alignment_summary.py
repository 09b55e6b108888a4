"""`AlignmentSummary`: what a quality report says of the cameras."""

import dataclasses as dc
from typing import Annotated

from annotated_types import Interval

from remosplat_drake.base.ranges import Config

_SIZE = Annotated[float, Interval(ge=0, le=1e4)]
_COUNT = Annotated[int, Interval(ge=0, le=10**12)]


@dc.dataclass
class ResidualRow(Config):
    """Residuals of the pairs of views that are about so far apart."""

    # Distance of the views, from [m].
    nearest: _SIZE = 0.0
    # Distance of the views, to [m].
    farthest: _SIZE = 0.0
    # Number of pairs of views.
    pairs: _COUNT = 0
    # Number of points.
    points: _COUNT = 0
    # Median distance of a point from the other view's surface, as captured [m].
    median_before: _SIZE = 0.0
    # Its 95th percentile [m].
    high_before: _SIZE = 0.0
    # Median distance after the refinement [m].
    median_after: _SIZE = 0.0
    # Its 95th percentile [m].
    high_after: _SIZE = 0.0


@dc.dataclass
class AlignmentSummary(Config):
    """How poses, depth scale and offset were refined."""

    # Whether the refinement was kept: only if other views agree better.
    accepted: bool = False
    # Factor by which measured depths were multiplied.
    scale: Annotated[float, Interval(ge=0, le=1e4)] = 1.0
    # Its standard deviation.
    scale_std: _SIZE = 0.0
    # What was added to the depths [m].
    offset: Annotated[float, Interval(ge=-1e4, le=1e4)] = 0.0
    # Its standard deviation [m].
    offset_std: _SIZE = 0.0
    # Median motion of the cameras [m].
    moved: _SIZE = 0.0
    # Median rotation of the cameras [rad].
    turned: _SIZE = 0.0
    # Median standard deviation of a camera's position [m].
    position_std: _SIZE = 0.0
    # Number of groups of views that share no surface.
    groups: Annotated[int, Interval(ge=0, le=10**9)] = 1
    # Residuals before and after, by the distance of the views.
    rows: list[ResidualRow] = dc.field(default_factory=list)
    # What was done and what is not known, in words.
    words: str = ""
