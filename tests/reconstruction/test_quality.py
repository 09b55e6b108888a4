"""Distances of the shipped demo splats against their geometry."""

import dataclasses as dc

import numpy as np
import pytest
from pydrake.math import RigidTransform

from remosplat_drake.base.resources import models_dir
from remosplat_drake.oracle.signed_distance import SignedDistanceField
from remosplat_drake.oracle.sphere_to_ellipsoid import SphereToEllipsoidField
from remosplat_drake.reconstruction.report.quality import distance_quality
from remosplat_drake.scene.primitive_scene import Box, PrimitiveScene
from remosplat_drake.scene.rmmi import read_scene
from remosplat_drake.splat.codecs.ply import read_ply


@pytest.mark.parametrize("name", ["table", "bookshelf"])
def test_demo_splats_measure_true_distances(name):
    """The bounds leave a fifth of room over what was measured."""
    folder = models_dir() / "scenes" / name
    scene = read_scene(folder / "scene.json")
    splat = read_ply(folder / "splat.ply")
    assert splat.opacities.min() >= 0.2
    quality = distance_quality(
        SphereToEllipsoidField(splat),
        SignedDistanceField(scene),
        np.array([-0.3, -0.9, 0.05]),
        np.array([1.8, 0.9, 1.4]),
        count=4000,
    )
    assert quality.count > 1500
    assert quality.median < 0.1e-3
    assert quality.percentile_99 < 4e-3
    assert quality.over < 16e-3
    assert quality.under < 8e-3


def test_errors_by_hand():
    """A floor that a reconstruction has 1 cm too low: over by 1 cm."""
    floor = PrimitiveScene().with_floor()
    lower = dc.replace(
        floor,
        boxes=(Box(RigidTransform([0, 0, -0.03]), np.array([3, 3, 0.02])),),
    )
    quality = distance_quality(
        SignedDistanceField(lower),
        SignedDistanceField(floor),
        np.array([-1.0, -1, 0]),
        np.array([1.0, 1, 0.3]),
        count=500,
        nearest=0.1,
    )
    # 0.1 of the 0.3 m of height is too near.
    assert 280 < quality.count < 390
    assert quality.median == pytest.approx(0.01)
    assert quality.percentile_99 == pytest.approx(0.01)
    assert quality.over == pytest.approx(0.01)
    assert quality.under == 0
