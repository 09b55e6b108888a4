"""Corrects captures whose images are paired with data of another frame.

A recorder pairs images with data of the next frame if it drops its first depth
image. It also does so if it numbers depths from one, but colours or poses from
zero.
"""

import dataclasses as dc

import numpy as np

from remosplat_drake.capture.capture import Capture
from remosplat_drake.capture.checks.registration import edge_correlation


@dc.dataclass(frozen=True)
class FrameShift:
    """A shift of images relative to poses by one frame, with its correction.

    Attributes:
        step: Offset of the shifted data: frame i has the data of frame i -
            step.
        moves_depth: Whether depths are shifted relative to poses.
        moves_colour: Whether colours are shifted relative to poses.
    """

    step: int
    moves_depth: bool
    moves_colour: bool

    @property
    def words(self) -> str:
        """Description of the wrongly paired images, as part of a warning."""
        what = {
            (True, True): "images seem to be paired with the poses",
            (True, False): "depths seem to be paired with colours and poses",
            (False, True): "colours seem to be paired with depths and poses",
        }[self.moves_depth, self.moves_colour]
        where = "next" if self.step > 0 else "previous"
        return f"{what} of the {where} frame"

    @property
    def remedy(self) -> str:
        """Description of the correction that `undo` makes, for a report."""
        what = {
            (True, True): "images",
            (True, False): "depth images",
            (False, True): "colour images",
        }[self.moves_depth, self.moves_colour]
        where = "previous" if self.step > 0 else "next"
        return f"moved the {what} to the {where} frame"

    def undo(self, capture: Capture) -> Capture:
        """Moves images to their own poses; the result has one frame less."""
        n = len(capture)
        late, early = np.arange(1, n), np.arange(n - 1)
        if self.step < 0:
            late, early = early, late
        kept = capture.select(early)
        moved = capture.select(late)
        return dc.replace(
            kept,
            rgb=moved.rgb if self.moves_colour else kept.rgb,
            depth=moved.depth if self.moves_depth else kept.depth,
            hidden=moved.hidden if self.moves_depth else kept.hidden,
        )


SHIFTS = tuple(
    FrameShift(step, moves_depth, not moves_depth)
    for moves_depth in (True, False)
    for step in (1, -1)
)
"""Possible shifts: depths by one frame in either direction, and colours by one
frame in either direction."""


def as_colours_tell(shift: FrameShift, capture: Capture) -> FrameShift:
    """Adds a colour shift to a depth shift if the edges then match better.

    Args:
        shift: A shift of depths relative to poses.
        capture: The capture with this shift.
    """
    alone = edge_correlation(capture, -shift.step)
    if edge_correlation(capture) <= alone:
        return shift
    return dc.replace(shift, moves_colour=True)
