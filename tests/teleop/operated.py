"""A robot in a scene that follows an operator: the application's core."""

import dataclasses as dc

import numpy as np
from pydrake.common.value import Value
from pydrake.math import RigidTransform
from pydrake.systems.analysis import ApplySimulatorConfig, Simulator
from pydrake.systems.framework import DiagramBuilder

from remosplat_drake.app.scenario import load_scenario
from remosplat_drake.app.stages.control import AddController, AddOracle
from remosplat_drake.app.stages.station import MakeStation
from remosplat_drake.app.world import load_world
from remosplat_drake.camera.mount import CameraMount
from remosplat_drake.controller.tick.reactive_law import ReactiveLaw
from remosplat_drake.signals.operator_command import OperatorCommand
from remosplat_drake.signals.target_state import TargetState
from remosplat_drake.station.connections import AddConfiguration, ConnectCommand
from remosplat_drake.station.station_config import kinematic_simulator_config
from remosplat_drake.teleop.motion_law import MotionLaw
from remosplat_drake.teleop.operator_target import OperatorTarget
from remosplat_drake.teleop.teleop_config import TeleopConfig


class Operated:
    """A shipped scenario's robot with an `OperatorTarget`."""

    def __init__(self, spec: str, config: TeleopConfig, text: str = ""):
        scenario = load_scenario(spec, text)
        self.world = load_world(scenario)
        robot, q0 = self.world.robot, self.world.q0
        self.mount = CameraMount(robot, RigidTransform())
        builder = DiagramBuilder()
        station = builder.AddSystem(MakeStation(scenario, self.world, False))
        configuration = AddConfiguration(builder, robot, station)
        self.law = MotionLaw.make(
            config, robot, q0, scenario.control_period, self.mount
        )
        self.target = builder.AddSystem(
            OperatorTarget(robot=robot, q0=q0, law=self.law)
        )
        builder.Connect(
            configuration, self.target.GetInputPort("configuration")
        )
        oracle = AddOracle(builder, scenario, self.world, configuration)
        law = ReactiveLaw.make(
            scenario.controller, robot, scenario.control_period
        )
        controller = AddController(
            builder, law, configuration, self.target, oracle
        )
        u = controller.GetOutputPort("velocity_commanded")
        ConnectCommand(builder, robot, u, station)
        builder.Connect(u, controller.GetInputPort("velocity_executed"))
        self.simulator = Simulator(builder.Build())
        ApplySimulatorConfig(
            kinematic_simulator_config(scenario.control_period), self.simulator
        )
        self.context = self.target.GetMyContextFromRoot(
            self.simulator.get_mutable_context()
        )
        self.command = OperatorCommand()
        self.say()

    def say(self, **changes) -> None:
        self.command = dc.replace(self.command, **changes)
        self.target.GetInputPort("command").FixValue(
            self.context, Value(self.command)
        )

    def wait(self, duration: float) -> None:
        self.simulator.AdvanceTo(self.context.get_time() + duration)

    @property
    def q(self) -> np.ndarray:
        port = self.target.GetInputPort("configuration")
        return np.array(port.Eval(self.context))

    @property
    def state(self) -> TargetState:
        return self.target.state(self.context)

    @property
    def clearance(self) -> float:
        """Of the whole robot to the true scene [m]."""
        field = self.world.truth_field
        assert field is not None
        return field.clearances(self.world.robot.spheres_at(self.q)).minimum()
