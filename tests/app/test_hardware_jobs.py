"""An operator's jobs on the robot, which is a process behind the wire."""

import dataclasses as dc
from collections.abc import Callable, Iterator
from contextlib import ExitStack

import numpy as np
import pytest
from consenting import consenting
from job_person import Person
from pydrake.systems.framework import Context
from robot_process import Client, robot_process, running
from runs import PATIENT

from remosplat_drake.acceptance.hardware_processes import free_url
from remosplat_drake.app import warm_up
from remosplat_drake.app.diagram import build
from remosplat_drake.app.hardware_run import (
    prepare_for_hardware,
    run_on_hardware,
)
from remosplat_drake.app.scenario import load_scenario
from remosplat_drake.app.teleop_session import open_teleoperation
from remosplat_drake.app.world import load_world
from remosplat_drake.mapping.known_objects import find_own_pixels
from remosplat_drake.mapping.store.frame_store import FrameStore
from remosplat_drake.robot.sphere_model import Spheres
from remosplat_drake.signals import station_ports as ports
from remosplat_drake.signals.map_status import MapStatus
from remosplat_drake.task.task import DONE
from remosplat_drake.teleop.operator_jobs import Jobs
from remosplat_drake.teleop.operator_task import OperatorTask

NAME = "TableObjects"

FIXED_MAP = "mapping: {enabled: false}"

LIVE_MAP = """
mapping: {enabled: true}
scene: {unknown: free}
"""
"""The shipped splat, which frames of the wrist camera update."""


class Over(Exception):
    """The story of a test has ended."""


@dc.dataclass
class Bench:
    """The state of a run on the stand-in, as a test reads it.

    Attributes:
        client: Another program on the wire.
        jobs: The operator's jobs at the latest tick.
        person: The operator.
        hand: Width, rate and force of the hand [m, m/s, N].
        stop: Why the robot is stopped, or not yet released; empty if it may
            move.
        map: The live map; None without one.
        q: The measured configuration.
    """

    client: Client
    jobs: Jobs
    person: Person = dc.field(default_factory=Person)
    hand: np.ndarray = dc.field(default_factory=lambda: np.full(3, np.nan))
    stop: str = "waits"
    map: MapStatus | None = None
    q: np.ndarray = dc.field(default_factory=lambda: np.zeros(0))

    def distance_to(self, X_WT: np.ndarray) -> float:
        """Distance of the end effector from a pose [m]."""
        X_WE = self.jobs.task.robot.end_effector_pose(self.q)
        return float(np.linalg.norm(X_WE[:3, 3] - X_WT[:3, 3]))

    def is_free(self) -> bool:
        return not self.stop

    def has_done(self, job: str) -> Callable[[], bool]:
        """Returns a condition: a job is done, and the operator leads again."""
        began = []

        def is_over() -> bool:
            jobs, state = self.jobs, self.jobs.state
            assert not self.stop, (self.stop, state.failures)
            if jobs.runs:
                began.append(jobs.task.blocks[-1].text)
            if jobs.leads or job not in began:
                return False
            assert state.outcome == DONE, state.failures
            return True

        return is_over


Story = Callable[[Bench], Iterator[Callable[[], bool]]]
"""A test as a generator: it makes requests, and yields conditions; it continues
when the latest condition holds."""


def play(folder, story: Story, text: str = FIXED_MAP) -> Bench:
    """Operates the stand-in until a story has ended; how things are then."""
    url = free_url()
    scenario = load_scenario(NAME, f"{text}\n{PATIENT}")
    prepare_for_hardware(scenario, url)
    scenario.time_limit = 800
    world = load_world(scenario)
    warm_up.compile_kernels(scenario, world, live_map=True)
    with ExitStack() as processes:
        processes.enter_context(robot_process(url, NAME))
        processes.enter_context(consenting(url))
        if scenario.mapping.enabled:
            camera = running(
                "camera-sim", NAME, "--lcm-url", url, "--rate", "2"
            )
            processes.enter_context(camera)
        client = Client(url)
        client.wait_for_robot()
        person = Person()
        session = dc.replace(
            open_teleoperation(scenario, world, folder, hardware=True),
            operator=person,
        )
        application = build(
            scenario, world, hardware=True, teleoperation=session
        )
        targets, station = application.targets, application.station
        supervisor = application.supervisor
        assert isinstance(targets, OperatorTask) and supervisor is not None
        hand_model = world.robot.description.hand
        assert hand_model is not None
        hand = station.GetOutputPort(ports.hand_state(hand_model))
        supervision = supervisor.GetOutputPort("supervision")
        jobs = targets._jobs(targets.CreateDefaultContext())
        bench = Bench(client, jobs, person)
        events = story(bench)
        waits = [next(events)]

        def look(root: Context) -> None:
            mine = targets.GetMyContextFromRoot(root)
            bench.jobs = targets._jobs(mine)
            bench.q = targets.GetInputPort("configuration").Eval(mine)
            if application.live_map is not None:
                live = application.live_map.GetMyContextFromRoot(root)
                bench.map = application.live_map.status(live)
            bench.hand = hand.Eval(station.GetMyContextFromRoot(root))
            stopped = supervision.Eval(supervisor.GetMyContextFromRoot(root))
            bench.stop = stopped.reason if stopped.is_latched else ""
            while waits[-1]():
                try:
                    waits[-1] = next(events)
                except StopIteration:
                    raise Over from None

        with pytest.raises(Over):
            result = run_on_hardware(application, between_ticks=look)
            pytest.fail(f"{result.run.outcome}: {bench.jobs.text}")
        session.close()
    return bench


@pytest.mark.slow
def test_a_can_is_taken_and_put_on_the_tray_over_the_wire(tmp_path, lone_robot):
    widths = []

    def story(bench):
        yield bench.is_free
        bench.person.ask("takes", thing="soup can")
        yield lambda: bench.jobs.text.endswith("searches how")
        yield bench.has_done("pick the soup can")
        assert bench.jobs.state.held == "soup can"
        # The hand reports that it has stopped at the can, and presses.
        widths.append(bench.hand[0])
        assert bench.hand[2] > 1.0
        bench.person.ask("places", support="tray")
        yield bench.has_done("place the soup can")

    bench = play(tmp_path / "session", story)
    assert widths[0] == pytest.approx(0.066, abs=0.003)
    state = bench.jobs.state
    assert state.held == "" and bench.hand[0] > 0.07
    p_WO = state.named("soup can").X_WO.translation()
    assert p_WO[2] == pytest.approx(0.5958 + 0.06, abs=0.0051)
    assert abs(p_WO[0] - 1.14) < 0.12 - 0.033 + 0.005
    assert abs(p_WO[1] - 0.8) < 0.15 - 0.033 + 0.005


@pytest.mark.slow
@pytest.mark.usefixtures("open3d")
def test_a_can_is_taken_in_a_live_map_over_the_wire(tmp_path, lone_robot):
    rooms = []

    def story(bench):
        yield bench.is_free
        # The robot turns to the can, whose frame becomes a map.
        X_WT = np.eye(4)
        X_WT[:3, 3] = 0.95, 0.4, 1.0
        X_WT[:3, :3] = np.diag([1.0, -1.0, -1.0])
        bench.person.ask("moves", X_WT=X_WT)
        yield lambda: bench.distance_to(X_WT) < 0.02
        bench.person.ask("holds")
        bench.person.take_frame()
        yield lambda: bench.map.scene_map.version > 0
        stood = bench.jobs.state.named("soup can").X_WO.translation()
        field = bench.map.scene_map.field
        rooms.append(field.clearances(Spheres.at(stood)).minimum())
        bench.person.ask("takes", thing="soup can")
        yield bench.has_done("pick the soup can")

    bench = play(tmp_path / "session", story, LIVE_MAP)
    assert bench.jobs.state.held == "soup can"
    # The frame shows the can, whose radius is 33 mm, and the map does not.
    frames = FrameStore(tmp_path / "session" / "frames")
    assert not frames.load(frames.names)
    known = [frames.objects(name) for name in frames.names]
    capture = frames.capture(frames.names)
    can = bench.jobs.task.objects[0]
    own = find_own_pixels(capture, [can], known)
    assert can.name == "soup can" and np.count_nonzero(own) > 200
    assert rooms[0] > 0.043


@pytest.mark.slow
def test_a_lost_can_is_an_obstacle_at_an_unknown_place(tmp_path, lone_robot):
    reason = "the soup can has slipped out of the hand"

    def story(bench):
        yield bench.is_free
        bench.person.ask("takes", thing="soup can")
        yield bench.has_done("pick the soup can")
        bench.client.inject("hand-opens")
        yield lambda: bench.jobs.text == f"hold: carry the soup can: {reason}"
        yield lambda: not bench.jobs.leads
        assert bench.jobs.state.held == "" and not bench.stop
        bench.person.ask("takes", thing="soup can")
        yield lambda: "is unknown" in bench.jobs.text
        yield lambda: not bench.jobs.leads

    state = play(tmp_path / "session", story).jobs.state
    assert state.lost == {"soup can"}
    (can,) = (each for each in state.in_map if each.name == "soup can")
    # From the hand, which had lifted it, down to the floor.
    lower, upper = can.corners + can.X_WO.translation()
    assert lower[2] == pytest.approx(0.0, abs=1e-6)
    assert upper[2] > 0.6158 + 0.06 + 0.05
