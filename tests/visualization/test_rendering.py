"""The page as a browser really draws it."""

import numpy as np
import pytest
import screenshot
from pydrake.math import RigidTransform
from pydrake.systems.framework import DiagramBuilder
from pydrake.systems.sensors import ImageIo

from remosplat_drake.splat.gaussian_splat import GaussianSplat
from remosplat_drake.visualization.robot_view import AddRobotView
from remosplat_drake.visualization.splat_view import SplatView

SIZE = (700, 450)


def red_wall() -> GaussianSplat:
    """A square metre of red discs that faces the camera."""
    u, v = np.meshgrid(np.linspace(-0.5, 0.5, 20), np.linspace(0, 1, 20))
    n = u.size
    half = np.sqrt(0.5)
    return GaussianSplat(
        p_GK=np.stack([u.ravel(), 0 * u.ravel(), v.ravel()], axis=1),
        quaternions=np.tile([half, half, 0.0, 0.0], (n, 1)),
        scales=np.full((n, 2), 0.04),
        opacities=np.full(n, 0.9),
        colors=np.tile([0.9, 0.05, 0.05], (n, 1)),
    )


@pytest.mark.slow
@pytest.mark.browser
@pytest.mark.skipif(
    screenshot.find_chromium() is None, reason="needs chromium on the PATH"
)
def test_browser_shows_robot_splat_and_floor(
    page, frankie, tmp_path, without_meshes
):
    builder = DiagramBuilder()
    builder.ExportInput(AddRobotView(builder, frankie, page), "q")
    diagram = builder.Build()
    context = diagram.CreateDefaultContext()
    q = np.array([0.0, 0.0, 0.0, *frankie.home])
    diagram.GetInputPort("q").FixValue(context, q)
    diagram.ForcedPublish(context)
    SplatView(page, red_wall(), RigidTransform([1.5, 0.0, 0.0]))
    page.save_html(tmp_path / "page.html")

    screenshot.take_screenshot(
        tmp_path / "page.html", tmp_path / "page.png", SIZE
    )
    image = ImageIo().Load(tmp_path / "page.png").data[:, :, :3].astype(int)
    # Of the scene, without what is above and beside it.
    image = image[44:, : SIZE[0] - 260]
    red, green, blue = np.moveaxis(image, 2, 0)
    brightness = image.mean(axis=2)
    colourless = np.ptp(image, axis=2) < 8
    share = {
        "splat": np.mean((red > 90) & (green < 60) & (blue < 60)),
        "white arm": np.mean((brightness > 205) & colourless),
        "dark base": np.mean((brightness < 110) & colourless),
        "floor": np.mean(abs(brightness - np.median(brightness)) < 15),
    }
    assert share["splat"] > 0.02
    assert share["white arm"] > 0.005
    assert share["dark base"] > 0.005
    assert 0.3 < share["floor"] < 0.98, share
