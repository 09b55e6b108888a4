"""Every shipped scenario, from its file to its last target."""

import pytest
from runs import load_application, run_scenario

from remosplat_drake.app.run_result import REACHED, TIME_LIMIT
from remosplat_drake.app.scenario import (
    DEFAULT_SCENARIO,
    find_scenario,
    load_scenario,
    shipped_scenarios,
)
from remosplat_drake.app.simulation import run
from remosplat_drake.app.world import World
from remosplat_drake.base.errors import RemoSplatError
from remosplat_drake.recording.trajectory import Trajectory


def true_clearances(world: World, trajectory: Trajectory) -> list[float]:
    """Worked out afresh, not by the metrics of the run."""
    field = world.truth_field
    assert field is not None
    return [
        field.clearances(world.robot.spheres_at(q)).minimum()
        for q in trajectory.q
    ]


SHIPPED = {name: load_scenario(name) for name in shipped_scenarios()}

MAPPED = [n for n, s in SHIPPED.items() if s.scene.splat and not s.tasks]
"""Their maps are there from the start. Those with tasks are in `task/`."""

LONG = {
    "BookshelfDynamic",
    "DoorSwings",
    "PandaDynamic",
    "PandaTargets",
    "PersonPasses",
    "PersonReaches",
    "PersonSeen",
    "RidgebackReach",
    "RoomReach",
    "TableObjects",
    "TableTeleop",
    "TableTour",
    "TwoRobots",
}
"""Shorter scenarios, and tests of movers, show what these show."""


@pytest.mark.parametrize(
    "name",
    [
        pytest.param(name, marks=[pytest.mark.slow] * (name in LONG))
        for name in MAPPED
    ],
)
def test_it_reaches_its_targets_and_touches_nothing(name):
    result = run_scenario(name)
    assert result.outcome == REACHED
    assert result.targets_reached == result.targets
    # What comes too fast leaves no program as it stands.
    if not load_scenario(name).movers:
        assert set(result.metrics.statuses) == {"optimal"}
    assert result.metrics.truth_clearance_min > 0.02


def test_the_default_one_is_clear_of_the_truth_at_every_tick():
    application = load_application(DEFAULT_SCENARIO)
    result = run(application)
    clearances = true_clearances(application.world, result.trajectory)
    assert len(clearances) == result.metrics.ticks + 1
    assert min(clearances) == result.metrics.truth_clearance_min
    # It did come close: the scene is no empty room.
    assert 0.02 < min(clearances) < 0.1


# The tests above can fail: a scenario that is broken does not get through.


def test_a_target_inside_the_table_is_not_reached():
    inside = "{time_limit: 2, targets: [{translation: [1.5, 0, 0.53]}]}"
    result = run_scenario(DEFAULT_SCENARIO, inside)
    assert result.outcome == TIME_LIMIT
    assert result.metrics.truth_clearance_min > 0.02


@pytest.mark.parametrize(
    ("before", "after"),
    [
        ("splat.ply", "splatt.ply"),
        ("splat:", "splats:"),
        ("models/scenes/table", "models/scenes/tables"),
    ],
)
def test_a_broken_scenario_is_refused(tmp_path, before, after):
    path, _ = find_scenario(DEFAULT_SCENARIO)
    text = path.read_text()
    assert before in text
    broken = tmp_path / path.name
    broken.write_text(text.replace(before, after))
    with pytest.raises(RemoSplatError, match=path.name):
        load_application(broken)


def test_seeing_nothing_would_be_noticed():
    """Blind to the splat, the same run goes through the shelf."""
    blind = "{oracle: !SphereToEllipsoid {min_opacity: 0.9999999}}"
    result = run_scenario("BookshelfReach", blind)
    assert result.metrics.truth_clearance_min < 0
