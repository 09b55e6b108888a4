"""`draw_first`: draws robot and scene while a run is prepared."""

import numpy as np

from remosplat_drake.robot.robot_model import RobotModel
from remosplat_drake.splat.gaussian_splat import GaussianSplat
from remosplat_drake.visualization.page import MeshcatPage
from remosplat_drake.visualization.robot_view import RobotView
from remosplat_drake.visualization.splat_view import SURFELS, draw_surfels

COARSE = 5_000
"""Number of discs that are drawn; the largest discs of the splat are chosen."""


def draw_first(
    page: MeshcatPage,
    robot: RobotModel,
    q: np.ndarray,
    splat_W: GaussianSplat | None = None,
) -> None:
    """Draws the robot and the map's largest discs, before the diagram is built.

    Later, the diagram's views draw the whole map, and keep the drawn robot.

    Args:
        page: The page to draw on.
        robot: The robot.
        q: Configuration at the start, shape (n_q,).
        splat_W: The map's splat in W; None if the map has no splat.
    """
    view = RobotView(page=page, robot=robot)
    context = view.CreateDefaultContext()
    view.GetInputPort("configuration").FixValue(context, q)
    view.ForcedPublish(context)
    if splat_W is not None:
        draw_surfels(page.meshcat, SURFELS, splat_W, COARSE)
