"""Spherical harmonics against published polynomials, and how they turn."""

import hypothesis.strategies as st
import numpy as np
import pytest
from hypothesis import given
from pydrake.math import RigidTransform, RollPitchYaw, RotationMatrix
from toy_splats import random_splat

from remosplat_drake.base.errors import RemoSplatError
from remosplat_drake.splat.gaussian_splat import SH_C0, GaussianSplat
from remosplat_drake.splat.harmonics import (
    harmonics,
    last_degree,
    rotated_harmonics,
)


def directions(n: int, seed: int = 5) -> np.ndarray:
    d = np.random.default_rng(seed).normal(size=(n, 3))
    return d / np.linalg.norm(d, axis=1, keepdims=True)


def polynomials(d: np.ndarray) -> list[np.ndarray]:
    """Degrees 1 to 3 in x, y and z, with the signs that splat files have."""
    x, y, z = d.T
    r = np.sqrt(1 / np.pi)
    one = np.sqrt(3 / 4) * r * np.stack([-y, z, -x], axis=1)
    k = np.sqrt(15) / 2 * r
    two = [
        k * x * y,
        -k * y * z,
        np.sqrt(5) / 4 * r * (3 * z * z - 1),
        -k * x * z,
        k / 2 * (x * x - y * y),
    ]
    a, b, c = np.sqrt([35 / 32, 105 / 4, 21 / 32]) * r
    three = [
        -a * y * (3 * x * x - y * y),
        b * x * y * z,
        -c * y * (5 * z * z - 1),
        np.sqrt(7) / 4 * r * z * (5 * z * z - 3),
        -c * x * (5 * z * z - 1),
        b / 2 * z * (x * x - y * y),
        -a * x * (x * x - 3 * y * y),
    ]
    return [one, np.stack(two, axis=1), np.stack(three, axis=1)]


def test_the_harmonics_are_those_of_the_files():
    d = directions(40)
    for degree, expected in enumerate(polynomials(d), start=1):
        np.testing.assert_allclose(harmonics(degree, d), expected, atol=1e-12)
    np.testing.assert_allclose(harmonics(0, d), SH_C0)


def test_the_poles_are_directions_too():
    d = np.array([[0.0, 0, 1], [0, 0, -1]])
    expected = np.sqrt(9 / (4 * np.pi)) * np.eye(9)[4]
    np.testing.assert_allclose(harmonics(4, d), [expected] * 2, atol=1e-12)


def seen(splat: GaussianSplat, splat_index: int, d: np.ndarray) -> np.ndarray:
    """The colour of one splat along one direction: the slow reference."""
    color = splat.colors[splat_index].astype(float)
    k = 0
    degree = 1
    while k < splat.sh_rest.shape[1]:
        for value in harmonics(degree, d[None])[0]:
            color = color + value * splat.sh_rest[splat_index, k]
            k += 1
        degree += 1
    return color


angle = st.floats(-np.pi, np.pi)


@given(
    rpy=st.tuples(angle, angle, angle),
    degree=st.integers(1, 4),
    seed=st.integers(0, 1000),
)
def test_a_turned_splat_looks_the_same_from_turned_directions(
    rpy, degree, seed
):
    splat = random_splat(harmonics=(degree + 1) ** 2 - 1, n=3, seed=seed)
    R_FG = RotationMatrix(RollPitchYaw(rpy))
    turned = splat.transformed(RigidTransform(R_FG, [1, 2, 3]), 1.7)
    for i in range(len(splat)):
        for d_G in directions(4, seed):
            np.testing.assert_allclose(
                seen(turned, i, R_FG.matrix() @ d_G),
                seen(splat, i, d_G),
                atol=1e-5,
            )


def test_a_quarter_turn_by_hand():
    """Brightness along +x, which is harmonic m = 1 of degree 1, goes to +y."""
    sh_rest = np.zeros((1, 3, 3))
    sh_rest[0, 2] = -1.0
    R_FG = np.array([[0.0, -1, 0], [1, 0, 0], [0, 0, 1]])
    expected = np.zeros((1, 3, 3))
    expected[0, 0] = -1.0
    np.testing.assert_allclose(
        rotated_harmonics(sh_rest, R_FG), expected, atol=1e-12
    )


def test_a_scale_alone_turns_no_colour():
    splat = random_splat(harmonics=8)
    scaled = splat.transformed(RigidTransform([1.0, 0, 0]), 3.0)
    np.testing.assert_array_equal(scaled.sh_rest, splat.sh_rest)
    assert splat.without_harmonics().sh_rest.shape == (20, 0, 3)


@pytest.mark.parametrize(
    ("coefficients", "degree"), [(0, 0), (3, 1), (8, 2), (15, 3), (24, 4)]
)
def test_degrees_by_their_number_of_coefficients(coefficients, degree):
    assert last_degree(coefficients) == degree


def test_half_a_degree_is_refused():
    with pytest.raises(
        RemoSplatError, match="5 higher harmonics match no degree"
    ):
        last_degree(5)
