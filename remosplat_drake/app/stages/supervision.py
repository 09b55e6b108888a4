"""Adds the safety supervisor, and the page's stop button."""

import dataclasses as dc

from pydrake.systems.framework import Diagram, DiagramBuilder, OutputPort

from remosplat_drake.app.scenario import Scenario
from remosplat_drake.controller.reactive_controller import ReactiveController
from remosplat_drake.hardware.client.hardware_station import HardwareStation
from remosplat_drake.robot.robot_model import RobotModel
from remosplat_drake.safety.supervision import SupervisorLaw
from remosplat_drake.safety.supervisor_system import SafetySupervisor
from remosplat_drake.signals import station_ports as ports
from remosplat_drake.visualization.page import MeshcatPage
from remosplat_drake.visualization.safety_panel import SafetyPanel


def AddSupervisor(
    builder: DiagramBuilder,
    scenario: Scenario,
    robot: RobotModel,
    controller: ReactiveController,
    station: Diagram,
    velocity: OutputPort,
    *,
    armed: bool = True,
) -> SafetySupervisor | None:
    """Adds the supervisor between controller and station, if it is enabled.

    Args:
        builder: The builder of the diagram.
        scenario: The scenario.
        robot: The robot, which has the limits.
        controller: The controller whose commands are supervised.
        station: The robot, simulated or real, as a system.
        velocity: The output port of the measured u, n_u entries.
        armed: Whether the robot may start without an operator's consent.

    Returns:
        The supervisor; None if the scenario disables it.
    """
    if not scenario.supervisor.enabled:
        return None
    config, supervisor_config = scenario.controller, scenario.supervisor
    if isinstance(station, HardwareStation):
        # With a slow arm driver, a status becomes older before the next status
        # arrives, so the permitted age is larger.
        age = supervisor_config.max_status_age
        age += scenario.hardware.arm_status_period
        supervisor_config = dc.replace(supervisor_config, max_status_age=age)
    law = SupervisorLaw.make(
        supervisor_config,
        robot,
        scenario.control_period,
        smallest_stopping=config.smallest_stopping,
        strict=config.velocity_limits.strict,
        obeyed=not scenario.hardware.shadow,
    )
    supervisor = SafetySupervisor.AddToBuilder(
        builder,
        law=law,
        controller=controller,
        armed=armed,
    )
    builder.Connect(velocity, supervisor.GetInputPort("velocity_measured"))
    builder.Connect(
        station.GetOutputPort(ports.STATUS), supervisor.GetInputPort("status")
    )
    return supervisor


def AddPanel(
    builder: DiagramBuilder,
    scenario: Scenario,
    robot: RobotModel,
    page: MeshcatPage | None,
    *,
    hardware: bool = False,
) -> SafetyPanel | None:
    """Adds the stop button, if there is a supervisor.

    The stop button must be added before all other controls of the page, so that
    it is above them.

    Args:
        builder: The builder of the diagram.
        scenario: The scenario.
        robot: The robot, which determines the length of u.
        page: The browser page; None has no button.
        hardware: Whether the robot is real; the page cannot release a real
            robot.

    Returns:
        The panel; None without a page or a supervisor.
    """
    if page is None or not scenario.supervisor.enabled:
        return None
    return builder.AddSystem(
        SafetyPanel(page=page, n_u=robot.n_u, releases=not hardware)
    )
