"""There is one way to a robot: the diagram, verified and supervised.

All that sends a command is listed here. To add another sender, one has to
come past this list.
"""

import ast
from collections.abc import Iterator
from functools import cache

import numpy as np
from sources import modules, nodes

from remosplat_drake.acceptance.hardware_processes import free_url
from remosplat_drake.hardware.client.robot_link import RobotLink
from remosplat_drake.hardware.doctor.drills import WatchedRobot
from remosplat_drake.hardware.hardware_config import HardwareConfig

FAR_SIDE = ("hardware/drivers/", "hardware/stand_in/", "hardware/wire/")
"""Beyond the wire commands are obeyed; what encodes them for both sides."""

STRANGER = "acceptance/stranger.py"
"""Plays another person in the lab, against whose commands guards are tested."""

LINK = "hardware/client/robot_link.py"

ENCODERS = {
    "encode_panda_command",
    "encode_base_command",
    "encode_hand_command",
    "encode_ramp",
}
"""What makes the packets that move a robot."""


@cache
def calls() -> list[tuple[str, str, str]]:
    """All calls on our side of the wire: module, caller and what is called."""
    return [
        (module, within, called(call))
        for module, tree in modules().items()
        if not module.startswith(FAR_SIDE)
        for within, call in calls_in(tree)
    ]


def calls_in(tree: ast.AST, within: str = "") -> Iterator[tuple[str, ast.Call]]:
    """All calls, each with the function or method that makes it."""
    for node in ast.iter_child_nodes(tree):
        inside = within
        if isinstance(node, ast.FunctionDef | ast.ClassDef):
            inside = f"{within}.{node.name}".lstrip(".")
        if isinstance(node, ast.Call):
            yield within, node
        yield from calls_in(node, inside)


def called(call: ast.Call) -> str:
    """The last part of what is called."""
    function = call.func
    if isinstance(function, ast.Attribute):
        return function.attr
    return function.id if isinstance(function, ast.Name) else ""


def callers(*names: str) -> set[tuple[str, str]]:
    """Callers of anything with such a name, as (module, function)."""
    return {(module, where) for module, where, name in calls() if name in names}


def test_only_the_link_makes_commands():
    made_in = {module for module, _ in callers(*ENCODERS)}
    assert made_in == {LINK, STRANGER}


def test_only_the_station_and_the_ramp_send_commands():
    """`bring_to_rest` goes down the ramp that was verified, and to zero."""
    with_links = {
        module
        for module in modules()
        if any(
            isinstance(node, ast.alias) and node.name == "RobotLink"
            for node in nodes(module)
        )
    }
    senders = {
        caller
        for caller in callers("send", "send_hand")
        if caller[0] in with_links
    }
    assert senders == {
        ("hardware/client/remote_robot.py", "RemoteRobot._send"),
        ("app/hardware_run.py", "bring_to_rest"),
    }
    assert callers("bring_to_rest") == {
        ("app/hardware_run.py", "run_on_hardware")
    }


def test_links_belong_to_stations_or_only_listen():
    assert callers("RobotLink") == {
        ("hardware/client/hardware_station.py", "HardwareStation.__init__"),
        ("hardware/doctor/drills.py", "WatchedRobot.__init__"),
    }
    assert callers("HardwareStation") == {
        ("app/stages/station.py", "MakeStation")
    }


def test_every_run_of_a_robot_is_the_diagrams():
    assert callers("HardwareLoop", "run_on_hardware") == {
        ("acceptance/fault_controller.py", "main"),
        ("app/hardware_run.py", "run_on_hardware"),
        ("app/velocity_run.py", "play"),
        ("commands/driving.py", "drive"),
    }


def test_a_watched_robot_cannot_be_sent_anything(frankie, monkeypatch):
    sent = []
    watched = WatchedRobot(HardwareConfig(lcm_url=free_url()), frankie)
    monkeypatch.setattr(
        type(watched._link.lcm), "Publish", lambda *packet: sent.append(packet)
    )
    watched._link.send(np.ones(frankie.n_u))
    watched._link.send_hand(0.1, 10.0)
    watched.listen()
    assert not sent
    free = RobotLink(HardwareConfig(lcm_url=free_url()), frankie)
    free.send(np.ones(frankie.n_u))
    assert sent
