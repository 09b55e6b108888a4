"""A splat in other units: everything that is a length grows alike."""

import dataclasses as dc

import hypothesis.strategies as st
import numpy as np
import pytest
from hypothesis import given, settings
from pydrake.math import RigidTransform, RollPitchYaw
from toy_splats import random_splat

from remosplat_drake.base.errors import RemoSplatError
from remosplat_drake.oracle.sphere_to_ellipsoid import SphereToEllipsoidField
from remosplat_drake.robot.sphere_model import Spheres

angle = st.floats(-np.pi, np.pi)
poses = st.builds(
    lambda rpy, p: RigidTransform(RollPitchYaw(rpy), p),
    st.tuples(angle, angle, angle),
    st.lists(st.floats(-2, 2), min_size=3, max_size=3),
)
scales = st.floats(-1, 1).map(lambda x: 10**x)


@given(X_FG=poses, scale=scales, axes=st.sampled_from([2, 3]))
def test_every_length_is_scaled(X_FG, scale, axes):
    splat = random_splat(axes).with_uncertainty(np.linspace(0, 0.1, 20))
    moved = splat.transformed(X_FG, scale)
    gaps = splat.p_GK[:, None] - splat.p_GK.astype(float)
    moved_gaps = moved.p_GK[:, None] - moved.p_GK.astype(float)
    np.testing.assert_allclose(
        np.linalg.norm(moved_gaps, axis=2),
        scale * np.linalg.norm(gaps, axis=2),
        atol=5e-6 * max(1, scale),
    )
    np.testing.assert_allclose(moved.scales, scale * splat.scales, rtol=1e-6)
    np.testing.assert_allclose(
        moved.uncertainty, scale * splat.uncertainty, rtol=1e-6
    )
    np.testing.assert_array_equal(moved.opacities, splat.opacities)
    for k in (0, 7):
        expected = X_FG @ (scale * splat.p_GK[k].astype(float))
        np.testing.assert_allclose(
            moved.p_GK[k], expected, atol=5e-6 * max(1, scale)
        )


@given(X_FG=poses, scale=scales, degree=st.integers(0, 3))
def test_there_and_back_is_where_it_was(X_FG, scale, degree):
    splat = random_splat(harmonics=(degree + 1) ** 2 - 1)
    there = splat.transformed(X_FG, scale)
    again = there.transformed(X_FG.inverse()).transformed(
        RigidTransform(), 1 / scale
    )
    np.testing.assert_allclose(again.p_GK, splat.p_GK, atol=1e-5 / scale + 1e-5)
    np.testing.assert_allclose(again.scales, splat.scales, rtol=1e-5)
    np.testing.assert_allclose(again.R_GK, splat.R_GK, atol=1e-5)
    np.testing.assert_allclose(again.sh_rest, splat.sh_rest, atol=1e-5)


def test_nothing_asked_is_nothing_done():
    splat = random_splat(harmonics=8)
    same = splat.transformed(RigidTransform(), 1.0)
    np.testing.assert_array_equal(same.p_GK, splat.p_GK)
    np.testing.assert_array_equal(same.scales, splat.scales)
    np.testing.assert_array_equal(same.sh_rest, splat.sh_rest)


@settings(max_examples=25)
@given(X_FG=poses, scale=scales, axes=st.sampled_from([2, 3]))
def test_the_oracle_measures_scaled_distances(X_FG, scale, axes):
    splat = random_splat(axes).with_uncertainty(np.linspace(0, 0.02, 20))
    p_G = np.random.default_rng(4).normal(size=(30, 3))
    before = SphereToEllipsoidField(splat).clearances(
        Spheres.at(p_G, np.full(30, 0.05))
    )
    p_F = X_FG.multiply(scale * p_G.T).T
    after = SphereToEllipsoidField(splat.transformed(X_FG, scale)).clearances(
        Spheres.at(p_F, np.full(30, 0.05 * scale))
    )
    np.testing.assert_array_equal(after.sphere, before.sphere)
    np.testing.assert_allclose(
        after.distance,
        scale * before.distance,
        rtol=1e-5,
        atol=2e-5 * max(1, scale),
    )


@pytest.mark.parametrize(
    ("scale", "problem"),
    [
        (-1.0, "scale of splat 0 is not positive"),
        (0.0, "scale of splat 0 is not positive"),
        (np.nan, "is not finite"),
        (1e60, "is not finite"),
        (1e-60, "scale of splat 0 is not positive"),
    ],
)
def test_no_splat_is_of_such_a_size(scale, problem):
    with pytest.raises(RemoSplatError, match=problem):
        random_splat().transformed(RigidTransform(), scale)


def test_a_splat_without_uncertainty_gets_none():
    splat = dc.replace(random_splat(), uncertainty=None)
    assert splat.transformed(RigidTransform(), 2.0).uncertainty is None
