"""The effort of a test: little by default, more with `make test-all`."""

import os
from typing import TypeVar

T = TypeVar("T")


def effort(few: T, many: T) -> T:
    """Examples, seeds, ticks or seconds: many where THOROUGH=1 is set."""
    return many if os.environ.get("THOROUGH") == "1" else few
