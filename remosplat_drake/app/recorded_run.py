"""`RecordedRun`: a run of a session, read from its folder."""

import dataclasses as dc
from collections.abc import Callable
from functools import cached_property
from pathlib import Path

import numpy as np

from remosplat_drake.app.scenario import Scenario, load_scenario
from remosplat_drake.app.world import World, load_world, true_scenes
from remosplat_drake.base.errors import FieldError, FileError, RemoSplatError
from remosplat_drake.mapping.store.map_file import open_map
from remosplat_drake.mapping.store.run_folders import find_run
from remosplat_drake.mapping.store.session import SCENARIO_FILE, Session
from remosplat_drake.oracle.signed_distance import SignedDistanceField
from remosplat_drake.recording.events import REQUEST, Event, read_events
from remosplat_drake.recording.operator_trace import (
    OperatorTrace,
    trace_operator,
)
from remosplat_drake.recording.run_log import NO_MAP, RunLog, read_log
from remosplat_drake.recording.trajectory_log import EVENTS, LOG
from remosplat_drake.scene.primitive_scene import PrimitiveScene
from remosplat_drake.signals.distance_field import DistanceField
from remosplat_drake.visualization.replay import ReplayedMap


@dc.dataclass(frozen=True, eq=False)
class RecordedRun:
    """A recorded run of a session of teleoperation.

    Attributes:
        folder: Folder of the run.
        session: The session that the run belongs to.
        scenario: The scenario of the session.
        world: The content of the scenario's files.
        log: The ticks; the first one has time 0.
        events: The events of the run, with times on the clock of the ticks.
    """

    folder: Path
    session: Session
    scenario: Scenario
    world: World
    log: RunLog
    events: list[Event]

    def between(self, start: float, end: float) -> "RecordedRun":
        """Returns the part of the run from `start` to `end`.

        Args:
            start: Time at which the part starts [s].
            end: Time at which the part ends [s].

        Raises:
            FieldError: The run has no tick between these times.
        """
        log = self.log.between(start, end)
        if not len(log):
            time = self.log.rows["time"]
            raise FieldError(
                str(self.folder / LOG),
                "time",
                f"no tick lies between {start} and {end} s; valid: "
                f"{time[0]:.2f} to {time[-1]:.2f}",
            )
        return dc.replace(self, log=log)

    def maps(self) -> tuple[dict[int, ReplayedMap], list[str]]:
        """Reads every version of the map that the run used.

        Returns:
            The maps, keyed by version, and a message for each unreadable map.
            An empty map replaces an unreadable map.
        """
        maps, problems = {}, []
        for version in np.unique(self.log.rows["map_version"]).tolist():
            try:
                maps[version] = self._map(version)
            except RemoSplatError as error:
                maps[version] = ReplayedMap()
                problems.append(str(error))
        return maps, problems

    def trace(
        self, on_tick: Callable[[int], None] | None = None
    ) -> OperatorTrace:
        """Computes distances, speeds and errors over the time of the run.

        Args:
            on_tick: Function that is called with the number of processed ticks.
        """
        servo = self.scenario.controller.servo
        return trace_operator(
            self.log,
            self.world.robot,
            gain=servo.gain,
            max_speed=servo.fastest,
            truth=None if self.world.truth is None else self._truth_at,
            on_tick=on_tick,
        )

    def _map(self, version: int) -> ReplayedMap:
        if version in (NO_MAP, 0):
            return ReplayedMap(self.world.field, self.world.splat_W)
        scene_map = open_map(self.session.map_path(version))
        return ReplayedMap(scene_map.field, scene_map.splat_W)

    def _truth_at(self, time: float) -> DistanceField:
        changes = np.searchsorted(self.scene_changes, time)
        return self._truths[changes % len(self._truths)]

    @cached_property
    def _truths(self) -> list[DistanceField]:
        return [SignedDistanceField(scene) for scene in self.scenes]

    @cached_property
    def scenes(self) -> tuple[PrimitiveScene, ...]:
        """The true scene, and the alternative true scene, if there is one."""
        return true_scenes(self.scenario, self.world)

    @cached_property
    def scene_changes(self) -> list[float]:
        """Times at which an operator switched the true scene, ascending [s]."""
        return [
            event.time
            for event in self.events
            if (event.kind, event.text) == (REQUEST, "scene")
        ]


def load_recorded_run(folder: Path, number: int | None = None) -> RecordedRun:
    """Reads a recorded run of a session of teleoperation.

    Args:
        folder: Folder of the session.
        number: Number of the run; None means the session's last run.

    Raises:
        RemoSplatError: The folder contains no session or no such run, or one of
            its files cannot be read.
    """
    if not folder.is_dir():
        problem = "is not a folder" if folder.exists() else "does not exist"
        raise FileError(folder, f"{problem}; give the folder of a session")
    session = Session.open(folder)
    run = find_run(folder, number)
    log = read_log(run / LOG)
    if not len(log):
        raise FileError(run / LOG, "holds no ticks")
    scenario = load_scenario(str(folder / SCENARIO_FILE))
    world = load_world(scenario, blank=True)
    n_q = log.rows["q"].shape[1]
    if n_q != world.robot.n_q:
        raise FileError(
            run / LOG,
            f"was recorded with a robot of {n_q} positions, but the session's "
            f"robot has {world.robot.n_q}",
        )
    events = read_events(run / EVENTS)
    # A real robot's run has the time of day as its clock.
    start = float(log.rows["time"][0])
    log.rows["time"] -= start
    events = [dc.replace(e, time=e.time - start) for e in events]
    return RecordedRun(run, session, scenario, world, log, events)
