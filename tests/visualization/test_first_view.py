"""Robot and map are on the page before a run is prepared."""

import numpy as np
import pytest
from browser import find_chromium, open_browser
from pydrake.systems.framework import DiagramBuilder

from remosplat_drake.commands import run as run_command
from remosplat_drake.commands.main import main
from remosplat_drake.splat.gaussian_splat import GaussianSplat
from remosplat_drake.visualization import first_view
from remosplat_drake.visualization.first_view import draw_first
from remosplat_drake.visualization.page_state import preparing
from remosplat_drake.visualization.robot_view import PREFIX, AddRobotView
from remosplat_drake.visualization.splat_view import SURFELS, SplatView

HAND = f"{PREFIX}/hand/panda_hand"


def make_splat(count: int) -> GaussianSplat:
    rng = np.random.default_rng(1)
    return GaussianSplat(
        p_GK=rng.uniform(-1, 1, (count, 3)),
        quaternions=np.tile((1.0, 0.0, 0.0, 0.0), (count, 1)),
        scales=rng.uniform(0.01, 0.03, (count, 2)),
        opacities=np.ones(count),
        colors=rng.uniform(0, 1, (count, 3)),
    )


def test_a_share_of_the_map_comes_first(page, frankie, pose_of, monkeypatch):
    monkeypatch.setattr(first_view, "COARSE", 50)
    splat = make_splat(500)
    q = frankie.q_home
    draw_first(page, frankie, q, splat)
    X_WL = frankie.body_poses(q)[frankie.tree.index("panda_hand")]
    np.testing.assert_allclose(pose_of(page.meshcat, HAND), X_WL, atol=1e-9)
    assert b'"count":50,' in page.meshcat._GetPackedObject(SURFELS)
    SplatView(page, splat)
    assert b'"count":500,' in page.meshcat._GetPackedObject(SURFELS)


def test_it_is_drawn_before_the_kernels_are_compiled(monkeypatch, tmp_path):
    """The page is asked in the middle of a run's preparation."""
    pages, seen = [], []
    open_page, compile_kernels = (
        run_command.open_page,
        run_command.compile_kernels,
    )

    def opened(*arguments, **options):
        pages.append(open_page(*arguments, **options))
        return pages[-1]

    def compiled(*arguments, **options):
        (page,) = pages
        paths = HAND, SURFELS
        seen.append([page.meshcat.HasPath(path) for path in paths])
        compile_kernels(*arguments, **options)

    monkeypatch.setattr(run_command, "open_page", opened)
    monkeypatch.setattr(run_command, "compile_kernels", compiled)
    replay = tmp_path / "replay.html"
    command = ["run", "TableReach", "--headless", "--save-html", str(replay)]
    assert main(command) == 0
    assert seen == [[True, True]]
    assert replay.stat().st_size > 1e5


@pytest.mark.slow
@pytest.mark.browser
@pytest.mark.skipif(
    find_chromium() is None, reason="needs chromium on the PATH"
)
def test_a_browser_has_the_robot_while_it_waits(page, frankie):
    """And keeps it: the views of the diagram do not send it again."""
    link = "viewer.scene_tree.find(['remosplat', 'robot', 'hand'])"
    hand = f"{link}.children['panda_hand']?.children"
    with open_browser((600, 400)) as tab:
        tab.draw_nothing()
        tab.open(page.url)
        page.show(preparing("loading the map and the robot"))
        draw_first(page, frankie, frankie.q_home)
        tab.wait_for(f"Object.keys({hand} ?? {{}}).length > 0")
        tab.wait_for("document.body.innerText.includes('loading the map')")
        tab.evaluate(
            f"window.before = {link}.children['panda_hand'].object, true"
        )
        AddRobotView(DiagramBuilder(), frankie, page)
        draw_first(page, frankie, frankie.q_home, make_splat(10))
        tab.wait_for(
            "viewer.scene_tree.find(['remosplat', 'splat', 'surfels'])"
            ".object.children.length > 0"
        )
        now = f"{link}.children['panda_hand'].object"
        assert tab.evaluate(f"{now} === before")
