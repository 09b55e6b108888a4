"""Camera poses of the views that a person can select on the page."""

import dataclasses as dc

import numpy as np

from remosplat_drake.cockpit.messages import PageContent

SCENE, HAND, TARGET, TOP, FOLLOW = "Scene", "Hand", "Target", "Top", "Follow"
"""Names of the views; FOLLOW moves along with the base."""

VIEWS = (SCENE, HAND, TARGET, TOP, FOLLOW)
"""All views, in their order on the page."""


@dc.dataclass(frozen=True, eq=False)
class Viewpoint:
    """Pose of a camera.

    Attributes:
        p_WC: Position of the camera in W, shape (3,) [m].
        p_WT: Point that it looks at, shape (3,) [m].
        up_W: The upward direction of the picture, shape (3,).
    """

    p_WC: np.ndarray
    p_WT: np.ndarray
    up_W: np.ndarray


def viewpoint(view: str, content: PageContent) -> Viewpoint:
    """Returns the pose of the camera that shows a view.

    Args:
        view: One of `VIEWS`; FOLLOW and SCENE have the same pose.
        content: The present content of the page.
    """
    up = np.array([0.0, 0.0, 1.0])
    p_WT = content.X_WT[:3, 3].astype(float)
    p_WE = content.X_WE[:3, 3].astype(float)
    if view == HAND:
        back = -content.X_WE[:3, 2] * np.array([1.0, 1.0, 0.0])
        if np.linalg.norm(back) < 0.3:
            back = np.array([-1.0, 0.0, 0.0])
        back /= np.linalg.norm(back)
        return Viewpoint(p_WE + 0.7 * back + 0.35 * up, p_WE, up)
    if view == TARGET:
        return Viewpoint(p_WT + np.array([-0.6, -0.6, 0.45]), p_WT, up)
    middle = 0.5 * (content.X_WB[:3, 3] + p_WE)
    if view == TOP:
        # A camera that looks straight down has no upward direction, so the
        # robot's forward direction is used.
        ahead = content.X_WB[:3, 0].astype(float)
        return Viewpoint(middle + 3.5 * up - 0.01 * ahead, middle, ahead)
    turn = content.X_WB[:3, :3]
    away = turn @ np.array([-1.5, -1.7, 1.4])
    return Viewpoint(middle + away, middle + 0.2 * up, up)
