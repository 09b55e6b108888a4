"""A whole session at the cockpit with objects, in a real browser."""

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

pytest.importorskip("viser")

from browser import find_chromium
from cockpit_session import insist, open_session
from cockpit_tab import CockpitTab
from found_scene import CAN, write_found_scene

from remosplat_drake.app.scenario import load_scenario
from remosplat_drake.app.world import World, load_world
from remosplat_drake.cockpit.viewpoints import SCENE, viewpoint
from remosplat_drake.robot import planar_pose
from remosplat_drake.scene.objects.scene_object import find_object

NAME = "TableObjects"

FOV = np.radians(75.0)
"""Vertical field of view of viser's camera at the start [rad]."""


@pytest.mark.slow
@pytest.mark.browser
@pytest.mark.skipif(
    find_chromium() is None, reason="needs chromium on the PATH"
)
def test_an_operator_takes_a_can_and_puts_it_on_the_tray(tmp_path):
    """The objects are chosen by clicks in the scene."""
    world = load_world(load_scenario(NAME))
    with open_session(NAME, tmp_path / "session") as operator:
        for name in ("box", "soup can"):
            click(operator, world, name)
        insist(
            operator,
            lambda: operator.press("Take it"),
            "pick the soup can: lifts the soup can",
        )
        assert "✓ approaches the soup can" in operator.text
        operator.tab.save_picture(tmp_path / "takes.png")
        operator.wait_for_text("hold: pick the soup can: done")
        choose(operator, "box")
        click(operator, world, "tray")
        insist(
            operator,
            lambda: operator.press("Put it there"),
            "hold: place the soup can: done",
        )
        operator.tab.save_picture(tmp_path / "placed.png")


@pytest.mark.slow
@pytest.mark.browser
@pytest.mark.skipif(
    find_chromium() is None, reason="needs chromium on the PATH"
)
def test_a_click_makes_a_can_of_the_map_an_object(tmp_path):
    name = write_found_scene(tmp_path)
    world = load_world(load_scenario(name))
    with open_session(name, tmp_path / "session") as operator:
        click_at(operator, world, CAN)
        operator.wait_for_text("Make it an object")
        insist(
            operator,
            lambda: operator.press("Make it an object"),
            "find an object: object 1 is a cylinder of 6",
        )
        operator.tab.wait_for(chosen("object 1"))
        operator.tab.save_picture(tmp_path / "found.png")
        insist(
            operator,
            lambda: operator.press("Take it"),
            "hold: pick the object 1: done",
        )
        assert "Make it an object" not in operator.text


def click(operator: CockpitTab, world: World, name: str):
    """Clicks on an object in the scene, as it is seen at the start."""
    p_WO = find_object(world.objects, name).X_WO.translation()
    click_at(operator, world, p_WO)
    operator.tab.wait_for(chosen(name))


def chosen(name: str) -> str:
    """Whether the list of objects shows a name, in JavaScript."""
    return (
        "[...document.querySelectorAll('input')]"
        f".some(i => i.value == '{name}')"
    )


def click_at(operator: CockpitTab, world: World, p_W: np.ndarray):
    """Clicks on a point in the scene, as it is seen at the start."""
    X_WE = world.robot.end_effector_pose(world.q0)
    X_WB = planar_pose.matrix(world.q0[:3])
    look: Any = SimpleNamespace(X_WT=X_WE, X_WE=X_WE, X_WB=X_WB)
    view = viewpoint(SCENE, look)
    ahead = view.p_WT - view.p_WC
    ahead /= np.linalg.norm(ahead)
    right = np.cross(ahead, view.up_W)
    right /= np.linalg.norm(right)
    off = p_W - view.p_WC
    x, y = right @ off, -np.cross(right, ahead) @ off
    left, top, width, height = operator.tab.evaluate(
        "(r => [r.x, r.y, r.width, r.height])"
        "(document.querySelector('canvas').getBoundingClientRect())"
    )
    scale = 0.5 * height / (np.tan(0.5 * FOV) * (ahead @ off))
    operator.click_at(
        left + 0.5 * width + scale * x, top + 0.5 * height + scale * y
    )


def choose(operator: CockpitTab, name: str):
    """Chooses an object of the list."""
    field = "input[value='soup can']"
    operator.tab.click(field)
    option = "[...document.querySelectorAll('[role=option]')]"
    operator.tab.wait_for(f"{option}.some(o => o.innerText == '{name}')")
    operator.tab.click("[role=option]", text=name)
