"""Fixtures of the cockpit's tests."""

import pytest


@pytest.fixture(scope="session")
def shared_rig():
    """A cockpit that outlives each test."""
    from cockpit_rig import Rig  # It needs the extra `cockpit`.

    rig = Rig()
    yield rig
    rig.process.close()


@pytest.fixture
def rig(shared_rig):
    """The same cockpit at its start; after a test, no client operates it."""
    shared_rig.begin()
    yield shared_rig
    shared_rig.wait_until_left()
