"""Places for a hand: those of the whole grid, not all of it asked at once."""

import dataclasses as dc
import itertools

import numpy as np
import pytest
from effort import effort
from pydrake.math import RigidTransform, RollPitchYaw

from remosplat_drake.oracle.signed_distance import SignedDistanceField
from remosplat_drake.oracle.sphere_to_ellipsoid import SphereToEllipsoidField
from remosplat_drake.robot.sphere_model import Spheres
from remosplat_drake.scene.primitive_scene import Box, PrimitiveScene
from remosplat_drake.signals.distance_field import DistanceField
from remosplat_drake.splat.gaussian_splat import GaussianSplat
from remosplat_drake.task import hand_places
from remosplat_drake.task.hand_places import HandPlaces

HEIGHTS = np.arange(0.35, 1.2, 0.05)
HAND = Spheres.at(
    np.array([[0, 0, 0.05], [0.02, 0.04, 0.1], [-0.02, -0.04, 0.2]]),
    np.array([0.03, 0.05, 0.08]),
)


def all_at_once(places: HandPlaces) -> np.ndarray:
    """The same places, of a grid that is asked as a whole."""
    ends = zip(places.lower, places.upper, strict=True)
    axes = [np.arange(start, end, 0.1) for start, end in ends]
    grid = np.stack(np.meshgrid(*axes, places.heights), axis=-1)
    p_W, n = grid.reshape(-1, 3), len(places.hand)
    centers = (p_W[:, None] + places.hand.p_WS).reshape(-1, 3)
    spheres = dc.replace(
        Spheres.at(centers, np.tile(places.hand.radius, len(p_W))),
        ignore_below=np.tile(places.hand.ignore_below, len(p_W)),
    )
    rows = places.field.clearances(spheres)
    room = rows.per_sphere(len(spheres)).reshape(-1, n).min(axis=1)
    found = p_W[(room > places.near) & (room < places.far)]
    middle = 0.5 * (places.lower + places.upper)
    away = np.linalg.norm(found[:, :2] - middle, axis=1)
    return found[away.argsort(kind="stable")]


def tables(rng: np.random.Generator) -> DistanceField:
    """Boxes that lie at any angle, over a floor."""
    boxes = [
        Box(
            RigidTransform(
                RollPitchYaw(rng.uniform(-0.5, 0.5, 3)),
                [*rng.uniform(-2, 2, 2), rng.uniform(0, 1.2)],
            ),
            rng.uniform(0.02, 0.4, 3),
        )
        for _ in range(5)
    ]
    return SignedDistanceField(PrimitiveScene(boxes=tuple(boxes)).with_floor())


def discs(rng: np.random.Generator) -> DistanceField:
    """Discs that do not know to a few centimetres where they are."""
    n = 300
    quaternions = rng.normal(size=(n, 4))
    quaternions /= np.linalg.norm(quaternions, axis=1, keepdims=True)
    splat = GaussianSplat(
        rng.uniform([-2, -2, 0], [2, 2, 1.2], (n, 3)),
        quaternions,
        rng.uniform(0.01, 0.1, (n, 2)),
        rng.uniform(0.2, 1, n),
        np.zeros((n, 3)),
        uncertainty=rng.uniform(0, 0.03, n),
    )
    return SphereToEllipsoidField(splat)


def some_places(
    field: DistanceField, rng: np.random.Generator, ignore_below: float
) -> HandPlaces:
    hand = dc.replace(HAND, ignore_below=np.full(len(HAND), ignore_below))
    lower, upper = rng.uniform(-3, -1, 2), rng.uniform(1, 4, 2)
    return HandPlaces(field, hand, lower, upper, HEIGHTS, 0.05, 0.12)


@pytest.mark.parametrize("at_once", effort([1, 300], [1, 300, 20_000]))
@pytest.mark.parametrize("make", [tables, discs])
@pytest.mark.parametrize("seed", range(effort(2, 4)))
def test_they_are_those_of_the_whole_grid(make, seed, at_once, monkeypatch):
    monkeypatch.setattr(hand_places, "_AT_ONCE", at_once)
    rng = np.random.default_rng(seed)
    floor = -np.inf if seed % 2 else 0.2
    places = some_places(make(rng), rng, floor)
    expected = all_at_once(places)
    assert len(expected) > 50
    np.testing.assert_array_equal(
        np.concatenate(list(places.outwards())), expected
    )


def test_those_near_a_point_keep_their_order():
    rng = np.random.default_rng(5)
    places = some_places(tables(rng), rng, -np.inf)
    p_W, radius = np.array([1.0, -0.5, 0.6]), 0.7

    def near(p_WT: np.ndarray) -> np.ndarray:
        return p_WT[np.linalg.norm(p_WT - p_W, axis=1) < radius]

    found = np.concatenate(list(places.outwards(p_W, radius)))
    everywhere = all_at_once(places)
    assert 0 < len(near(everywhere)) <= len(found) < len(everywhere)
    np.testing.assert_array_equal(near(found), near(everywhere))


class Counted(DistanceField):
    """Counts the spheres that a field is asked about."""

    def __init__(self, field: DistanceField):
        self._field, self.asked = field, 0
        self.revision = field.revision

    def clearances(self, spheres, max_distance=np.inf):
        self.asked += len(spheres)
        return self._field.clearances(spheres, max_distance)


def test_only_as_far_as_places_are_asked_for():
    """On a hundred tables, in a grid of ten million places."""
    rng = np.random.default_rng(6)
    boxes = [
        Box(RigidTransform([x, y, 0.6]), np.array([0.4, 0.4, 0.02]))
        for x, y in itertools.product(np.linspace(-38, 38, 10), repeat=2)
    ]
    field = Counted(SignedDistanceField(PrimitiveScene(boxes=tuple(boxes))))
    places = dc.replace(
        some_places(field, rng, -np.inf),
        lower=np.full(2, -40.0),
        upper=np.full(2, 40.0),
    )
    first = next(some for some in places.outwards() if len(some))
    assert np.abs(first).max() < 10
    assert field.asked < 200_000


@pytest.mark.parametrize("extent", [1e4, 1e9, 1e15])
def test_an_outlier_does_not_make_a_grid_explode(extent):
    rng = np.random.default_rng(7)
    field = Counted(tables(rng))
    places = some_places(field, rng, 0.2)
    far = dc.replace(places, upper=np.array([extent, 1.3]))
    some = next(some for some in far.outwards() if len(some))
    # Of all places by the tables those nearest to a middle that is far away.
    same = np.concatenate(list(places.outwards()))
    assert some[0, 0] == pytest.approx(same[:, 0].max(), abs=0.2)
    assert field.asked < 1_000_000


def test_there_may_be_none():
    rng = np.random.default_rng(8)
    places = some_places(tables(rng), rng, -np.inf)
    for nothing in (
        dc.replace(places, heights=np.zeros(0)),
        dc.replace(places, upper=places.lower),
        dc.replace(places, upper=places.lower - 1.0),
        dc.replace(places, heights=HEIGHTS + 50.0),
    ):
        assert not sum(map(len, nothing.outwards()))
