"""Real processes need a wire between them."""

import pytest

from remosplat_drake.acceptance import hardware_processes
from remosplat_drake.app.scenario import load_scenario
from remosplat_drake.app.world import World, load_world


@pytest.fixture(scope="session")
def wire_works() -> bool:
    """Whether multicasts come back."""
    return hardware_processes.wire_works()


@pytest.fixture
def wire(wire_works, lone_robot) -> None:
    """Skips where multicasts do not come back; waits for other robots."""
    if not wire_works:
        pytest.skip("this computer hears none of its own multicasts")


@pytest.fixture(scope="session")
def table() -> World:
    """The default scenario's world, with its true geometry."""
    return load_world(load_scenario())
