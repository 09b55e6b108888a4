"""Synthetic RGB-D captures of primitive scenes, with exact depth.

The primitives are the ground truth, so all errors of a splat that is trained on
such a capture come from the reconstruction.
"""

from collections.abc import Sequence

from pydrake.math import RigidTransform

from remosplat_drake.base.errors import RemoSplatError
from remosplat_drake.capture.capture import Capture
from remosplat_drake.capture.rendering.camera_poses import CLEARANCE, survey
from remosplat_drake.capture.rendering.renderer import (
    FIELD_OF_VIEW,
    render_views,
)
from remosplat_drake.capture.rendering.solids import primitive_solids
from remosplat_drake.oracle.signed_distance import SignedDistanceField
from remosplat_drake.scene.primitive_scene import PrimitiveScene

_LOWEST = 0.1
"""Height of the floor of every scene [m], even if no solid represents the
floor.
"""


def render_capture(
    scene: PrimitiveScene,
    poses: Sequence[RigidTransform],
    width: int = 640,
    height: int = 480,
    fov_y: float = FIELD_OF_VIEW,
) -> Capture:
    """Renders a capture of a scene of primitives, see `render_views`.

    Args:
        scene: The scene.
        poses: Camera poses X_WC (OpenCV axes).
        width: Width of each image [pixels].
        height: Height of each image [pixels].
        fov_y: Vertical field of view [rad].
    """
    return render_views(primitive_solids(scene), poses, width, height, fov_y)


def survey_poses(
    scene: PrimitiveScene,
    n: int = 120,
    seed: int = 0,
    clearance: float = CLEARANCE,
) -> list[RigidTransform]:
    """Chooses camera poses X_WC around a scene's target; see `survey`.

    Args:
        scene: The scene.
        n: Number of poses.
        seed: Seed of the random choice.
        clearance: Least distance of a camera from every solid [m].

    Raises:
        RemoSplatError: The scene has no target, or not enough free camera
            positions.
    """
    if scene.X_WE_target is None:
        raise RemoSplatError(f"{scene.name} has no target to look at")
    focus = scene.X_WE_target.translation()
    field = SignedDistanceField(scene)
    return survey(field, focus, n, seed, clearance=clearance, lowest=_LOWEST)
