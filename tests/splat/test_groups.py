"""Groups of splats that touch: by hand, and against trying all pairs."""

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from remosplat_drake.splat.cleaning.groups import (
    NEIGHBOURS,
    REACH,
    find_groups,
    find_neighbours,
)
from remosplat_drake.splat.gaussian_splat import GaussianSplat


def row_of(x, scales) -> GaussianSplat:
    """Splats on the x axis that are not turned."""
    n = len(x)
    return GaussianSplat(
        p_GK=np.stack([x, np.zeros(n), np.zeros(n)], axis=1),
        quaternions=np.tile([1.0, 0, 0, 0], (n, 1)),
        scales=np.broadcast_to(scales, (n, np.shape(scales)[-1])),
        opacities=np.full(n, 0.8),
        colors=np.full((n, 3), 0.5),
    )


def test_needles_touch_along_the_line_between_them():
    # 0.1 along x, 0.01 across: 0.5 m apart they meet, 0.7 m they do not.
    groups = find_groups(row_of([0.0, 0.5, 1.2], [0.1, 0.01, 0.01]))
    assert groups.label[0] == groups.label[1] != groups.label[2]
    assert sorted(groups.size.tolist()) == [1, 2]
    # Seen from the side they reach 0.03 each.
    groups = find_groups(row_of([0.0, 0.05, 0.12], [0.01, 0.01, 0.1]))
    assert groups.label[0] == groups.label[1] != groups.label[2]


def test_a_disc_reaches_as_far_along_its_normal_as_its_shorter_axis():
    for gap, size in ((0.29, [2]), (0.31, [1, 1])):
        beside = row_of([0.0, gap], [0.2, 0.05])
        # The discs' normals are turned to x.
        turned = np.tile(np.sqrt([0.5, 0, 0.5, 0]), (2, 1))
        arrays = beside.arrays() | {"quaternions": turned}
        groups = find_groups(GaussianSplat(**arrays))
        assert groups.size.tolist() == size


def test_a_chain_is_one_group():
    groups = find_groups(row_of(0.05 * np.arange(400.0), [0.01] * 3))
    assert groups.size.tolist() == [400]


def test_neighbours_of_points_in_one_place():
    neighbours = find_neighbours(np.zeros((30, 3)))
    own = neighbours.index == np.arange(30)[:, None]
    assert not own.any()
    assert (neighbours.distance == 0).all()


def test_one_splat_has_no_neighbours():
    neighbours = find_neighbours(np.zeros((1, 3)))
    assert np.isinf(neighbours.distance).all()
    assert find_groups(row_of([0.0], [0.1, 0.1])).size.tolist() == [1]


def all_pairs(splat: GaussianSplat) -> np.ndarray:
    """Labels of the groups by trying all pairs, slowly."""
    n, scales = len(splat), splat.scales.astype(float)
    label = np.arange(n)
    for i in range(n):
        for j in range(i):
            d = (splat.p_GK[i] - splat.p_GK[j]).astype(float)
            length = np.linalg.norm(d)
            u = d / length
            half = 0.0
            for k in (i, j):
                axes = splat.R_GK[k][:, : scales.shape[1]] * scales[k]
                half += max(np.linalg.norm(u @ axes), np.sort(scales[k])[-2])
            if length <= REACH * half:
                label[label == label[i]] = label[j]
    return label


@given(
    st.integers(0, 2**32 - 1),
    st.integers(1, NEIGHBOURS + 1),
    st.sampled_from([2, 3]),
)
@settings(max_examples=40, deadline=None)
def test_groups_are_those_of_all_pairs(seed, n, n_scales):
    rng = np.random.default_rng(seed)
    splat = GaussianSplat(
        rng.normal(size=(n, 3)),
        rng.normal(size=(n, 4)),
        np.exp(rng.uniform(-6, -1, (n, n_scales))),
        np.full(n, 0.5),
        np.zeros((n, 3)),
    )
    expected, label = all_pairs(splat), find_groups(splat).label
    np.testing.assert_array_equal(
        label[:, None] == label, expected[:, None] == expected
    )
