"""A robot as what moves around another: its spheres are within its links."""

import numpy as np
import pytest
from pydrake.math import RigidTransform

from remosplat_drake.recording.mover_contacts import distances
from remosplat_drake.scene.mover import Mover, Movers
from remosplat_drake.scene.mover_camera import MoverCamera
from remosplat_drake.station.merged_movers import merge_movers
from remosplat_drake.station.robot_movers import link_movers, link_shapes

Q = np.array([0.3, -0.8, 0.2])
U = np.array([0.7, -0.4, 1.1])


@pytest.fixture(scope="module")
def movers(three_link) -> list[Mover]:
    return link_movers(
        three_link,
        link_shapes(three_link),
        Q,
        U,
        name="Bert",
        max_speed=1.5,
        max_acceleration=6.0,
    )


def test_there_is_one_for_each_link(three_link, movers):
    links = dict.fromkeys(three_link.spheres.links)
    assert [m.name for m in movers] == [f"Bert's {link}" for link in links]
    assert {m.max_speed for m in movers} == {1.5}


def test_all_spheres_are_within(three_link, movers):
    spheres = three_link.spheres_at(Q)
    for i, link in enumerate(dict.fromkeys(three_link.spheres.links)):
        of_link = np.array(three_link.spheres.links) == link
        distance, _ = distances(
            Movers(0.0, [movers[i]]).at(0.0),
            spheres.p_WS[of_link],
            np.zeros(of_link.sum()),
        )
        assert (distance[0] <= -spheres.radius[of_link] + 1e-9).all()


def test_they_move_as_the_links_do(three_link, movers):
    h = 1e-4
    before, after = (
        three_link.spheres_at(three_link.advance(Q, U, step)).p_WS
        for step in (-h, h)
    )
    now = three_link.spheres_at(Q).p_WS
    links = list(dict.fromkeys(three_link.spheres.links))
    for i, link in enumerate(three_link.spheres.links):
        mover = movers[links.index(link)]
        arm = now[i] - mover.X_WM.translation()
        v_W = mover.v_WM + np.cross(mover.w_WM, arm)
        np.testing.assert_allclose(
            v_W, (after[i] - before[i]) / (2 * h), atol=1e-6
        )


def test_movers_are_put_together():
    X_WC, wide = RigidTransform(), np.ones(2)
    camera = MoverCamera("room", X_WC, -wide, wide, 0.3, 4, 2.0)
    ball, box = (Mover.sphere(n, [0, 0, 0], 0.1) for n in ("ball", "box"))
    merged = merge_movers(
        [Movers(3.0, [ball]), Movers(2.0, [box], [camera], "it is dark")]
    )
    assert (merged.stamp, merged.problem) == (2.0, "it is dark")
    assert [m.name for m in merged] == ["ball", "box"]
    assert merged.cameras == (camera,)
