"""Tests of the robot's spheres."""

import dataclasses as dc

import numpy as np
import pytest

from remosplat_drake.robot.fitting.link_spheres import LinkSpheres
from remosplat_drake.robot.payload import Payload
from remosplat_drake.signals.distance_field import Clearances
from remosplat_drake.signals.tick_report import TickReport
from remosplat_drake.visualization.sphere_view import (
    SPHERES,
    SphereView,
    clearance_colors,
)


def tick(near: Clearances, payload: Payload | None = None) -> TickReport:
    """The report of a tick that has found these clearances."""
    before = TickReport.before_first(10, 9)
    return dc.replace(before, clearances=near, payload=payload)


@pytest.fixture
def q(frankie) -> np.ndarray:
    return np.array([1.0, 2.0, 0.5, *frankie.home])


def test_spheres_are_where_the_model_has_them(
    page, frankie, q, pose_of, is_visible
):
    """Hidden ones, too: each page shows them when its onlooker wants."""
    dut = SphereView(page, frankie)
    dut.update(q, tick(Clearances.none()), time=0.0)
    assert not is_visible(page.meshcat, SPHERES)
    p_WS = frankie.spheres_at(q).p_WS
    for i, link in enumerate(frankie.spheres.links):
        X_WL = pose_of(page.meshcat, f"{SPHERES}/{link}")
        X_LS = pose_of(page.meshcat, f"{SPHERES}/{link}/{i}")
        np.testing.assert_allclose((X_WL @ X_LS)[:3, 3], p_WS[i], atol=1e-12)


def test_near_sphere_changes_its_colour(page, frankie, q):
    dut = SphereView(page, frankie)
    near = Clearances(
        np.array([5]), np.array([0.01]), np.eye(3)[:1], np.zeros((1, 3))
    )
    dut.update(q, tick(near), time=0.0)

    def color(i):
        path = f"{SPHERES}/{frankie.spheres.links[i]}/{i}/<object>"
        page.scene.settle()
        return page.meshcat._GetPackedProperty(path, "color")

    assert color(5) != b""
    assert color(6) == b""
    red = color(5)
    dut.update(q, tick(Clearances.none()), time=0.1)
    assert color(5) != red


def test_spheres_of_a_payload_are_not_drawn(page, frankie, q):
    spheres = LinkSpheres(np.zeros((1, 3)), np.array([0.05]))
    can = Payload("can", "panda_hand", np.eye(4), spheres, (np.eye(3),))
    n = len(frankie.spheres)
    near = Clearances(
        np.array([n]), np.array([0.01]), np.eye(3)[:1], np.zeros((1, 3))
    )
    SphereView(page, frankie).update(q, tick(near, can), time=0.0)


def test_colours_run_from_red_to_blue():
    near, far, beyond = clearance_colors(np.array([-0.1, 0.3, np.inf]))
    assert near.argmax() == 0
    assert far.argmax() == 2
    np.testing.assert_array_equal(far, beyond)
