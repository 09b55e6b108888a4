"""Checks whether a camera's image contradicts its assumed pose.

New objects hide the map's surfaces, and a person close to a camera hides all of
them. But no new object makes a camera see free space behind a wall. So if a
camera measures depths behind most of the surface points that it should see, its
pose or the map is wrong.
"""

import numpy as np

from remosplat_drake.detection.depth_image import DepthImage
from remosplat_drake.detection.detection_config import DetectionConfig
from remosplat_drake.detection.known_scene import KnownScene

_FEWEST = 30
"""A pose is checked if at least this many surface points are visible."""

_MOST_THROUGH = 0.5
"""A camera's pose is wrong if the camera measures depths behind more than this
fraction of the visible surface points.
"""


def contradiction(
    image: DepthImage, scene: KnownScene, config: DetectionConfig
) -> str:
    """Returns the reason why an image contradicts its camera pose.

    Args:
        image: The depth image.
        scene: The map, with points of its surfaces.
        config: Settings, with errors and margins.

    Returns:
        The reason; empty if there is no contradiction.
    """
    p_C, measured = image.depths_at(scene.surface_W)
    z = p_C[:, 2]
    off = measured - z
    counts = (z < config.range) & ~np.isnan(measured)
    margin = 2 * config.margin(z)
    through = int((counts & (off > margin)).sum())
    agreeing = int((counts & (np.abs(off) <= margin)).sum())
    if through + agreeing < _FEWEST:
        return ""
    share = through / (through + agreeing)
    if share <= _MOST_THROUGH:
        return ""
    return (
        f"measures free space behind {100 * share:.0f} % of the map's surfaces:"
        " its pose or the map is wrong; calibrate the camera, or map again"
    )
