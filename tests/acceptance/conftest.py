"""Real processes need a wire between them."""

import pytest

from remosplat_drake.acceptance.hardware_processes import wire_works
from remosplat_drake.app.scenario import load_scenario
from remosplat_drake.app.world import World, load_world


@pytest.fixture(scope="session")
def wire() -> None:
    """Skips where multicasts do not come back."""
    if not wire_works():
        pytest.skip("this computer hears none of its own multicasts")


@pytest.fixture(scope="session")
def table() -> World:
    """The default scenario's world, with its true geometry."""
    return load_world(load_scenario())
