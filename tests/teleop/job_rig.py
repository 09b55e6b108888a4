"""A teleoperated robot with objects: the application and its operator."""

import dataclasses as dc
from collections.abc import Callable

import numpy as np
from job_person import Person
from pydrake.systems.analysis import ApplySimulatorConfig, Simulator

from remosplat_drake.app.diagram import build
from remosplat_drake.app.scenario import load_scenario
from remosplat_drake.app.simulation import simulator_config
from remosplat_drake.app.teleop_session import open_teleoperation
from remosplat_drake.app.world import load_world
from remosplat_drake.scene.objects.scene_object import (
    SceneObject,
    find_object,
)
from remosplat_drake.signals.map_status import MapStatus
from remosplat_drake.signals.supervisor_state import SupervisorState
from remosplat_drake.signals.target_state import TargetState
from remosplat_drake.teleop.operator_jobs import Jobs
from remosplat_drake.teleop.operator_target import OperatorTarget
from remosplat_drake.teleop.operator_task import OperatorTask

PATIENCE = 60.0
"""Longest wait for an event [s of the simulation]."""


class JobRig:
    """A shipped scenario in which a person requests jobs."""

    def __init__(
        self,
        folder,
        name="TableObjects",
        change=lambda scenario: None,
        text="{mapping: {enabled: false}}",
    ):
        self.scenario = load_scenario(name, text)
        change(self.scenario)
        self.world = load_world(
            self.scenario, blank=self.scenario.mapping.enabled
        )
        self.person = Person()
        session = open_teleoperation(
            self.scenario, self.world, folder, hardware=False
        )
        session = dc.replace(session, operator=self.person)
        self.application = build(
            self.scenario, self.world, teleoperation=session
        )
        diagram = self.application.diagram
        self.simulator = Simulator(diagram)
        ApplySimulatorConfig(simulator_config(self.scenario), self.simulator)
        self.target = diagram.GetSubsystemByName("targets")
        assert isinstance(self.target, OperatorTarget)
        assert isinstance(self.application.targets, OperatorTask)
        self.closest = np.inf
        self.said: list[str] = []

    def _mine(self, system):
        return system.GetMyContextFromRoot(self.simulator.get_context())

    def ask(self, count: str, **values):
        """Makes another request."""
        self.person.ask(count, **values)

    def until(self, condition: Callable[[], object]):
        """Ticks until something is so."""
        period, end = self.scenario.control_period, self.time + PATIENCE
        while not condition():
            assert self.time < end, (self.said, self.jobs.state.failures)
            self.simulator.AdvanceTo(self.time + period)
            if self.jobs.text not in (*self.said[-1:], ""):
                self.said.append(self.jobs.text)
            self.closest = min(self.closest, self.clearance)

    def until_idle(self):
        """Ticks until the operator leads again."""
        self.until(lambda: self.jobs.leads)
        self.until(lambda: not self.jobs.leads)

    @property
    def time(self) -> float:
        return self.simulator.get_context().get_time()

    @property
    def jobs(self) -> Jobs:
        targets = self.application.targets
        assert isinstance(targets, OperatorTask)
        return targets._jobs(self._mine(targets))

    @property
    def live_map(self) -> MapStatus:
        live_map = self.application.live_map
        assert live_map is not None
        return live_map.status(self._mine(live_map))

    @property
    def led(self) -> TargetState:
        """The target that the operator moves."""
        return self.target.state(self._mine(self.target))

    @property
    def q(self) -> np.ndarray:
        port = self.target.GetInputPort("configuration")
        return np.array(port.Eval(self._mine(self.target)))

    @property
    def u(self) -> np.ndarray:
        """The command that is executed."""
        supervisor = self.application.supervisor
        assert supervisor is not None
        port = supervisor.GetOutputPort("velocity_commanded")
        return np.array(port.Eval(self._mine(supervisor)))

    @property
    def supervision(self) -> SupervisorState:
        supervisor = self.application.supervisor
        assert supervisor is not None
        port = supervisor.GetOutputPort("supervision")
        return port.Eval(self._mine(supervisor))

    @property
    def X_WE(self) -> np.ndarray:
        return self.world.robot.end_effector_pose(self.q)

    @property
    def p_WO(self) -> dict[str, np.ndarray]:
        """Where the objects stand, by name [m]."""
        return {
            each.name: each.X_WO.translation()
            for each in self.jobs.state.objects
        }

    def true_object(self, name: str) -> SceneObject:
        """An object where the dynamic station has it."""
        station = self.application.station
        port = station.GetOutputPort("cheat.objects")
        return find_object(port.Eval(self._mine(station)), name)

    @property
    def clearance(self) -> float:
        """Of the robot, without its load, to the true scene [m]."""
        field = self.world.truth_field
        assert field is not None
        return field.clearances(self.world.robot.spheres_at(self.q)).minimum()

    @property
    def width(self) -> float:
        """Commanded opening of the hand [m]."""
        targets = self.application.targets
        return targets.GetOutputPort("hand_command").Eval(self._mine(targets))[
            0
        ]
