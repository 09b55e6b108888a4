"""`LiveSession`: a teleoperation with a live map, tick by tick."""

import dataclasses as dc
import itertools
from collections import deque
from pathlib import Path
from types import TracebackType

import numpy as np
from pydrake.systems.analysis import ApplySimulatorConfig, Simulator
from pydrake.systems.framework import Context

from apps.studies.told_operator import ToldOperator
from remosplat_drake.app.diagram import build
from remosplat_drake.app.run_readings import supervision_of
from remosplat_drake.app.scenario import Scenario
from remosplat_drake.app.simulation import simulator_config
from remosplat_drake.app.teleop_session import open_teleoperation
from remosplat_drake.app.world import World
from remosplat_drake.base.errors import RemoSplatError
from remosplat_drake.mapping.mapping_process import MappingProcess
from remosplat_drake.signals.map_requests import MapRequests
from remosplat_drake.signals.map_status import MapStatus
from remosplat_drake.signals.operator_command import OperatorCommand
from remosplat_drake.signals.supervisor_state import STOPPED
from remosplat_drake.signals.tick_report import TickReport
from remosplat_drake.visualization.page import MeshcatPage

_STAY = 4.0
"""Period at which the target moves to another saved pose [s]."""

_PATIENCE = 1.0
"""Period at which a stopped robot is released [s]."""

_KEPT = 10.0
"""Time span of the stored reports [s]."""


class LiveSession:
    """A simulated robot between saved poses, whose map grows on request.

    It is a context manager: the mapping process ends with it.

    Attributes:
        time: Simulated time [s].
        period: Control period [s].
        process: The process that makes the maps.
        reports: Reports of the controller's latest ticks.
        robot: Model of the robot.
    """

    def __init__(
        self,
        scenario: Scenario,
        world: World,
        folder: Path,
        page: MeshcatPage | None = None,
    ):
        """Builds the diagram and starts the mapping process.

        Args:
            scenario: Scenario that is teleoperated, with saved poses.
            world: World of the scenario.
            folder: Folder that receives the session.
            page: Meshcat page that is served meanwhile; None for no page.

        Raises:
            RemoSplatError: The session cannot begin.
        """
        self.time, self.period = 0.0, scenario.control_period
        self.robot = world.robot
        self.reports: deque[TickReport] = deque(
            maxlen=round(_KEPT / self.period)
        )
        self._mouth = ToldOperator()
        teleoperation = dc.replace(
            open_teleoperation(scenario, world, folder, hardware=False),
            operator=self._mouth,
        )
        assert teleoperation.mapping is not None
        self.process: MappingProcess = teleoperation.mapping
        try:
            self._application = build(
                scenario, world, page, teleoperation=teleoperation
            )
        except BaseException:
            self.process.close()
            raise
        self._simulator = Simulator(self._application.diagram)
        ApplySimulatorConfig(simulator_config(scenario), self._simulator)
        self._root: Context = self._simulator.get_mutable_context()
        self._poses = itertools.cycle(scenario.teleop.poses)
        self._command = OperatorCommand(source="script")
        self._requests = MapRequests()
        self._moved = self._released = 0.0
        self._ticks = 0
        self._simulator.Initialize()

    def __enter__(self) -> "LiveSession":
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        value: BaseException | None,
        traceback: TracebackType | None,
    ) -> None:
        self.process.close()
        if self._application.log is not None:
            self._application.log.close()

    @property
    def status(self) -> MapStatus:
        """Status of the live map."""
        live_map = self._application.live_map
        assert live_map is not None
        return live_map.status(live_map.GetMyContextFromRoot(self._root))

    @property
    def pid(self) -> int:
        """Process id of the mapping process, once it has answered.

        Raises:
            RemoSplatError: The mapping process has died.
        """
        process = self.process.process
        if process is None or process.pid is None:
            raise RemoSplatError("the mapping process has died")
        return process.pid

    @property
    def configurations(self) -> tuple[np.ndarray, np.ndarray]:
        """The q that is measured, and the same in W, shape (n_q,) each."""
        application = self._application
        ports = application.odometry, application.configuration
        measured, q = (
            port.Eval(port.get_system().GetMyContextFromRoot(self._root))
            for port in ports
        )
        return measured, q

    def scan(self) -> None:
        """Starts a scan, in which the robot looks around for its first map."""
        scans = self._command.scans + 1
        self._say(dc.replace(self._command, scans=scans))

    def ask(self, more: MapRequests) -> None:
        """Adds requests to the live map."""
        self._requests += more
        self._say(self._command)

    def move_on(self) -> None:
        """Moves to the next saved pose if it is due; call it often.

        It also releases a robot that was stopped.
        """
        if self.time - self._moved >= _STAY:
            self._moved = self.time
            poses = self._command.poses + 1
            self._say(
                dc.replace(self._command, pose=next(self._poses), poses=poses)
            )
        supervision = supervision_of(self._application, self._root)
        stopped = supervision is not None and supervision.mode == STOPPED
        if stopped and self.time - self._released >= _PATIENCE:
            self._released = self.time
            supervisor = self._application.supervisor
            assert supervisor is not None
            supervisor.request_release(
                supervisor.GetMyMutableContextFromRoot(self._root)
            )

    def tick(self) -> None:
        """Computes one tick and simulates to the next one."""
        self._ticks += 1
        self.time = self._ticks * self.period
        self._simulator.AdvanceTo(self.time)
        latest = self._application.recorder.latest
        is_new = not self.reports or latest is not self.reports[-1]
        if latest is not None and is_new:
            self.reports.append(latest)

    def _say(self, command: OperatorCommand) -> None:
        self._command = command
        context = self._mouth.GetMyMutableContextFromRoot(self._root)
        self._mouth.say(context, command, self._requests)
