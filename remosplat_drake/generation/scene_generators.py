"""Generates random scenes: a family and a seed determine a scene.

The families are in `scene_families` and `room`. The rule that rejects scenes is
that of the published scenes. Random numbers are drawn in another way, so no
seed gives a published scene.
"""

import numpy as np

from remosplat_drake.base.errors import RemoSplatError, unknown_name
from remosplat_drake.generation import room, scene_families
from remosplat_drake.oracle.signed_distance import SignedDistanceField
from remosplat_drake.robot.sphere_model import Spheres
from remosplat_drake.scene.primitive_scene import PrimitiveScene

GENERATOR_VERSION = 1
"""Version of the generators, which is part of every scene's name. Increase it
whenever a seed gives another scene."""

TARGET_CLEARANCE = 0.025
"""The target point is at least this far from all obstacles [m]."""

PUBLISHED_FAMILIES = ("table", "bookshelf")
"""Families of the paper's benchmark, which are compared by default."""

FAMILIES = {
    "table": scene_families.table,
    "bookshelf": scene_families.bookshelf,
    "table2": scene_families.table2,
    "bookshelf2": scene_families.bookshelf2,
    "posts": scene_families.posts,
    "room": room.room,
}
"""Functions that build a scene, by the name of the family."""


def generate(family: str, seed: int) -> PrimitiveScene:
    """Generates the scene of a family and a seed, deterministically.

    Args:
        family: Name of the family, one of `FAMILIES`.
        seed: Any non-negative integer.

    Raises:
        RemoSplatError: The family does not exist.
    """
    if family not in FAMILIES:
        raise RemoSplatError(unknown_name("scene family", family, FAMILIES))
    # The family is part of the seed, so that families are not correlated.
    stream = [GENERATOR_VERSION, *family.encode(), seed]
    rng = np.random.default_rng(stream)
    name = f"{family}-v{GENERATOR_VERSION}-{seed:04d}"
    while True:
        scene = FAMILIES[family](rng, name)
        if target_clearance(scene) >= TARGET_CLEARANCE:
            return scene


def target_clearance(scene: PrimitiveScene) -> float:
    """Returns the distance from the target's origin to the nearest solid [m].

    Raises:
        RemoSplatError: The scene has no target.
    """
    if scene.X_WE_target is None:
        raise RemoSplatError(f"{scene.name} has no target")
    point = Spheres.at(scene.X_WE_target.translation())
    return SignedDistanceField(scene).clearances(point).minimum()
