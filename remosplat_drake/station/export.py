"""Exports the ports of a station's subsystems under the station's names."""

from collections.abc import Mapping

from pydrake.systems.framework import DiagramBuilder, OutputPort, System

from remosplat_drake.robot.robot_description import RobotDescription
from remosplat_drake.signals import station_ports as ports


def export_ports(
    builder: DiagramBuilder,
    description: RobotDescription,
    systems: list[System],
    camera: Mapping[str, OutputPort] | None = None,
) -> None:
    """Exports the ports that `signals.station_ports` lists, in its order.

    Args:
        builder: Builder of the station.
        description: Description of the robot.
        systems: Subsystems whose ports already have the station's names.
        camera: Output ports of the wrist camera, keyed by the station's names;
            None without a camera.
    """
    inputs = {}
    outputs = {}
    for system in systems:
        for i in range(system.num_input_ports()):
            port = system.get_input_port(i)
            inputs[port.get_name()] = port
        for i in range(system.num_output_ports()):
            port = system.get_output_port(i)
            outputs[port.get_name()] = port
    if camera is not None:
        outputs.update(camera)
    for port in ports.station_ports(description, camera is not None):
        if port.direction == ports.INPUT:
            builder.ExportInput(inputs[port.name], port.name)
        else:
            builder.ExportOutput(outputs[port.name], port.name)
