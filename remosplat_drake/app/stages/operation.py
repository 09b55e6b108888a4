"""`Operation`: adds the stages by which an operator moves the target."""

from pydrake.systems.framework import DiagramBuilder, LeafSystem, OutputPort

from remosplat_drake.app.control_loop import ControlLoop
from remosplat_drake.app.scenario import Scenario
from remosplat_drake.app.stages.cockpit import (
    AddCockpitOperator,
    AddCockpitView,
)
from remosplat_drake.app.stages.jobs import AddOperatorTask, has_jobs
from remosplat_drake.app.stages.teleoperation import (
    AddLiveMap,
    AddOperatorTarget,
    AddOperatorViews,
    ConnectSupervision,
    Teleoperation,
)
from remosplat_drake.app.world import World
from remosplat_drake.cockpit.cockpit_process import CockpitProcess
from remosplat_drake.controller.tick.reactive_law import ReactiveLaw
from remosplat_drake.mapping.live_map import LiveMap
from remosplat_drake.task.targets import Targets
from remosplat_drake.teleop.operator_target import OperatorTarget
from remosplat_drake.visualization.page import MeshcatPage


class Operation:
    """Adds an operator's target, live map and display to a control loop.

    Args:
        builder: The builder of the diagram.
        teleoperation: The inputs of a teleoperated diagram.
        page: The browser page to draw on; None draws nothing.
        cockpit: The cockpit, the operator's page; None without a cockpit.
        hardware: Whether the robot is real.

    Attributes:
        operator: The system that outputs the requests of the cockpit's
            operator. It must be connected to the supervisor. None without a
            cockpit.
        target: The target that the operator moves; None before it is added.
    """

    def __init__(
        self,
        builder: DiagramBuilder,
        teleoperation: Teleoperation,
        page: MeshcatPage | None,
        cockpit: CockpitProcess | None,
        *,
        hardware: bool,
    ):
        self._builder, self._teleoperation = builder, teleoperation
        self._page, self._cockpit, self._hardware = page, cockpit, hardware
        self.operator: LeafSystem | None = None
        self.target: OperatorTarget | None = None
        if cockpit is not None:
            scenes = teleoperation.scenes
            self.operator = AddCockpitOperator(builder, cockpit, scenes)

    def AddTarget(
        self,
        scenario: Scenario,
        world: World,
        configuration: OutputPort,
        law: ReactiveLaw,
    ) -> Targets:
        """Adds all sources of operator commands, the target, and the jobs.

        Args:
            scenario: The scenario.
            world: The content of the scenario's files.
            configuration: The output port of the measured q, n_q entries.
            law: The control law, which jobs use.

        Raises:
            RemoSplatError: See `AddOperatorTarget`.
        """
        jobs = has_jobs(scenario)
        target, command = AddOperatorTarget(
            self._builder,
            scenario,
            world,
            configuration,
            self._teleoperation,
            # The page of a real robot gets no panel: its visitors must not move
            # the robot.
            None if self._hardware else self._page,
            [self.operator] if self.operator is not None else [],
            jobs=jobs,
        )
        self.target = target
        if not jobs:
            return target
        return AddOperatorTask(
            self._builder,
            scenario,
            world,
            configuration,
            command,
            law,
            target,
            self._teleoperation.static_map,
            hardware=self._hardware,
        )

    def AddMap(self, loop: ControlLoop) -> LiveMap | None:
        """Adds the map that grows, if there is one, to a control loop."""
        assert self.target is not None
        ConnectSupervision(self._builder, loop, self.target)
        return AddLiveMap(
            self._builder,
            loop,
            self._teleoperation,
            self.target,
            hardware=self._hardware,
        )

    def AddViews(self, loop: ControlLoop, live_map: LiveMap | None) -> None:
        """Adds the display of the robot's state for the operator.

        Args:
            loop: The control loop.
            live_map: The map that grows; None without a live map.
        """
        assert self.target is not None
        at = self._builder, loop, self._teleoperation
        if self._cockpit is not None:
            AddCockpitView(*at, self.target, self._cockpit, live_map)
        if self._page is not None:
            AddOperatorViews(*at, self._page, live_map)
