"""`OperatorRequests`: what operators have asked of the supervisor so far."""

import dataclasses as dc


@dc.dataclass(frozen=True)
class OperatorRequests:
    """Number of presses of stop and release; copying returns the object itself.

    Counts lose no press between two looks, and need nobody to reset them.

    Attributes:
        stops: Number of presses of the stop button.
        releases: Number of presses of the release button.
        trouble: Why a press of stop would not be heard; empty if it would.
    """

    stops: int = 0
    releases: int = 0
    trouble: str = ""

    def __deepcopy__(self, memo) -> "OperatorRequests":
        return self
