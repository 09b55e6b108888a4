"""A table that a thing comes to and goes from, and cameras above it."""

from functools import cache

import numpy as np
from pydrake.math import RigidTransform

from remosplat_drake.capture.capture import Capture
from remosplat_drake.capture.rendering.camera_poses import look_at
from remosplat_drake.capture.rendering.synthetic import render_capture
from remosplat_drake.scene.primitive_scene import Box, PrimitiveScene

TOP = 0.43
"""Height of the table's top [m]."""

TABLE = Box(RigidTransform([1, 0, 0.4]), np.array([0.5, 0.5, 0.03]))
THING = Box(RigidTransform([1, 0, 0.53]), np.array([0.1, 0.1, 0.1]))
"""A box on the table, 0.2 m high."""


def table(*things: Box) -> PrimitiveScene:
    """The table and what stands on it."""
    return PrimitiveScene((TABLE, *things)).with_floor()


@cache
def bare_table() -> Capture:
    """Four views of the bare table."""
    return _views(table(), 0, 1.5, 3, 4.5)


@cache
def laden_table() -> Capture:
    """Three views of the table with the thing on it."""
    return _views(table(THING), 0.5, 2.5, 4.5)


def joined(*captures: Capture) -> Capture:
    """One capture after the other."""
    return Capture(
        *(
            np.concatenate([getattr(c, name) for c in captures])
            for name in ("K", "X_WC", "rgb", "depth")
        )
    )


def _views(scene: PrimitiveScene, *azimuths: float) -> Capture:
    """What cameras see that look down at the table from some sides [rad]."""
    center = np.array([1, 0, 0.5])
    sides = np.array([[np.cos(a), np.sin(a), 0.9] for a in azimuths])
    poses = [look_at(center + 0.8 * side, center) for side in sides]
    return render_capture(scene, poses, 160, 120)
