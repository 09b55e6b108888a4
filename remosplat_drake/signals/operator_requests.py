"""`OperatorRequests`: what people have asked of the supervisor."""

import dataclasses as dc


@dc.dataclass(frozen=True)
class OperatorRequests:
    """How often somebody has pressed what; copying returns the object itself.

    Counts lose no press between two looks, and need nobody to reset them.

    Attributes:
        stops: Presses of the stop button.
        releases: Presses of the release button.
    """

    stops: int = 0
    releases: int = 0

    def __deepcopy__(self, memo) -> "OperatorRequests":
        return self
