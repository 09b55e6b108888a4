"""`OperatorRequests`: counts of operators' requests to the supervisor."""

import dataclasses as dc


@dc.dataclass(frozen=True)
class OperatorRequests:
    """Number of presses of stop and release; copying returns the object itself.

    With counts, no press is lost between two reads, and nothing needs a reset.

    Attributes:
        stops: Number of presses of the stop button.
        releases: Number of presses of the release button.
        trouble: Why the stop button does not work now; empty if it works.
    """

    stops: int = 0
    releases: int = 0
    trouble: str = ""

    def __deepcopy__(self, memo) -> "OperatorRequests":
        return self
