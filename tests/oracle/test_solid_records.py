"""The records and boxes of solids against their readable twin."""

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from remosplat_drake.oracle import sphere_to_ellipsoid_reference as reference
from remosplat_drake.oracle.kernels.solid_records import fill_boxes
from remosplat_drake.oracle.prepared_solids import splat_records
from remosplat_drake.splat.gaussian_splat import GaussianSplat


@given(st.integers(0, 2**32 - 1), st.sampled_from([2, 3]), st.booleans())
@settings(max_examples=30, deadline=None)
def test_records_and_boxes_are_those_of_the_reference(
    seed, n_scales, uncertain
):
    rng = np.random.default_rng(seed)
    n = int(rng.integers(1, 40))
    splat = GaussianSplat(
        rng.normal(size=(n, 3)),
        rng.normal(size=(n, 4)),
        # Some are equal: the order of their axes matters, too.
        rng.choice([0.01, 0.02, 0.5], (n, n_scales)),
        rng.uniform(0.01, 1, n),
        np.zeros((n, 3)),
        uncertainty=rng.uniform(0, 0.1, n) if uncertain else None,
    )
    records, index = splat_records(splat, 0.3, 1.5)
    expected, chosen = reference.splat_records(splat, 0.3, 1.5)
    np.testing.assert_array_equal(index, chosen)
    np.testing.assert_allclose(records, expected, rtol=0, atol=1e-15)
    for solved in (False, True):
        boxes = np.empty((len(records), 7))
        fill_boxes(records, solved, boxes)
        right = reference.boxes(records, solved)
        np.testing.assert_allclose(boxes, right, rtol=0, atol=1e-14)
