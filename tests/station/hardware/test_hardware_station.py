"""The hardware station has the ports of every station, and no other."""

import numpy as np
import pytest
from pydrake.systems.framework import Diagram, PortDataType

from remosplat_drake.errors import RemoSplatError
from remosplat_drake.station.config import KinematicStation, WristCameraConfig
from remosplat_drake.station.hardware.config import HardwareConfig
from remosplat_drake.station.simulated_station import MakeHardwareStation

MEMORY = HardwareConfig(lcm_url="memq://")


def make(robot, camera=None, hardware: HardwareConfig | None = MEMORY):
    return MakeHardwareStation(
        config=KinematicStation(),
        robot=robot,
        scene=None,
        q0=np.zeros(robot.n_q),
        wrist_camera=camera,
        hardware=hardware,
    )


def exported(station: Diagram) -> list[tuple]:
    """(name, size, type of the value) of all ports, in order."""
    found = []
    for i in range(station.num_input_ports()):
        port = station.get_input_port(i)
        found.append((port.get_name(), port.size(), None))
    for i in range(station.num_output_ports()):
        port = station.get_output_port(i)
        vector = port.get_data_type() == PortDataType.kVectorValued
        content = None if vector else type(port.Allocate())
        found.append((port.get_name(), port.size(), content))
    return [port for port in found if not port[0].startswith("cheat.")]


@pytest.mark.parametrize("camera", [None, WristCameraConfig(width=8, height=6)])
def test_its_ports_are_those_of_the_simulated_station(frankie, camera):
    hardware = make(frankie, camera)
    assert exported(hardware) == exported(make(frankie, camera, None))
    outputs = [
        hardware.get_output_port(i).get_name()
        for i in range(hardware.num_output_ports())
    ]
    assert not any(name.startswith("cheat.") for name in outputs)


def test_a_plain_arm_has_only_an_arms_ports(three_link):
    assert exported(make(three_link)) == exported(make(three_link, None, None))


@pytest.mark.parametrize(
    "url",
    [
        "carrier://pigeon",
        "udpm://nonsense",
        "udpm://192.0.2.1:7667",
        "udpm://239.255.76.67:99999",
        "",
    ],
)
def test_a_url_that_cannot_be_opened_is_named(frankie, url):
    with pytest.raises(RemoSplatError, match=f"LCM URL '{url}'"):
        make(frankie, hardware=HardwareConfig(lcm_url=url))
