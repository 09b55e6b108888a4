"""Floaters: where they are, how faint they are, and what they leave alone."""

import numpy as np
import pytest
from pydrake.math import RigidTransform

from remosplat_drake.generation.floaters import FAINTEST, with_floaters
from remosplat_drake.oracle.signed_distance import SignedDistanceField
from remosplat_drake.robot.sphere_model import Spheres
from remosplat_drake.scene.primitive_scene import Box, PrimitiveScene
from remosplat_drake.splat.gaussian_splat import GaussianSplat

COUNT = 2000


@pytest.fixture
def truth() -> SignedDistanceField:
    box = Box(RigidTransform([0.5, 0, 0.5]), np.array([0.2, 0.2, 0.2]))
    return SignedDistanceField(PrimitiveScene(boxes=(box,)))


@pytest.fixture
def splat() -> GaussianSplat:
    n = 300
    p_GK = np.random.default_rng(1).uniform((0, -1, -0.01), (1, 1, 1), (n, 3))
    return GaussianSplat(
        p_GK=p_GK,
        quaternions=np.tile([1.0, 0, 0, 0], (n, 1)),
        scales=np.full((n, 2), 0.01),
        opacities=np.full(n, 0.9),
        colors=np.full((n, 3), 0.5),
    )


def test_the_splat_itself_stays(splat, truth):
    noisy = with_floaters(splat, truth, COUNT)
    assert len(noisy) == len(splat) + COUNT
    same = noisy.select(np.arange(len(splat)))
    assert same.content_hash == splat.content_hash


def test_floaters_fly_in_the_free_part_of_the_box(splat, truth):
    added = with_floaters(splat, truth, COUNT).p_GK[len(splat) :]
    assert (added >= (0, -1, 0.02)).all()
    assert (added <= (1, 1, 1)).all()
    # All of it, but not near the solid.
    assert (np.ptp(added, axis=0) > (0.9, 1.8, 0.9)).all()
    distance = truth.clearances(Spheres.at(added)).per_sphere(COUNT)
    assert distance.min() > 0.02 - 1e-6


def test_floaters_are_as_training_leaves_them(splat, truth):
    noisy = with_floaters(splat, truth, COUNT)
    added = noisy.select(np.arange(len(splat), len(noisy)))
    faded = added.opacities < 1.001 * FAINTEST
    assert faded.mean() == pytest.approx(0.9, abs=0.03)
    assert (added.opacities > 0.1).mean() == pytest.approx(0.012, abs=0.008)
    assert np.median(added.scales) == pytest.approx(0.075, rel=0.05)


def test_a_seed_gives_the_same_floaters(splat, truth):
    hashes = [
        with_floaters(splat, truth, 50, seed).content_hash for seed in (3, 3, 4)
    ]
    assert hashes[0] == hashes[1] != hashes[2]
