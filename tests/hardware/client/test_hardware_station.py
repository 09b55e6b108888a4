"""The hardware station has the ports of every station, and no other."""

import numpy as np
import pytest
from pydrake.systems.framework import Diagram, PortDataType

from remosplat_drake.base.errors import RemoSplatError
from remosplat_drake.camera.wrist_camera_config import WristCameraConfig
from remosplat_drake.hardware.client.hardware_station import HardwareStation
from remosplat_drake.hardware.hardware_config import HardwareConfig
from remosplat_drake.station.simulated_station import MakeSimulatedStation
from remosplat_drake.station.station_config import KinematicStation


def make(robot, camera=False, url="memq://") -> Diagram:
    config = HardwareConfig(lcm_url=url)
    return HardwareStation(config=config, robot=robot, wrist_camera=camera)


def make_simulated(robot, camera=False) -> Diagram:
    return MakeSimulatedStation(
        config=KinematicStation(),
        robot=robot,
        scene=None,
        q0=np.zeros(robot.n_q),
        wrist_camera=WristCameraConfig(width=8, height=6) if camera else None,
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


@pytest.mark.parametrize("camera", [False, True])
def test_its_ports_are_those_of_the_simulated_station(frankie, camera):
    hardware = make(frankie, camera)
    assert exported(hardware) == exported(make_simulated(frankie, camera))
    outputs = [
        hardware.get_output_port(i).get_name()
        for i in range(hardware.num_output_ports())
    ]
    assert not any(name.startswith("cheat.") for name in outputs)


def test_a_plain_arm_has_only_an_arms_ports(three_link):
    assert exported(make(three_link)) == exported(make_simulated(three_link))


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
        make(frankie, url=url)
