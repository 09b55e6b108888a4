"""Names of places: by the map, the truth and the floor's height."""

import numpy as np
import pytest
from pydrake.math import RigidTransform

from remosplat_drake.generation.primitive_surfels import surfel_splat
from remosplat_drake.motion_status.names import name_thing
from remosplat_drake.oracle.composite import CompositeDistanceField
from remosplat_drake.oracle.oracle_config import SphereToEllipsoid
from remosplat_drake.oracle.signed_distance import SignedDistanceField
from remosplat_drake.oracle.unknown_space import UnknownSpaceField
from remosplat_drake.scene.primitive_scene import Box, PrimitiveScene
from remosplat_drake.signals.thing import (
    MAP,
    SOLID,
    THE_FLOOR,
    THE_MAP,
    UNSEEN_SPACE,
    Thing,
)

FLOOR_HEIGHT = 0.03
TABLE = Box(RigidTransform([0, 0, 0.5]), np.array([0.4, 0.4, 0.02]), "table")
SCENE = PrimitiveScene(boxes=(TABLE,)).with_floor((0.0, 0.0), 0.5)
TRUTH = SignedDistanceField(SCENE)

ON_THE_TABLE = np.array([0.1, 0.2, 0.52])
ON_THE_FLOOR = np.array([0.45, 0.1, 0.0])
A_FLOATER = np.array([0.1, 0.2, 0.62])
"""Where a map shows something, and no solid is."""
UNSEEN_BEHIND = np.array([0.1, 0.2, 1.0])
"""Where what is above has not been seen."""


@pytest.fixture(scope="module")
def field():
    """A splat of a table on a floor, and nothing seen above 1 m."""
    splat = surfel_splat(SCENE, 20_000)
    unseen = np.zeros((40, 40, 40), bool)
    unseen[:, :, 20:] = True
    return CompositeDistanceField(
        [
            SphereToEllipsoid().make(splat),
            UnknownSpaceField(unseen, np.array([-2.0, -2.0, -1.0]), 0.1),
        ]
    )


@pytest.mark.parametrize(
    ("p_W", "truth", "thing"),
    [
        (ON_THE_TABLE, None, THE_MAP),
        (ON_THE_TABLE, TRUTH, Thing(MAP, "the table")),
        (ON_THE_FLOOR, None, THE_FLOOR),
        (ON_THE_FLOOR, TRUTH, THE_FLOOR),
        # For any truth, that space is unseen.
        (UNSEEN_BEHIND, None, UNSEEN_SPACE),
        (UNSEEN_BEHIND, TRUTH, UNSEEN_SPACE),
        (A_FLOATER, TRUTH, THE_MAP),
    ],
)
def test_the_best_name_of_a_place(field, p_W, truth, thing):
    assert name_thing(field, p_W, FLOOR_HEIGHT, truth) == thing


def test_known_geometry_names_itself():
    assert name_thing(TRUTH, ON_THE_TABLE) == Thing(SOLID, "the table")
    assert name_thing(TRUTH, ON_THE_FLOOR) == THE_FLOOR


def test_without_a_floor_s_height_a_floor_is_a_map_s_surface(field):
    assert name_thing(field, ON_THE_FLOOR) == THE_MAP
