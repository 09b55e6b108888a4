"""Every station has the ports of the table, names and sizes alike."""

import numpy as np
import pytest
from pydrake.systems.framework import Diagram, PortDataType

from remosplat_drake.base.errors import RemoSplatError
from remosplat_drake.camera.wrist_camera_config import WristCameraConfig
from remosplat_drake.signals import station_ports as ports
from remosplat_drake.station.simulated_station import MakeSimulatedStation
from remosplat_drake.station.station_config import (
    DynamicStation,
    KinematicStation,
)

CONFIGS = [KinematicStation(), DynamicStation()]


def make(robot, config, camera=None, **kwargs) -> Diagram:
    q0 = np.zeros(robot.n_q)
    q0[robot.n_q - len(robot.home) :] = robot.home
    return MakeSimulatedStation(
        config=config,
        robot=robot,
        scene=None,
        q0=kwargs.pop("q0", q0),
        wrist_camera=camera,
        **kwargs,
    )


def exported(station: Diagram) -> set[tuple[str, str, int | None]]:
    """(name, direction, size) of all ports that are not ground truth."""
    found = set()
    for direction, count, get in (
        (ports.INPUT, station.num_input_ports(), station.get_input_port),
        (ports.OUTPUT, station.num_output_ports(), station.get_output_port),
    ):
        for i in range(count):
            port = get(i)
            vector = port.get_data_type() == PortDataType.kVectorValued
            size = port.size() if vector else None
            if not port.get_name().startswith("cheat."):
                found.add((port.get_name(), direction, size))
    return found


def table(robot, camera: bool) -> set[tuple[str, str, int | None]]:
    return {
        (port.name, port.direction, port.size)
        for port in ports.station_ports(robot.description, camera)
    }


@pytest.mark.parametrize("config", CONFIGS)
def test_frankies_ports_are_those_of_the_table(frankie, config):
    assert exported(make(frankie, config)) == table(frankie, camera=False)


@pytest.mark.parametrize("config", CONFIGS)
def test_the_camera_adds_its_ports(frankie, config):
    station = make(frankie, config, WristCameraConfig(width=8, height=6))
    assert exported(station) == table(frankie, camera=True)
    assert station.HasOutputPort("cheat.query_object")


@pytest.mark.parametrize("config", CONFIGS)
def test_a_plain_arm_has_only_an_arms_ports(three_link, config):
    assert exported(make(three_link, config)) == {
        ("arm.velocity_commanded", ports.INPUT, 3),
        ("arm.position_measured", ports.OUTPUT, 3),
        ("arm.velocity_measured", ports.OUTPUT, 3),
        ("status", ports.OUTPUT, None),
    }


def test_the_table_for_frankie(frankie):
    """The names and sizes that the README and the drivers rely on."""
    assert table(frankie, camera=True) == {
        ("base.velocity_commanded", "input", 2),
        ("panda.velocity_commanded", "input", 7),
        ("hand.command", "input", 2),
        ("base.pose_measured", "output", 3),
        ("base.velocity_measured", "output", 2),
        ("panda.position_measured", "output", 7),
        ("panda.velocity_measured", "output", 7),
        ("hand.state", "output", 3),
        ("wrist_camera.rgb", "output", None),
        ("wrist_camera.depth", "output", None),
        ("status", "output", None),
    }


def test_each_hand_has_ports(two_pandas):
    ports = table(two_pandas, camera=False)
    for side in ("left", "right"):
        assert (f"{side}_hand.command", "input", 2) in ports
        assert (f"{side}_hand.state", "output", 3) in ports
    station = make(two_pandas, KinematicStation())
    names = {station.get_input_port(i).get_name() for i in range(3)}
    assert "left_hand.command" in names and "right_hand.command" in names


def test_ground_truth_is_marked_as_cheating(frankie):
    station = make(frankie, DynamicStation())
    names = {
        station.get_output_port(i).get_name()
        for i in range(station.num_output_ports())
    } - {name for name, _, _ in table(frankie, camera=False)}
    assert names == {"cheat.query_object", "cheat.contact"}


def test_without_a_camera_there_is_no_geometry(frankie):
    station = make(frankie, KinematicStation())
    assert [s.get_name() for s in station.GetSystems()] == ["kinematic_robot"]


@pytest.mark.parametrize("q0", [np.zeros(9), np.full(10, np.nan)])
def test_a_bad_start_is_refused(frankie, q0):
    with pytest.raises(RemoSplatError, match="q0: expected 10 finite"):
        make(frankie, KinematicStation(), q0=q0)


@pytest.mark.parametrize(
    ("config", "field", "value"),
    [
        (KinematicStation, "hand_speed", 0),
        (DynamicStation, "time_step", -1),
        (DynamicStation, "discrete_contact_approximation", "tamsi"),
        (WristCameraConfig, "frame", "elbow_camera"),
        (WristCameraConfig, "fov_y_deg", 180),
        (WristCameraConfig, "max_depth", 0.01),
        (WristCameraConfig, "translation", [1.0]),
    ],
)
def test_bad_settings_are_named(frankie, config, field, value):
    station, camera = KinematicStation(), None
    changed = config()
    # Assigned later, where no constructor looks.
    setattr(changed, field, value)
    if config is WristCameraConfig:
        camera = changed
    else:
        station = changed
    with pytest.raises(RemoSplatError, match=field):
        make(frankie, station, camera)
