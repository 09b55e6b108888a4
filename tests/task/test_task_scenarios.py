"""The shipped tasks, judged by the true shapes at every tick."""

import dataclasses as dc
from functools import cache

import numpy as np
import pytest
from runs import load_application
from true_shapes import (
    Moment,
    load_clearances,
    near_bodies,
    robot_clearances,
    simulate,
    watched,
)

from remosplat_drake.app.diagram import Application, build
from remosplat_drake.app.scenario import load_scenario
from remosplat_drake.base.errors import FieldError
from remosplat_drake.oracle.object_field import ObjectField
from remosplat_drake.robot.hand_links import hand_links
from remosplat_drake.scene.objects.scene_object import find_object
from remosplat_drake.station.station_config import DynamicStation
from remosplat_drake.task.step_configs import Grasping
from remosplat_drake.task.task import DONE, FAILED

USUAL, OWN = 0.021, 0.01
"""The stopping distances from the scene and from the robot itself [m]."""

MAP_ERROR = 0.003
"""By how much the splat over-estimates distances, measured [m]."""


@dc.dataclass(frozen=True, eq=False)
class Job:
    """What a shipped task does.

    Attributes:
        name: Name of its scenario.
        thing: The object that is carried.
        p_WO: Where it shall stand [m].
        own: The distances that it keeps from some others [m].
        stands_on: What it may touch.
    """

    name: str
    thing: str
    p_WO: tuple[float, float, float]
    own: dict[str, float]
    stands_on: set[str]


TABLE = Job(
    "TablePick",
    "middle can",
    (1.1, 0.5, 0.6755),
    {"left can": 0.012},
    {"table", "tray"},
)
SHELF = Job(
    "ShelfPlace",
    "soup can",
    (1.0, 0.2, 0.5958),
    {},
    {"stool", "lower board"},
)
ROOM = Job(
    "FetchAcrossTheRoom",
    "can",
    (-1.95, 0.6, 0.7186),
    {},
    {"table", "stool"},
)
ARMS = Job(
    "TwoArmsHandOver",
    "bar",
    (0.36, -0.25, 0.04),
    {},
    {"workbench"},
)
LONG = [pytest.param(job, marks=pytest.mark.slow) for job in (SHELF, ROOM)]


@cache
def driven(name: str) -> tuple[Application, list[Moment]]:
    """The run of a shipped task, and what each of its ticks has found."""
    application = load_application(name)
    return application, watched(application)


@pytest.fixture(
    scope="module", params=[TABLE, ARMS, *LONG], ids=lambda job: job.name
)
def done(request):
    job = request.param
    return job, *driven(job.name)


def test_the_can_is_put_where_it_shall_stand(done):
    job, _, moments = done
    state = moments[-1].state
    assert state.outcome == DONE and state.failures == ()
    X_WO = state.named(job.thing).X_WO
    assert X_WO.translation() == pytest.approx(job.p_WO, abs=0.006)
    upright = X_WO.rotation().matrix()[2, 2]
    assert upright > np.cos(np.radians(1.5))


def test_the_hand_alone_touches_the_can_alone(done):
    job, application, moments = done
    robot = application.world.robot
    each = range(len(robot.effectors))
    hand, least = set().union(*(hand_links(robot, i) for i in each)), {}
    for moment in moments[::4]:
        for pair, distance in robot_clearances(moment, robot).items():
            if moment.state.held != pair[1]:
                least[pair] = min(least.get(pair, np.inf), distance)
    for (link, name), distance in least.items():
        if name == job.thing and link in hand:
            continue
        assert distance > 0.0, (link, name)
        if name != job.thing:
            assert distance > USUAL - MAP_ERROR, (link, name)


def test_the_can_keeps_its_distances_on_its_way(done):
    job, application, moments = done
    robot = application.world.robot
    held = [moment for moment in moments if moment.state.held]
    for name, distance in load_clearances(held, robot).items():
        if name in job.stands_on:
            assert distance > -0.002
        else:
            assert distance > job.own.get(name, USUAL) - 1e-6, name
    solids = application.world.truth_field
    others = min(
        solids.clearances(
            robot.holding(m.state.payload).spheres_at(m.q)
        ).minimum()
        for m in held[::5]
    )
    assert others > USUAL - MAP_ERROR


def test_no_other_link_touches_what_is_carried(done):
    _, application, moments = done
    robot = application.world.robot
    held = [moment for moment in moments if moment.state.held]
    sides = {"left", "right"}
    for pair, distance in near_bodies(held[::8], robot, 0.03).items():
        arms = {name.partition("_")[0] for name in pair}
        if "load" in pair or arms == sides:
            assert distance > OWN - 1e-3, pair


AT_POINTS = """
objects:
- name: middle can
  region: {near: [1.005, 0.12, 0.66]}
  mass: 0.3
- name: left can
  region: {near: [0.95, 0.24, 0.7]}
- name: table
  X_WO: {translation: [1.5, 0.0, 0.5258]}
  box: [1.0, 4.0, 0.06]
- name: tray
  X_WO: {translation: [1.12, 0.52, 0.5758]}
  box: [0.24, 0.3, 0.04]
  in_splat: false
"""
"""The objects of `TablePick`, the cans by points on them."""


def test_a_can_that_a_point_shows_is_picked_and_placed():
    """Judged by the true cans, which the task does not know."""
    application = build(load_scenario("TablePick", AT_POINTS))
    known = load_application("TablePick").world.objects
    moments = watched(application)
    state = moments[-1].state
    assert state.outcome == DONE and state.failures == ()
    p_WO = state.named(TABLE.thing).X_WO.translation()
    assert p_WO == pytest.approx(TABLE.p_WO, abs=0.006)
    robot = application.world.robot
    held = [moment for moment in moments if moment.state.held]
    assert held and held[0].state.held == TABLE.thing
    left = ObjectField([find_object(known, "left can")])
    fixed = application.world.truth_field
    for m in held[::5]:
        spheres = robot.holding(m.state.payload).spheres_at(m.q)
        assert left.clearances(spheres).minimum() > 0.0
        assert fixed.clearances(spheres).minimum() > USUAL - MAP_ERROR
    for m in moments[::5]:
        near = left.clearances(robot.spheres_at(m.q)).minimum()
        assert near > USUAL - MAP_ERROR


def test_a_bar_goes_from_hand_to_hand():
    """Each hand holds it, then both, then the other one alone."""
    application, moments = driven(ARMS.name)
    robot = application.world.robot
    left, right = hand_links(robot), hand_links(robot, 1)
    payloads = [moment.state.payload for moment in moments]
    held = [(p.link, p.holders) for p in payloads if p is not None]
    assert list(dict.fromkeys(held)) == [
        ("left_hand", left),
        ("left_hand", left | right),
        ("right_hand", left | right),
        ("right_hand", right),
    ]


@pytest.mark.slow
def test_hands_hold_what_they_hand_over_by_friction_alone():
    scenario = load_scenario("TwoArmsHandOver")
    scenario.station = DynamicStation()
    for step in scenario.tasks:
        if isinstance(step, Grasping):
            step.squeeze, step.force = 0.02, 30.0
    application = build(scenario)
    diagram, simulator = application.diagram, simulate(application)
    station = diagram.GetSubsystemByName("station")
    root = simulator.get_context()
    state = application.targets.state(
        application.targets.GetMyContextFromRoot(root)
    )
    assert state.outcome == DONE and state.failures == ()
    context = station.GetMyContextFromRoot(root)
    objects = station.GetOutputPort("cheat.objects").Eval(context)
    p_WO = find_object(objects, "bar").X_WO.translation()
    assert p_WO == pytest.approx(ARMS.p_WO, abs=0.006)


@pytest.mark.slow
def test_a_place_that_is_taken_is_left_for_another():
    application = load_application(
        "TablePick",
        """
tasks:
- !Pick
  object: middle can
  support: table
  touch: [{object: left can, links: [middle can], stopping: 0.012}]
  grasps:
  - translation: [0, 0, 0.06]
    rotation: [[0, 1, 0], [0.9, 0, 0.4358899], [0.4358899, 0, -0.9]]
    width: 0.0596
  lift: [0, -0.04, 0.15]
- !Place
  support: table
  patience: 2.0
  places:
  - {translation: [1.04, -0.24, 0.6355]}
  - {translation: [1.1, 0.0, 0.6355]}
""",
    )
    state = watched(application)[-1].state
    assert state.outcome == DONE and len(state.failures) == 1
    assert (
        "carries the middle can: not finished within 2 s" in state.failures[0]
    )
    p_WO = state.named("middle can").X_WO.translation()
    assert p_WO == pytest.approx([1.1, 0.0, 0.6355], abs=0.006)


def test_a_task_without_a_way_ends_with_its_reason():
    application = load_application(
        "TablePick",
        "{time_limit: 10, tasks: [!ReachTo {patience: 1.0,"
        " translation: [1.5, 0, 0.53]}]}",
    )
    state = watched(application)[-1].state
    assert state.outcome == FAILED
    assert "reaches: not finished within 1 s" in state.failures[0]


@pytest.mark.slow
def test_a_free_place_on_the_tray_is_found_and_used():
    """Past the middle of the tray, as the scenario wants it."""
    scenario = load_scenario("TablePick")
    place = dc.replace(scenario.tasks[1], places=[], near=[1.12, 0.56, 0.6])
    scenario.tasks[1] = place
    application = build(scenario)
    state = watched(application)[-1].state
    assert state.outcome == DONE and state.failures == ()
    p_WO = state.named("middle can").X_WO.translation()
    tray = state.named("tray").solid
    off = np.abs(p_WO[:2] - tray.X_WP.translation()[:2])
    assert (off <= tray.half_extents[:2] - 0.0298 + 0.006).all()
    assert p_WO[2] == pytest.approx(tray.top + 0.1594 / 2, abs=0.006)
    assert p_WO[1] > 0.53


def test_a_tilted_support_is_refused_before_the_run():
    scenario = load_scenario("TablePick")
    scenario.tasks[1] = dc.replace(scenario.tasks[1], places=[])
    scenario.objects[3].X_WO.rpy_deg = [5.0, 0.0, 0.0]
    with pytest.raises(FieldError, match="the top of the tray is tilted"):
        build(scenario)
