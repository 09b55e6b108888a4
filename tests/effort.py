"""Numbers of examples and ticks: few by default, many by `make test-all`."""

import os
from typing import TypeVar

T = TypeVar("T")


def effort(few: T, many: T) -> T:
    """Returns `many` where the environment has THOROUGH=1, else `few`."""
    return many if os.environ.get("THOROUGH") == "1" else few
