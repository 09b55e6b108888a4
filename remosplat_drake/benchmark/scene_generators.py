"""Seeded random scenes like those of the RMMI benchmark.

Two families, a table and a bookshelf, each with clutter of upright
cylinders in front of one fixed end-effector target. The ranges and the
rejection rules are those of the 1,000 published scenes; the random stream is
our own, so seeds do not repeat their scenes.
"""

import numpy as np
from pydrake.math import RigidTransform, RotationMatrix

from remosplat_drake.errors import RemoSplatError, unknown_name
from remosplat_drake.oracle.signed_distance import SignedDistanceField
from remosplat_drake.robot.sphere_model import Spheres
from remosplat_drake.scene.primitive_scene import (
    Box,
    Cylinder,
    PrimitiveScene,
)

GENERATOR_VERSION = 1
"""Raised whenever a seed would give another scene; part of every name."""

TARGET_CLEARANCE = 0.025
"""The target point is never nearer than this to an obstacle [m]."""

LOWER_SHELF_MAX_Z = 0.552
MIDDLE_SHELF_MIN_Z = 0.953
"""Beyond these centre heights [m] no published shelf scene was feasible."""


def generate(family: str, seed: int) -> PrimitiveScene:
    """The scene of a family that belongs to a seed, the same everywhere.

    Args:
        family: "table" or "bookshelf".
        seed: Any non-negative integer.

    Raises:
        RemoSplatError: There is no such family.
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
    """Distance from the target's origin to the nearest solid [m].

    Raises:
        RemoSplatError: The scene has no target.
    """
    if scene.X_WE_target is None:
        raise RemoSplatError(f"{scene.name} has no target")
    point = Spheres.at(scene.X_WE_target.translation())
    return SignedDistanceField(scene).clearances(point).minimum()


def _table(rng: np.random.Generator, name: str) -> PrimitiveScene:
    table = _box([1.5, 0, 0.5 + rng.uniform(-0.1, 0.1)], [0.5, 2.0, 0.03])
    cylinders = tuple(
        _upright_cylinder(
            np.array([1.1, 0, 0.5])
            + rng.uniform(-1, 1, 3) * np.array([0.1, 0.25, 0]),
            radius=0.05 + rng.uniform(-0.03, 0.03),
            half_height=0.3 + rng.uniform(-0.2, 0.2),
        )
        for _ in range(4)
    )
    return PrimitiveScene(
        boxes=(table,),
        cylinders=cylinders,
        X_WE_target=RigidTransform(
            RotationMatrix(np.diag([1.0, -1.0, -1.0])),
            [1.15349, -0.00112, 0.65838],
        ),
        X_WB_start=(0.0, rng.uniform(-0.5, 0.5), 0.0),
        name=name,
    )


def _bookshelf(rng: np.random.Generator, name: str) -> PrimitiveScene:
    boxes = (
        _box([1.4, 0, rng.uniform(0.4, LOWER_SHELF_MAX_Z)], [0.5, 0.6, 0.03]),
        _box([1.4, -0.6, 0.6], [0.5, 0.03, 0.6]),
        _box([1.4, 0, rng.uniform(MIDDLE_SHELF_MIN_Z, 1.0)], [0.5, 0.6, 0.03]),
        _box([1.4, 0.6, 0.6], [0.5, 0.05, 0.6]),
        _box([1.4, 0, 1.2], [0.5, 0.6, 0.03]),
    )
    cylinders = tuple(
        _upright_cylinder(
            np.array([0.9, 0, 0.6])
            + rng.uniform(-1, 1, 3) * np.array([0.1, 0.4, 0]),
            radius=0.03 + rng.uniform(-0.02, 0.02),
            half_height=0.5,
        )
        for _ in range(2)
    )
    return PrimitiveScene(
        boxes=boxes,
        cylinders=cylinders,
        X_WE_target=RigidTransform(
            RotationMatrix.ProjectToRotationMatrix(
                np.array([[1, 0.0047, 0], [0.0047, -1, 0], [0, 0, -1]])
            ),
            [1.18035, 0.04827, 0.60746],
        ),
        X_WB_start=(0.0, rng.uniform(-1.0, 1.0), 0.0),
        name=name,
    )


def _box(center: list[float], half_extents: list[float]) -> Box:
    return Box(RigidTransform(np.array(center)), np.array(half_extents))


def _upright_cylinder(
    center: np.ndarray, radius: float, half_height: float
) -> Cylinder:
    return Cylinder(RigidTransform(center), radius, half_height)


FAMILIES = {"table": _table, "bookshelf": _bookshelf}
"""What a family name builds."""
