"""`TruthView`: draws the true solids of a scene."""

from pydrake.geometry import Box, Cylinder, Rgba

from remosplat_drake.scene import primitive_scene as scenes
from remosplat_drake.visualization.page import MeshcatPage
from remosplat_drake.visualization.scene_look import ROOT
from remosplat_drake.visualization.toggle import on_off

TRUTH = f"{ROOT}/truth"

_COLOR = Rgba(0.10, 0.65, 0.60, 0.45)


class TruthView:
    """Draws the true scene as translucent boxes and cylinders.

    The solids are hidden until a viewer clicks their button.

    Args:
        page: The page to draw on.
        scene: The true scene.
    """

    def __init__(self, page: MeshcatPage, scene: scenes.PrimitiveScene):
        meshcat = page.meshcat
        for i, box in enumerate(scene.boxes):
            path = f"{TRUTH}/box_{i}"
            meshcat.SetObject(path, Box(*(2 * box.half_extents)), _COLOR)
            meshcat.SetTransform(path, box.X_WP)
        for i, cylinder in enumerate(scene.cylinders):
            path = f"{TRUTH}/cylinder_{i}"
            shape = Cylinder(cylinder.radius, 2 * cylinder.half_height)
            meshcat.SetObject(path, shape, _COLOR)
            meshcat.SetTransform(path, cylinder.X_WP)
        page.add_toggle(on_off("Ground truth", "3", TRUTH, shown=False))
