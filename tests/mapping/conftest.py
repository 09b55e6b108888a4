"""Views of a table that a thing comes to and goes from."""

import pytest
from laden_table import bare_table, laden_table

from remosplat_drake.capture.capture import Capture


@pytest.fixture(scope="session")
def bare() -> Capture:
    """Four views of the bare table."""
    return bare_table()


@pytest.fixture(scope="session")
def laden() -> Capture:
    """Three views of the table with the thing on it."""
    return laden_table()
