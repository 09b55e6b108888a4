"""Composite fields, on walls and random boxes."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from pydrake.math import RigidTransform

from remosplat_drake.base.errors import RemoSplatError
from remosplat_drake.oracle.composite import CompositeDistanceField
from remosplat_drake.oracle.signed_distance import SignedDistanceField
from remosplat_drake.oracle.unknown_space import UnknownSpaceField
from remosplat_drake.robot.sphere_model import Spheres
from remosplat_drake.scene.primitive_scene import Box, PrimitiveScene
from remosplat_drake.signals.distance_field import DistanceField
from remosplat_drake.signals.thing import (
    SOLID,
    THE_MAP,
    UNSEEN_SPACE,
    Thing,
)


def _wall(x):
    box = Box(RigidTransform([x, 0, 0]), np.array([0.5, 9, 9]))
    return SignedDistanceField(PrimitiveScene(boxes=(box,)))


LEFT, RIGHT = _wall(-3.5), _wall(4.5)
SPHERES = Spheres.at(np.array([[0.0, 0, 0], [3.0, 0, 0]]))


def test_all_rows_of_all_parts_sorted_by_sphere():
    rows = CompositeDistanceField([LEFT, RIGHT]).clearances(SPHERES)
    assert rows.sphere.tolist() == [0, 0, 1, 1]
    np.testing.assert_allclose(rows.distance, [3, 4, 6, 1])


def test_closest_row_of_each_sphere():
    field = CompositeDistanceField([LEFT, RIGHT], rows="closest")
    rows = field.clearances(SPHERES)
    assert rows.sphere.tolist() == [0, 1]
    np.testing.assert_allclose(rows.distance, [3, 1])
    np.testing.assert_allclose(rows.direction_W, [[-1, 0, 0], [1, 0, 0]])
    np.testing.assert_allclose(rows.p_WC, [[-3, 0, 0], [4, 0, 0]])


@pytest.mark.parametrize("rows", ["all", "closest"])
def test_equals_the_scene_of_all_parts(rows):
    rng = np.random.default_rng(0)
    boxes = [
        Box(RigidTransform(rng.uniform(-1, 1, 3)), rng.uniform(0.1, 0.3, 3))
        for _ in range(4)
    ]
    spheres = Spheres.at(rng.uniform(-1, 1, (30, 3)), 0.05)
    together = SignedDistanceField(PrimitiveScene(boxes=tuple(boxes)))
    parts = [
        SignedDistanceField(PrimitiveScene(boxes=tuple(boxes[:2]))),
        SignedDistanceField(PrimitiveScene(boxes=tuple(boxes[2:]))),
    ]
    composite = CompositeDistanceField(parts, rows=rows)
    np.testing.assert_array_equal(
        composite.clearances(spheres).per_sphere(30),
        together.clearances(spheres).per_sphere(30),
    )


@pytest.mark.parametrize("reach", [0.0, 0.3, np.inf])
def test_one_kernel_answers_as_the_parts_do(reach):
    rng = np.random.default_rng(1)
    boxes = [
        Box(RigidTransform(rng.uniform(-1, 1, 3)), rng.uniform(0.1, 0.3, 3))
        for _ in range(5)
    ]
    unseen = UnknownSpaceField(rng.random((6, 6, 6)) < 0.1, np.full(3, -1), 0.3)
    field = CompositeDistanceField(
        [SignedDistanceField(PrimitiveScene(boxes=tuple(boxes))), unseen]
    )
    spheres = Spheres.at(rng.uniform(-1, 1, (60, 3)), rng.uniform(0, 0.1, 60))
    found, parts = (
        ask(spheres, reach) for ask in (field.clearances, field.gathered)
    )
    assert len(found)
    for name in ("sphere", "distance", "direction_W", "p_WC"):
        np.testing.assert_array_equal(
            getattr(found, name), getattr(parts, name)
        )


def test_nothing_near_gives_no_rows():
    field = CompositeDistanceField([LEFT, RIGHT], rows="closest")
    assert not len(field.clearances(SPHERES, max_distance=0.5))


def test_revision_changes_with_any_part():
    assert (
        CompositeDistanceField([LEFT, RIGHT]).revision
        != CompositeDistanceField([LEFT, _wall(5)]).revision
    )


def test_is_lipschitz_only_if_all_parts_are():
    class Rough(DistanceField):
        revision = "rough"
        is_lipschitz = False

        def clearances(self, spheres, max_distance=np.inf):
            return LEFT.clearances(spheres, max_distance)

    assert CompositeDistanceField([LEFT, RIGHT]).is_lipschitz
    assert not CompositeDistanceField([LEFT, Rough()]).is_lipschitz


def test_needs_parts_and_known_rows():
    with pytest.raises(RemoSplatError, match="needs at least one part"):
        CompositeDistanceField([])
    with pytest.raises(RemoSplatError, match="all, closest"):
        CompositeDistanceField([LEFT], rows="both")


class _Coarse(SignedDistanceField):
    """A wall whose field for rollouts is another one."""

    @property
    def for_look_ahead(self) -> DistanceField:
        return RIGHT

    @property
    def for_planning(self) -> DistanceField:
        return RIGHT


def test_for_look_ahead_it_is_composed_of_its_parts_fields_for_that():
    coarse = _Coarse(PrimitiveScene(boxes=(Box(RigidTransform(), np.ones(3)),)))
    ahead = CompositeDistanceField([LEFT, coarse], "closest").for_look_ahead
    assert ahead.parts == (LEFT, RIGHT)
    assert ahead.rows == "closest"
    assert LEFT.for_look_ahead is LEFT
    planned = CompositeDistanceField([LEFT, coarse], "closest").for_planning
    assert planned.parts == (LEFT, RIGHT)
    assert planned.is_lipschitz


def _room_with_a_dark_half() -> CompositeDistanceField:
    """A map's wall at x < -3; unseen space beyond x = 1; a box."""
    unseen = np.zeros((20, 20, 20), bool)
    unseen[15:] = True  # From -5 on in voxels of 0.4 m: beyond x = 1.
    dark = UnknownSpaceField(unseen, np.array([-5.0, -4.0, -4.0]), 0.4)
    box = Box(RigidTransform([0, 0, 1]), np.full(3, 0.2), "lamp")
    lamp = SignedDistanceField(PrimitiveScene(boxes=(box,)))
    return CompositeDistanceField([_Map(LEFT.scene), dark, lamp])


class _Map(SignedDistanceField):
    """A wall as a map knows it: it has no name."""

    thing_at = DistanceField.thing_at


@pytest.mark.parametrize(
    ("p_W", "thing"),
    [
        ([-3.0, 0.5, 0.0], THE_MAP),
        ([1.0, 0.5, 0.0], UNSEEN_SPACE),
        ([0.0, 0.0, 0.8], Thing(SOLID, "the lamp")),
        # Beside and within the surfaces, the nearest one counts.
        ([-3.1, 0.0, 0.0], THE_MAP),
        ([1.1, 0.0, 0.0], UNSEEN_SPACE),
        ([0.1, 0.0, 0.9], Thing(SOLID, "the lamp")),
    ],
)
@pytest.mark.parametrize("rows", ["all", "closest"])
def test_a_thing_is_of_the_part_whose_surface_is_there(p_W, thing, rows):
    room = CompositeDistanceField(_room_with_a_dark_half().parts, rows)
    assert room.thing_at(np.array(p_W)) == thing
    nested = CompositeDistanceField([RIGHT, room], rows)
    assert nested.thing_at(np.array(p_W)) == thing


@given(x=st.floats(-2.9, 0.9), y=st.floats(-3, 3), z=st.floats(-3, 3))
def test_what_is_nearest_is_the_thing_at_its_place(x, y, z):
    """The part that answers the nearest row is the one that is named there."""
    room = _room_with_a_dark_half()
    at = Spheres.at(np.array([x, y, z]))
    nearest = [part.clearances(at) for part in room.parts]
    which = int(np.argmin([rows.minimum() for rows in nearest]))
    p_WC = nearest[which].p_WC[nearest[which].distance.argmin()]
    assert room.thing_at(p_WC) == room.parts[which].thing_at(p_WC)
