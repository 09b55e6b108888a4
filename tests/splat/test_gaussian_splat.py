"""`GaussianSplat`: invalid values, shared arrays, and motions."""

import copy
import dataclasses as dc
import hashlib

import numpy as np
import pytest
from pydrake.math import RigidTransform, RollPitchYaw

from remosplat_drake.base.errors import RemoSplatError
from remosplat_drake.splat.gaussian_splat import GaussianSplat


def make_splat(*, n: int = 4, **changes) -> GaussianSplat:
    rng = np.random.default_rng(3)
    arrays = {
        "p_GK": rng.normal(size=(n, 3)),
        "quaternions": rng.normal(size=(n, 4)),
        "scales": rng.uniform(0.1, 1, (n, 2)),
        "opacities": rng.uniform(0.1, 1, n),
        "colors": rng.uniform(0, 1, (n, 3)),
    }
    return GaussianSplat(**(arrays | changes))


def test_arrays_are_private_and_read_only():
    p_GK = np.zeros((4, 3))
    splat = make_splat(p_GK=p_GK)
    p_GK[0] = 1
    assert not splat.p_GK.any()
    for name in ("p_GK", "quaternions", "scales", "opacities", "R_GK"):
        with pytest.raises(ValueError, match="read-only"):
            getattr(splat, name)[0] = 1


def test_copies_are_shared():
    splat = make_splat()
    assert copy.deepcopy(splat) is splat


@pytest.mark.parametrize(
    ("name", "value", "problem"),
    [
        ("p_GK", np.nan, "p_GK of splat 2 is not finite"),
        ("quaternions", 0.0, "quaternion of splat 2 is zero"),
        ("scales", 0.0, "scale of splat 2 is not positive"),
        ("scales", np.inf, "scales of splat 2 is not finite"),
        ("opacities", 0.0, "opacity of splat 2 is outside"),
        ("opacities", 1.5, "opacity of splat 2 is outside"),
        ("uncertainty", -1e-3, "uncertainty of splat 2 is negative"),
        ("uncertainty", np.nan, "uncertainty of splat 2 is not finite"),
    ],
)
def test_rejects_bad_values(name: str, value, problem):
    splat = make_splat(uncertainty=np.zeros(4))
    array = np.array(getattr(splat, name))
    array[2] = value
    with pytest.raises(RemoSplatError, match=problem):
        dc.replace(splat, **{name: array})


def test_rejects_wrong_shapes():
    with pytest.raises(RemoSplatError, match="opacities has shape"):
        make_splat(opacities=np.ones(3))
    with pytest.raises(RemoSplatError, match="scales has shape"):
        make_splat(scales=np.ones((4, 1)))


def test_may_be_empty():
    splat = make_splat().cropped(np.full(3, 50.0), np.full(3, 60.0))
    assert len(splat) == 0
    assert splat.transformed(RigidTransform()).R_GK.shape == (0, 3, 3)
    joined = GaussianSplat.empty().joined_with(make_splat(n=3))
    np.testing.assert_array_equal(joined.p_GK, make_splat(n=3).p_GK)


def test_rotations_are_orthonormal_to_double_precision():
    R = make_splat(n=100).R_GK
    np.testing.assert_allclose(
        R @ R.transpose(0, 2, 1),
        np.broadcast_to(np.eye(3), R.shape),
        atol=1e-15,
    )


def test_transforms_as_a_rigid_body():
    splat = make_splat()
    X_FG = RigidTransform(RollPitchYaw(0.3, -1.0, 2.0), [1, 2, 3])
    moved = splat.transformed(X_FG)
    for k in range(len(splat)):
        np.testing.assert_allclose(
            moved.p_GK[k], X_FG @ splat.p_GK[k].astype(float), atol=1e-6
        )
    np.testing.assert_allclose(
        moved.R_GK, X_FG.rotation().matrix() @ splat.R_GK, atol=1e-6
    )


def test_crop_and_hash():
    splat = make_splat(p_GK=np.arange(12.0).reshape(4, 3))
    inner = splat.cropped(np.full(3, 2.5), np.full(3, 9.0))
    np.testing.assert_array_equal(inner.p_GK, splat.p_GK[1:3])
    assert inner.content_hash == splat.select(np.array([1, 2])).content_hash
    assert inner.content_hash != splat.content_hash


def test_uncertainty_stays_with_its_splat():
    splat = make_splat(uncertainty=[0.0, 0.1, 0.2, 0.3])
    np.testing.assert_allclose(
        splat.select(np.array([2, 0])).uncertainty, [0.2, 0.0]
    )
    moved = splat.transformed(RigidTransform([1.0, 2.0, 3.0]))
    np.testing.assert_array_equal(moved.uncertainty, splat.uncertainty)
    both = splat.joined_with(splat.with_uncertainty(0.5))
    np.testing.assert_allclose(both.uncertainty, [0, 0.1, 0.2, 0.3, *[0.5] * 4])
    restored = GaussianSplat.restored(dict(splat.arrays()))
    assert restored.content_hash == splat.content_hash
    assert not restored.uncertainty.flags.writeable


def test_uncertainty_counts_in_the_hash():
    splat = make_splat()
    hashes = {
        splat.content_hash,
        splat.with_uncertainty(0.0).content_hash,
        splat.with_uncertainty(0.1).content_hash,
    }
    assert len(hashes) == 3


def test_the_hash_is_that_of_the_arrays_one_after_the_other():
    splat = make_splat(uncertainty=np.full(4, 0.1))
    # As it has always been: sessions on disk are known by it.
    content = hashlib.sha256(b"".join(map(bytes, splat.arrays().values())))
    assert splat.content_hash == content.hexdigest()[:16]


def test_an_unknown_uncertainty_is_never_taken_for_zero():
    known, unknown = make_splat(uncertainty=np.full(4, 0.1)), make_splat()
    assert unknown.joined_with(unknown).uncertainty is None
    for pair in ((known, unknown), (unknown, known)):
        with pytest.raises(RemoSplatError, match="unknown uncertainty"):
            pair[0].joined_with(pair[1])
    joined = unknown.with_uncertainty(0.25).joined_with(known)
    np.testing.assert_allclose(joined.uncertainty, [*[0.25] * 4, *[0.1] * 4])
