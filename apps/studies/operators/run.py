"""A simulated teleoperation, from its first tick to its last."""

import dataclasses as dc
from collections.abc import Callable
from pathlib import Path

from pydrake.systems.analysis import ApplySimulatorConfig, Simulator
from pydrake.systems.framework import Context

from apps.studies.operators.random_operator import Look, RandomOperator
from apps.studies.told_operator import ToldOperator
from remosplat_drake.app.diagram import Application, build
from remosplat_drake.app.run_readings import supervision_of
from remosplat_drake.app.scenario import Scenario
from remosplat_drake.app.simulation import simulator_config
from remosplat_drake.app.teleop_session import open_teleoperation
from remosplat_drake.app.world import World
from remosplat_drake.signals.supervisor_state import STOPPED
from remosplat_drake.signals.target_state import SCAN

_STEP = 0.1
"""Period of the operator's decisions [s]."""

_PATIENCE = 1.0
"""Period at which a lasting stop is released [s]."""


@dc.dataclass
class OperatedRun:
    """Facts on a run that the session's log does not contain.

    Attributes:
        stops: Number of stops by the supervisor.
        releases: Number of times that the release button was pressed.
        stopped: Total time for which the robot was stopped [s].
    """

    stops: int = 0
    releases: int = 0
    stopped: float = 0.0


def operate(
    scenario: Scenario,
    world: World,
    folder: Path,
    seed: int,
    duration: float,
    on_time: Callable[[float], None] = lambda time: None,
) -> OperatedRun:
    """Runs a random operator in a simulation, as fast as possible.

    Args:
        scenario: Scenario that is teleoperated; with a fixed latency of its
            maps, equal seeds give equal runs.
        world: World of the scenario.
        folder: Folder that receives the session.
        seed: Seed of the operator.
        duration: Simulated time [s].
        on_time: Callback for the simulated time so far [s].

    Raises:
        RemoSplatError: The session cannot begin.
    """
    mouth = ToldOperator()
    teleoperation = dc.replace(
        open_teleoperation(scenario, world, folder, hardware=False),
        operator=mouth,
    )
    assert teleoperation.mapping is not None
    application = None
    try:
        application = build(scenario, world, teleoperation=teleoperation)
        person = RandomOperator(
            seed, list(scenario.teleop.poses), teleoperation.scenes
        )
        return _Operation(application, mouth, person).run(duration, on_time)
    finally:
        teleoperation.mapping.close()
        if application is not None and application.log is not None:
            application.log.close()


class _Operation:
    """The application, its operator, and the release button."""

    def __init__(
        self,
        application: Application,
        mouth: ToldOperator,
        person: RandomOperator,
    ):
        self._application = application
        self._mouth, self._person = mouth, person
        self._simulator = Simulator(application.diagram)
        ApplySimulatorConfig(
            simulator_config(application.scenario), self._simulator
        )
        self._root: Context = self._simulator.get_mutable_context()
        self._since: float | None = None
        self._pressed = 0.0

    def run(
        self, duration: float, on_time: Callable[[float], None]
    ) -> OperatedRun:
        """Operates until time is up."""
        done = OperatedRun()
        self._simulator.Initialize()
        for step in range(round(duration / _STEP)):
            self._watch_stop(done)
            self._person.look(self._look())
            self._mouth.say(
                self._mouth.GetMyMutableContextFromRoot(self._root),
                self._person.command,
                self._person.map_requests,
            )
            self._simulator.AdvanceTo((step + 1) * _STEP)
            on_time(self._root.get_time())
        return done

    def _watch_stop(self, done: OperatedRun) -> None:
        """Counts stops, and presses the release button periodically."""
        supervision = supervision_of(self._application, self._root)
        assert supervision is not None
        time = self._root.get_time()
        if not supervision.is_latched:
            self._since = None
            return
        if self._since is None:
            self._since = self._pressed = time
            done.stops += 1
        done.stopped += _STEP
        due = time - self._pressed >= _PATIENCE
        if supervision.mode == STOPPED and due:
            supervisor = self._application.supervisor
            assert supervisor is not None
            context = supervisor.GetMyMutableContextFromRoot(self._root)
            supervisor.request_release(context)
            self._pressed = time
            done.releases += 1

    def _look(self) -> Look:
        application, root = self._application, self._root
        target, live_map = application.targets, application.live_map
        assert live_map is not None
        port = target.GetOutputPort("state")
        state = port.Eval(target.GetMyContextFromRoot(root))
        status = live_map.status(live_map.GetMyContextFromRoot(root))
        station = application.configuration.get_system()
        q = application.configuration.Eval(station.GetMyContextFromRoot(root))
        time = root.get_time()
        return Look(
            time=time,
            stopped=0.0 if self._since is None else time - self._since,
            is_scanning=state.mode == SCAN,
            parent=status.scene_map.parent,
            spheres=application.world.robot.spheres_at(q),
        )
