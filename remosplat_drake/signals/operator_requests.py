"""`OperatorRequests`: counts of operators' requests to the supervisor."""

import dataclasses as dc


@dc.dataclass(frozen=True)
class OperatorRequests:
    """Counts of presses of two buttons; copying returns the object itself.

    An increased count is a request. So no press is lost between two reads, and
    no flag must be reset.

    Attributes:
        stops: Number of presses of the stop button.
        releases: Number of presses of the release button.
        trouble: Reason why the stop button does not work now; empty if it
            works.
    """

    stops: int = 0
    releases: int = 0
    trouble: str = ""

    def __deepcopy__(self, memo) -> "OperatorRequests":
        return self
