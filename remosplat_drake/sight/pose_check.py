"""Whether what a camera sees contradicts where it is believed to be.

Things that have come hide what the map shows, and whoever stands close before
a camera hides all of it. But nothing that comes lets a camera look through a
wall. So where points of the map's surfaces should be seen, and most of them
are looked through, it is the camera that is not where it should be, or the map
that is not.
"""

import numpy as np

from remosplat_drake.sight.depth_image import DepthImage
from remosplat_drake.sight.known_scene import KnownScene
from remosplat_drake.sight.sight_config import SightConfig

_FEWEST = 30
"""So many points must be seen before anything can be said."""

_MOST_THROUGH = 0.5
"""Share of them that must not be looked through."""


def contradiction(
    image: DepthImage, scene: KnownScene, config: SightConfig
) -> str:
    """Says whether an image contradicts its pose.

    Args:
        image: The depth image.
        scene: The map, with points of its surfaces.
        config: Errors and margins.

    Returns:
        What is wrong; empty if nothing is.
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
        f"looks through {100 * share:.0f} % of what the map shows:"
        " its pose or the map is wrong"
    )
