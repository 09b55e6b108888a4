"""Checks that a station has the ports that controllers require."""

from collections.abc import Iterator

from pydrake.systems.framework import PortDataType, System

from remosplat_drake.base.errors import RemoSplatError
from remosplat_drake.robot.robot_description import RobotDescription
from remosplat_drake.signals.station_ports import (
    CHEAT,
    INPUT,
    OUTPUT,
    station_ports,
)


def check_station(
    station: System,
    description: RobotDescription,
    wrist_camera: bool,
    name: str,
) -> None:
    """Raises an error if a controller cannot be connected to a station.

    Args:
        station: The station.
        description: The robot.
        wrist_camera: Whether there is a wrist camera.
        name: Name of the station, for errors.

    Raises:
        RemoSplatError: Ports are missing, have another size, or are unknown.
    """
    problems = list(_problems(station, description, wrist_camera))
    if problems:
        raise RemoSplatError(f"station: {name}: {'; '.join(problems)}")


def _problems(
    station: System, description: RobotDescription, wrist_camera: bool
) -> Iterator[str]:
    wanted = {
        (port.direction, port.name): port.size
        for port in station_ports(description, wrist_camera)
    }
    found = _ports(station)
    for port in wanted.keys() - found.keys():
        yield f"has no {' '.join(port)}"
    for port in found.keys() - wanted.keys():
        if not port[1].startswith(CHEAT):
            yield f"has an unknown {' '.join(port)}"
    for port in wanted.keys() & found.keys():
        if found[port] != wanted[port]:
            sizes = [_shown(ports[port]) for ports in (wanted, found)]
            yield f"{' '.join(port)}: expected {sizes[0]}, got {sizes[1]}"


def _ports(station: System) -> dict[tuple[str, str], int | None]:
    """Returns the sizes of all ports by direction and name (None: abstract)."""
    ports = [
        (INPUT, station.get_input_port(i))
        for i in range(station.num_input_ports())
    ]
    ports += [
        (OUTPUT, station.get_output_port(i))
        for i in range(station.num_output_ports())
    ]
    return {
        (direction, port.get_name()): port.size()
        if port.get_data_type() == PortDataType.kVectorValued
        else None
        for direction, port in ports
    }


def _shown(size: int | None) -> str:
    return "an abstract value" if size is None else f"a vector of {size}"
