"""Fixtures of the cockpit's tests."""

import pytest


@pytest.fixture(scope="module")
def rig():
    """A cockpit that outlives each test of a module."""
    from cockpit_rig import Rig  # It needs the extra `cockpit`.

    rig = Rig()
    yield rig
    rig.process.close()
