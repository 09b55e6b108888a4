"""The `pydrake_system` block of a system lists its ports, all and no others."""

import ast
import dataclasses as dc
import inspect
import re
from collections.abc import Iterator

import pytest
from pydrake.lcm import DrakeLcm
from pydrake.systems.framework import Diagram, System
from sources import PACKAGE, parsed

from apps.studies.told_operator import ToldOperator
from remosplat_drake.app.diagram import build
from remosplat_drake.app.scenario import load_scenario
from remosplat_drake.app.teleop_session import open_teleoperation
from remosplat_drake.app.world import load_world
from remosplat_drake.cockpit.cockpit_process import CockpitProcess
from remosplat_drake.controller.prediction.motion_predictor import (
    MotionPredictor,
)
from remosplat_drake.detection.map_announcer import MapAnnouncer
from remosplat_drake.hardware.client.hardware_station import HardwareStation
from remosplat_drake.hardware.hardware_config import HardwareConfig
from remosplat_drake.hardware.mover_sensing_config import MoverSensingConfig
from remosplat_drake.mapping.localization.base_localization import (
    BaseLocalization,
)
from remosplat_drake.robot.actuators import Actuator, ActuatorModel
from remosplat_drake.station.actuated_command import ActuatedCommand
from remosplat_drake.task.velocity_profile import VelocityProfile
from remosplat_drake.teleop.lcm_operator import LcmOperator
from remosplat_drake.teleop.teleop_config import PoseStreamConfig
from remosplat_drake.teleop.trajectory_operator import TrajectoryOperator
from remosplat_drake.visualization.page import MeshcatPage

BLOCK = ".. pydrake_system::"


def classes_with_a_block() -> Iterator[str]:
    """Names of the package's classes whose docstring has such a block."""
    for path in sorted(PACKAGE.rglob("*.py")):
        # Collecting the tests parses these modules only.
        if BLOCK not in path.read_text():
            continue
        for node in ast.walk(parsed(path)):
            is_class = isinstance(node, ast.ClassDef)
            if is_class and BLOCK in (ast.get_docstring(node) or ""):
                yield node.name


def listed(system: System, direction: str) -> list[str]:
    """Patterns of the names that a block lists as input or output ports."""
    block = (inspect.getdoc(type(system)) or "").split(BLOCK)[1]
    found = re.search(rf"{direction}_ports:\n((?: *- .*\n?)*)", block)
    lines = re.findall("- (.*)", found[1]) if found else []
    return [
        re.escape(line.replace(" (optional)", ""))
        # `command_0 ...` stands for as many as there are,
        .replace(r"0\ \.\.\.", r"\d+")
        # and `<model instance>` for its name.
        .replace(r"<model\ instance>", ".+")
        for line in lines
    ]


def declared(system: System, direction: str) -> list[str]:
    """Names of a system's input or output ports."""
    count = getattr(system, f"num_{direction}_ports")()
    port = getattr(system, f"get_{direction}_port")
    return [port(i).get_name() for i in range(count)]


def parts(system: System) -> Iterator[System]:
    """A system and all that are in it."""
    yield system
    if isinstance(system, Diagram):
        for part in system.GetSystems():
            yield from parts(part)


@pytest.fixture(scope="module")
def systems(tmp_path_factory) -> Iterator[dict[str, System]]:
    """A system of each class, by the class' name."""
    scenario = load_scenario(
        "TableReach",
        "{mapping: {enabled: true}, movers: [{}], cameras: [{}],"
        " movers_from: cameras}",
    )
    world = load_world(scenario)
    teleoperation = open_teleoperation(
        scenario, world, tmp_path_factory.mktemp("session"), hardware=False
    )
    operated = build(
        scenario,
        world,
        MeshcatPage(),
        teleoperation=dc.replace(teleoperation, operator=ToldOperator()),
        cockpit=CockpitProcess(lambda issued: None),
    )
    dynamic = load_scenario(
        "TableReach",
        "{station: !DynamicStation {}, movers: [{}, !OtherRobot {}],"
        " mover_sensing: !StandingMovers {}}",
    )
    picking = load_scenario("TablePick", "{station: !DynamicStation {}}")
    taking = load_scenario("TableObjects")
    in_session = open_teleoperation(
        taking,
        load_world(taking),
        tmp_path_factory.mktemp("session"),
        hardware=False,
    )
    stream = PoseStreamConfig(lcm_url="memq://")
    axes = ActuatorModel.make([Actuator()] * 9)
    roots = [
        operated.diagram,
        build(dynamic, world, MeshcatPage()).diagram,
        build(picking, load_world(picking), MeshcatPage()).diagram,
        build(taking, page=MeshcatPage(), teleoperation=in_session).diagram,
        HardwareStation(
            config=HardwareConfig(
                lcm_url="memq://", movers=MoverSensingConfig()
            ),
            robot=world.robot,
            wrist_camera=True,
        ),
        LcmOperator(config=stream, period=0.1),
        TrajectoryOperator(steps=[]),
        BaseLocalization(n_q=10, period=0.1, speed=0.1),
        MotionPredictor(robot=world.robot, model=axes, period=0.1),
        ActuatedCommand(model=axes, step=0.1),
        MapAnnouncer(lcm=DrakeLcm("memq://"), channel="MAP"),
        VelocityProfile(robot=world.robot, period=0.1),
    ]
    yield {type(part).__name__: part for root in roots for part in parts(root)}
    teleoperation.close()


@pytest.mark.parametrize("name", sorted(classes_with_a_block()))
@pytest.mark.parametrize("direction", ["input", "output"])
def test_the_block_lists_the_ports(systems, name, direction):
    patterns = listed(systems[name], direction)
    names = declared(systems[name], direction)
    unlisted = [
        port
        for port in names
        if not any(re.fullmatch(pattern, port) for pattern in patterns)
    ]
    missing = [
        pattern
        for pattern in patterns
        if not any(re.fullmatch(pattern, port) for port in names)
    ]
    assert (unlisted, missing) == ([], [])
