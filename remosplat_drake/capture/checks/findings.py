"""`Finding`: a problem of a capture, its severity and its remedy."""

import dataclasses as dc
from collections.abc import Callable, Iterable

from remosplat_drake.capture.capture import Capture

DEFECT, WARNING = "defect", "warning"
"""Severities of a finding. A defect causes a wrong map. With a warning, the map
may be less complete or less exact than the capture suggests.
"""

INTRINSICS = "intrinsics"
NO_DEPTH = "no-depth"
EMPTY_DEPTH = "empty-depth"
DEPTH_RANGE = "depth-range"
DEPTH_UNIT = "depth-unit"
ONE_SIDE = "one-side"
COLOURS = "colours"
POSES = "poses"
WRONG_FRAMES = "wrong-frames"
NO_OVERLAP = "no-overlap"
CONTRADICTION = "contradiction"
INEXACT = "inexact"
MOVING = "moving"
LENS = "lens"
SEPARATE = "separate-groups"
ONE_JOINT = "one-joint"
ONE_PLANE = "one-plane"
READING = "reading"

DEFECTS = {
    INTRINSICS: "the intrinsics do not fit the images",
    NO_DEPTH: "there is almost no depth",
    DEPTH_UNIT: "depths have the wrong unit",
    ONE_SIDE: "everything was seen from one side only",
    COLOURS: "colours and depths do not match",
    POSES: "poses contradict each other because of a common mistake: they are "
    "inverted, have wrong axes or a wrong unit, quaternions are in another "
    "order, or poses belong to other frames",
    WRONG_FRAMES: "frames contradict all frames with which they overlap",
    NO_OVERLAP: "frames share no surface that could confirm their poses",
    CONTRADICTION: "frames contradict each other; the cause is unknown",
}
"""Names of the defects that a user may accept, with their meanings."""


@dc.dataclass(frozen=True, eq=False)
class Finding:
    """A problem of a capture.

    Attributes:
        name: Short name; for a defect, a key of `DEFECTS`.
        problem: Description with numbers.
        severity: `DEFECT` or `WARNING`; a defect causes a wrong map.
        frames: Indices of the affected frames; empty if the problem affects the
            whole capture.
        remedy: Description of the correction that `repair` makes; empty if
            there is none.
        repair: Function that returns the capture without the problem; None if
            the problem cannot be corrected.
    """

    name: str
    problem: str
    severity: str = DEFECT
    frames: tuple[int, ...] = ()
    remedy: str = ""
    repair: Callable[[Capture], Capture] | None = None

    def __str__(self) -> str:
        return f"{self.name}: {self.problem}"


def list_frames(
    frames: Iterable[int], capture: Capture | None = None, most: int = 10
) -> str:
    """Formats a list of frames, such as "3, 7, 9 and 2 more".

    Args:
        frames: Indices of the frames.
        capture: Capture with the frames' names; None: their indices are listed.
        most: Largest number of frames that are listed.
    """
    frames = list(frames)
    known = capture.names if capture is not None else ()
    listed = ", ".join(known[i] if known else str(i) for i in frames[:most])
    rest = len(frames) - most
    return listed if rest <= 0 else f"{listed} and {rest} more"
