"""Sphere-to-ellipsoid distances.

Toy worlds of one splat are worked by hand; random and degenerate scenes are
compared with trying every splat, bit by bit with the same scalar kernel, and
to rounding with the NumPy reference; directions with finite differences.
"""

import copy

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from remosplat_drake.base.kernels import kernel
from remosplat_drake.oracle import sphere_to_ellipsoid_reference as reference
from remosplat_drake.oracle.kernels.ellipsoid_distance import (
    CONVERGE,
    closest_on_disc,
    closest_on_ellipsoid,
)
from remosplat_drake.oracle.kernels.nearest_splat import (
    query,
    query_every_splat,
)
from remosplat_drake.oracle.prepared_solids import splat_records
from remosplat_drake.oracle.sphere_to_ellipsoid import SphereToEllipsoidField
from remosplat_drake.robot.sphere_model import Spheres
from remosplat_drake.splat.codecs.ply import read_ply
from remosplat_drake.splat.gaussian_splat import GaussianSplat

FACING_X = [0.5, 0.5, 0.5, 0.5]
"""Turns x onto y, y onto z and z onto x, without rounding."""


def make_splat(
    p_GK,
    scales,
    quaternions=None,
    opacities: list | float = 0.9,
    uncertainty=None,
) -> GaussianSplat:
    p_GK = np.atleast_2d(np.asarray(p_GK, float))
    n = len(p_GK)
    if quaternions is None:
        quaternions = [1, 0, 0, 0]
    return GaussianSplat(
        p_GK=p_GK,
        quaternions=np.broadcast_to(quaternions, (n, 4)),
        scales=np.broadcast_to(scales, (n, np.shape(scales)[-1])),
        opacities=np.broadcast_to(opacities, (n,)),
        colors=np.full((n, 3), 0.5),
        uncertainty=uncertainty,
    )


def random_splat(rng, n: int, scales: int, spread: float = 1.0):
    return make_splat(
        rng.normal(size=(n, 3)) * spread,
        10 ** rng.uniform(-2.5, -0.5, (n, scales)),
        rng.normal(size=(n, 4)),
        rng.uniform(0, 1, n) + 1e-6,
    )


def one_row(splat: GaussianSplat, p_WS, radius: float = 0.0, **options):
    clearances = SphereToEllipsoidField(splat, **options).clearances(
        Spheres.at(p_WS, radius)
    )
    assert len(clearances) == 1
    return (
        clearances.distance[0],
        clearances.direction_W[0],
        clearances.p_WC[0],
    )


@pytest.mark.parametrize(
    ("p_WS", "radius", "distance", "direction", "point"),
    [
        # Above the disc of semi-axes 2 (x) and 1 (y) around (0, 0, 5).
        ([1, 0, 8], 1, 2, [0, 0, -1], [1, 0, 5]),
        # Below it.
        ([1, 0, 4.5], 0.25, 0.25, [0, 0, 1], [1, 0, 5]),
        # The sphere reaches through the disc: its clearance is negative.
        ([1, 0, 5.5], 1, -0.5, [0, 0, -1], [1, 0, 5]),
        # Beyond the rim in the plane.
        ([6, 0, 5], 1, 3, [-1, 0, 0], [2, 0, 5]),
        ([0, -3, 5], 0.5, 1.5, [0, 1, 0], [0, -1, 5]),
        # Beyond the rim and above: a 3-4-5 triangle.
        ([0, 4, 9], 0, 5, [0, -0.6, -0.8], [0, 1, 5]),
    ],
)
def test_disc(p_WS, radius, distance, direction, point):
    d, n, p = one_row(make_splat([0, 0, 5], [2.0, 1.0]), p_WS, radius)
    np.testing.assert_allclose(d, distance, atol=1e-15)
    np.testing.assert_allclose(n, direction, atol=1e-15)
    np.testing.assert_allclose(p, point, atol=1e-14)


def test_centre_on_a_disc_gets_its_normal():
    splat = make_splat([0, 0, 0], [2.0, 1.0], FACING_X)
    d, n, p = one_row(splat, [0, 0.5, 0.5], 0.1)
    assert d == -0.1
    np.testing.assert_array_equal(n, [1, 0, 0])
    np.testing.assert_array_equal(p, [0, 0.5, 0.5])


def test_disc_extends_along_its_own_first_two_axes():
    # Semi-axis 2 along y of W, 1 along z.
    splat = make_splat([0, 0, 0], [2.0, 1.0], FACING_X)
    np.testing.assert_allclose(one_row(splat, [0, 5, 0])[0], 3, atol=1e-15)
    np.testing.assert_allclose(one_row(splat, [0, 0, 5])[0], 4, atol=1e-15)


@pytest.mark.parametrize(
    ("p_WS", "distance", "direction", "point"),
    [
        # Semi-axes 3, 2, 1 along x, y, z.
        ([5, 0, 0], 2, [-1, 0, 0], [3, 0, 0]),
        ([0, 0, -4], 3, [0, 0, 1], [0, 0, -1]),
        # Inside: negative, and the direction leads away from the surface.
        ([0, 0, 0.75], -0.25, [0, 0, -1], [0, 0, 1]),
        # At the centre the third axis decides.
        ([0, 0, 0], -1, [0, 0, -1], [0, 0, 1]),
        # On the surface: minus the outward normal.
        ([0, 2, 0], 0, [0, -1, 0], [0, 2, 0]),
    ],
)
def test_ellipsoid(p_WS, distance, direction, point):
    d, n, p = one_row(make_splat([0, 0, 0], [3.0, 2.0, 1.0]), p_WS)
    np.testing.assert_allclose(d, distance, atol=1e-15)
    np.testing.assert_allclose(n, direction, atol=1e-15)
    np.testing.assert_allclose(p, point, atol=1e-15)


def test_axes_need_no_order():
    d, n, _ = one_row(make_splat([0, 0, 0], [1.0, 3.0, 2.0]), [0, 5, 0])
    np.testing.assert_allclose(d, 2, atol=1e-15)
    np.testing.assert_allclose(n, [0, -1, 0], atol=1e-15)


def test_n_sigma_scales_the_splat():
    splat = make_splat([0, 0, 0], [0.5, 0.5])
    d, _, _ = one_row(splat, [4, 0, 0], n_sigma=2.0)
    np.testing.assert_allclose(d, 3, atol=1e-15)


def test_min_opacity_ignores_floaters():
    splat = make_splat([[1, 0, 0], [2, 0, 0]], [0.1, 0.1], None, [0.05, 0.5])
    assert one_row(splat, [0, 0, 0])[0] == pytest.approx(1.9)
    assert one_row(splat, [0, 0, 0], min_opacity=0.0)[0] == pytest.approx(0.9)
    none = SphereToEllipsoidField(splat, min_opacity=0.9)
    assert none.num_splats == 0
    assert len(none.clearances(Spheres.at(np.zeros(3)))) == 0


def test_max_distance_is_measured_from_the_surface():
    field = SphereToEllipsoidField(make_splat([0, 0, 0], [1.0, 1.0]))
    spheres = Spheres.at(np.array([[0, 0, 2], [0, 0, 3]]), radius=1.0)
    np.testing.assert_array_equal(field.clearances(spheres, 1.5).sphere, [0])
    assert len(field.clearances(spheres, 1.0)) == 0
    assert len(field.clearances(spheres, np.inf)) == 2


def test_each_sphere_has_its_own_floor():
    splat = make_splat([[0, 0, 0], [0, 0, 2]], [0.1, 0.1])
    field = SphereToEllipsoidField(splat)
    spheres = Spheres.at(np.full((3, 3), [0, 0, 0.5]))
    spheres.ignore_below[:] = [-np.inf, 0.03, 3.0]
    clearances = field.clearances(spheres)
    np.testing.assert_array_equal(clearances.sphere, [0, 1])
    np.testing.assert_allclose(clearances.distance, [0.5, 1.5])


def test_ties_go_to_the_lowest_index():
    splat = make_splat(np.repeat([[0, 0, 1]], 50, axis=0), [0.1, 0.1])
    field = SphereToEllipsoidField(splat)
    nearest, distance = field.nearest_splats(Spheres.at(np.zeros((5, 3))))
    np.testing.assert_array_equal(nearest, 0)
    assert (distance == distance[0]).all()


def every_splat(splat, spheres, max_distance, steps=CONVERGE):
    records, index = splat_records(splat, 0.1, 1.0)
    question = np.column_stack(
        [
            spheres.p_WS,
            spheres.radius + max_distance,
            spheres.ignore_below,
        ]
    )
    answer = np.full((len(spheres), 8), -1.0)
    query_every_splat(records, splat.is_surfel, steps, question, answer)
    found = answer[:, 0] >= 0
    answer[found, 0] = index[answer[found, 0].astype(int)]
    return answer


def assert_equal_to_every_splat(splat, spheres, max_distance, steps=None):
    field = SphereToEllipsoidField(splat, bisection_steps=steps)
    clearances = field.clearances(spheres, max_distance)
    answer = every_splat(
        splat, spheres, max_distance, CONVERGE if steps is None else steps
    )
    found = answer[:, 0] >= 0
    nearest, distance = field.nearest_splats(spheres, max_distance)
    np.testing.assert_array_equal(nearest, answer[:, 0])
    np.testing.assert_array_equal(distance[found], clearances.distance)
    assert np.isinf(distance[~found]).all()
    np.testing.assert_array_equal(clearances.sphere, np.flatnonzero(found))
    np.testing.assert_array_equal(
        clearances.distance, (answer[:, 1] - spheres.radius)[found]
    )
    np.testing.assert_array_equal(clearances.p_WC, answer[found, 2:5])
    np.testing.assert_array_equal(clearances.direction_W, answer[found, 5:8])
    np.testing.assert_allclose(
        np.linalg.norm(clearances.direction_W, axis=1), 1, atol=1e-14
    )


@settings(max_examples=60)
@given(
    seed=st.integers(0, 10_000),
    n=st.integers(1, 80),
    scales=st.sampled_from([2, 3]),
    smallest=st.sampled_from([1e-30, 1e-9, 1e-3]),
    largest=st.sampled_from([1e-3, 1.0, 1e3]),
    spread=st.sampled_from([0.0, 0.1, 10.0]),
    max_distance=st.sampled_from([0.0, 0.5, np.inf]),
    steps=st.sampled_from([None, None, 0, 3]),
    most_uncertain=st.sampled_from([None, 0.0, 0.01, 3.0]),
)
def test_equals_trying_every_splat(
    seed,
    n,
    scales,
    smallest,
    largest,
    spread,
    max_distance,
    steps,
    most_uncertain,
):
    rng = np.random.default_rng(seed)
    splat = make_splat(
        np.round(rng.normal(size=(n, 3)) * spread, 1),
        rng.choice([smallest, 0.01, largest], (n, scales)),
        rng.choice([-1.0, 0.0, 0.3, 1.0], (n, 4)) + np.array([2, 0, 0, 0]),
        rng.choice([0.01, 0.5], n),
        most_uncertain
        if most_uncertain is None
        else most_uncertain * rng.choice([0.0, 0.5, 1.0], n),
    )
    p_WS = np.round(rng.normal(size=(12, 3)), 1)
    p_WS[:3] = splat.p_GK[rng.integers(0, n, 3)]
    spheres = Spheres.at(p_WS, rng.uniform(0, 0.2, 12))
    spheres.ignore_below[::3] = 0.0
    assert_equal_to_every_splat(splat, spheres, max_distance, steps)


@pytest.mark.parametrize("is_certain", [True, False])
@pytest.mark.parametrize("scales", [2, 3])
def test_equals_trying_every_splat_in_a_large_scene(scales, is_certain):
    rng = np.random.default_rng(1)
    splat = random_splat(rng, 5000, scales, spread=2.0)
    if not is_certain:
        splat = splat.with_uncertainty(rng.exponential(0.02, 5000))
    spheres = Spheres.at(rng.normal(size=(100, 3)) * 3, 0.1, ignore_below=-1.0)
    assert_equal_to_every_splat(splat, spheres, 0.5)


@pytest.mark.parametrize("is_certain", [True, False])
def test_far_splats_are_never_looked_at(is_certain):
    rng = np.random.default_rng(9)
    splat = random_splat(rng, 5000, 2, spread=3.0)
    if not is_certain:
        splat = splat.with_uncertainty(rng.uniform(0, 0.1, 5000))
    field = SphereToEllipsoidField(splat)
    tree = field._tree
    question = np.array([[0, 0, 0, 0.5, -np.inf]])
    answer = np.empty((1, 8))
    query(tree, question, answer)
    # Were a far splat read, it would now be the nearest.
    moved = tree.records.copy()
    far = np.linalg.norm(moved[:, :3], axis=1) > 2.0
    assert far.sum() > 3000
    moved[far, :3] = 0
    again = np.empty((1, 8))
    query(tree._replace(records=moved), question, again)
    assert -0.1 < answer[0, 1] < 0.5
    np.testing.assert_array_equal(again, answer)


@pytest.mark.parametrize("most_uncertain", [None, 0.0, 0.3])
@pytest.mark.parametrize("scales", [2, 3])
def test_equals_the_reference(scales, most_uncertain):
    rng = np.random.default_rng(2)
    splat = random_splat(rng, 300, scales)
    if most_uncertain is not None:
        splat = splat.with_uncertainty(rng.uniform(0, most_uncertain, 300))
    p_WS = rng.normal(size=(60, 3))
    field = SphereToEllipsoidField(splat, min_opacity=0.0)
    clearances = field.clearances(Spheres.at(p_WS))
    distance, p_WC, nearest = reference.nearest_splats(splat, p_WS)
    np.testing.assert_allclose(clearances.distance, distance, atol=1e-14)
    np.testing.assert_allclose(clearances.p_WC, p_WC, atol=1e-12)
    np.testing.assert_array_equal(
        field.nearest_splats(Spheres.at(p_WS))[0], nearest
    )


def test_an_uncertain_splat_is_nearer_by_its_uncertainty():
    # The far disc may be anywhere up to 1.5 m before where it is drawn.
    p_GK = [[0, 0, 1], [0, 0, 2]]
    splat = make_splat(p_GK, [0.5, 0.5], uncertainty=[0.25, 1.5])
    field = SphereToEllipsoidField(splat)
    answer = field.clearances(Spheres.at(np.zeros(3), 0.1))
    np.testing.assert_allclose(answer.distance, [0.4])
    np.testing.assert_array_equal(answer.p_WC, [[0, 0, 2]])
    np.testing.assert_array_equal(answer.direction_W, [[0, 0, 1]])
    ignoring = SphereToEllipsoidField(splat, subtract_uncertainty=False)
    answer = ignoring.clearances(Spheres.at(np.zeros(3), 0.1))
    np.testing.assert_allclose(answer.distance, [0.9])
    assert ignoring.revision != field.revision


def test_uncertain_splats_within_a_distance_are_all_found():
    # Their shapes are beyond it, their uncertainty is not.
    splat = make_splat([0, 0, 1], [0.1, 0.1], uncertainty=[0.8])
    field = SphereToEllipsoidField(splat)
    assert len(field.clearances(Spheres.at(np.zeros(3)), 0.25)) == 1
    assert len(field.clearances(Spheres.at(np.zeros(3)), 0.15)) == 0


@settings(max_examples=30)
@given(
    seed=st.integers(0, 10_000),
    scales=st.sampled_from([2, 3]),
    step=st.sampled_from([1e-3, 0.1, 1.0]),
)
def test_no_distance_changes_faster_than_the_sphere_moves(seed, scales, step):
    rng = np.random.default_rng(seed)
    splat = random_splat(rng, 40, scales)
    splat = splat.with_uncertainty(rng.exponential(0.1, 40))
    field = SphereToEllipsoidField(splat, min_opacity=0.0)
    p_WS = rng.normal(size=(20, 3))
    moved = p_WS + step * rng.normal(size=(20, 3))
    change = (
        field.clearances(Spheres.at(moved)).distance
        - field.clearances(Spheres.at(p_WS)).distance
    )
    way = np.linalg.norm(moved - p_WS, axis=1)
    assert (np.abs(change) <= way + 1e-12).all()


@pytest.mark.parametrize("closest", [closest_on_disc, closest_on_ellipsoid])
def test_converges_for_every_shape(closest):
    # Needles, plates and balls over twelve decades; points inside, far
    # away, on the axes, on the planes of symmetry and in the centre.
    rng = np.random.default_rng(3)
    n = 2000
    e = 10 ** rng.uniform(-10, 2, (n, 3))
    e[::5, 1] = e[::5, 0]
    e[::7, 2] = e[::7, 1]
    e = -np.sort(-e, axis=1)
    y = rng.normal(size=(n, 3)) * 10 ** rng.uniform(-8, 2, (n, 1))
    y[::3] = e[::3] * rng.normal(size=y[::3].shape) * 0.4
    y[rng.random((n, 3)) < 0.1] = 0
    if closest is closest_on_disc:
        e[:, 2] = 0
    compiled = kernel(closest)
    expected = reference.closest_points(y, e)
    for i in range(n):
        distance, x = compiled(tuple(y[i]), tuple(e[i]), CONVERGE)
        size = np.linalg.norm(y[i]) + e[i, 0]
        np.testing.assert_allclose(
            abs(distance), np.linalg.norm(y[i] - expected[i]), atol=1e-15 * size
        )
        assert np.isfinite(x).all()


@pytest.mark.parametrize("scales", [2, 3])
def test_direction_is_minus_the_gradient(scales):
    rng = np.random.default_rng(4)
    splat = random_splat(rng, 40, scales)
    field = SphereToEllipsoidField(splat, min_opacity=0.0)
    # Ellipsoids overlap: inside two of them the distance is still smooth
    # but where the nearest splat changes, which a small step seldom meets.
    p_WS = np.concatenate([rng.normal(size=(40, 3)), splat.p_GK + 1e-3])
    here = field.clearances(Spheres.at(p_WS))
    if scales == 3:
        assert (here.distance < -1e-4).sum() > 10
    step = 1e-7
    gradient = np.empty_like(p_WS)
    for k in range(3):
        ahead = field.clearances(Spheres.at(p_WS + step * np.eye(3)[k]))
        behind = field.clearances(Spheres.at(p_WS - step * np.eye(3)[k]))
        gradient[:, k] = (ahead.distance - behind.distance) / (2 * step)
    error = np.abs(gradient + here.direction_W).max(axis=1)
    assert (error < 1e-5).sum() >= 78


def test_truncated_bisection_approaches_the_solution():
    rng = np.random.default_rng(5)
    splat = random_splat(rng, 100, 2)
    spheres = Spheres.at(rng.normal(size=(50, 3)))
    exact = SphereToEllipsoidField(splat).clearances(spheres).distance
    errors = [
        np.abs(
            SphereToEllipsoidField(splat, bisection_steps=steps)
            .clearances(spheres)
            .distance
            - exact
        ).max()
        for steps in (0, 3, 10, 60)
    ]
    assert errors[0] > errors[1] > errors[2] > errors[3]
    assert errors[3] < 1e-14


def test_threads_answer_alike():
    rng = np.random.default_rng(6)
    splat = random_splat(rng, 500, 2)
    spheres = Spheres.at(rng.normal(size=(37, 3)), 0.05)
    one = SphereToEllipsoidField(splat).clearances(spheres, 0.5)
    two = SphereToEllipsoidField(splat, num_threads=2).clearances(spheres, 0.5)
    for name in ("sphere", "distance", "direction_W", "p_WC"):
        np.testing.assert_array_equal(getattr(one, name), getattr(two, name))


def test_revision_follows_content_and_parameters():
    rng = np.random.default_rng(7)
    a, b = random_splat(rng, 5, 2), random_splat(rng, 5, 2)
    revisions = {
        SphereToEllipsoidField(a).revision,
        SphereToEllipsoidField(b).revision,
        SphereToEllipsoidField(a, n_sigma=2).revision,
        SphereToEllipsoidField(a, min_opacity=0).revision,
        SphereToEllipsoidField(a, bisection_steps=3).revision,
    }
    assert len(revisions) == 5
    field = SphereToEllipsoidField(a)
    assert field.clearances(Spheres.at(np.zeros(3))).revision == field.revision


def test_is_shared_not_copied():
    field = SphereToEllipsoidField(make_splat([0, 0, 0], [1.0, 1.0]))
    assert copy.deepcopy(field) is field


@pytest.mark.parametrize("name", ["p_WS", "radius", "ignore_below"])
def test_rejects_undefined_spheres(name):
    field = SphereToEllipsoidField(make_splat([0, 0, 0], [1.0, 1.0]))
    spheres = Spheres.at(np.zeros((2, 3)))
    getattr(spheres, name)[1] = np.nan
    with pytest.raises(ValueError, match="not finite"):
        field.clearances(spheres)


@pytest.mark.parametrize(
    "parameter",
    [
        {"n_sigma": 0.0},
        {"n_sigma": np.nan},
        {"bisection_steps": -1},
        {"num_threads": 0},
    ],
)
def test_rejects_parameters_out_of_range(parameter):
    with pytest.raises(ValueError, match=next(iter(parameter))):
        SphereToEllipsoidField(make_splat([0, 0, 0], [1.0, 1.0]), **parameter)


def test_survives_centres_a_denormal_away():
    d, n, _ = one_row(make_splat([0, 0, 0], [1.0, 1.0]), [0, 0, 1e-300])
    assert d == 1e-300
    np.testing.assert_array_equal(n, [0, 0, -1])


@pytest.mark.parametrize("scales", [[1e-9, 1e-9], [2e-9, 1e-9, 5e-10]])
def test_directions_keep_their_digits_beside_a_large_uncertainty(scales):
    splat = make_splat([0, 0, 0], scales, [1, 2, -3, 0.5], uncertainty=[3.0])
    exact = make_splat([0, 0, 0], scales, [1, 2, -3, 0.5])
    for p_WS in np.random.default_rng(3).normal(size=(20, 3)) * 1e-9:
        d, n, p = one_row(splat, p_WS)
        d_exact, n_exact, p_exact = one_row(exact, p_WS)
        assert d == d_exact - 3.0
        np.testing.assert_array_equal(p, p_exact)
        np.testing.assert_array_equal(n, n_exact)
        assert np.linalg.norm(n) == pytest.approx(1, abs=1e-15)


def test_real_table(shared_data):
    splat = read_ply(shared_data / "splats" / "table_0001.ply")
    rng = np.random.default_rng(8)
    spheres = Spheres.at(rng.uniform([0, -1, 0], [1.2, 1, 1.2], (30, 3)), 0.08)
    assert_equal_to_every_splat(splat, spheres, 0.5)


def test_a_truncated_bisection_promises_no_distance():
    splat = make_splat([0, 0, 5], [2.0, 1.0])
    assert SphereToEllipsoidField(splat).is_lipschitz
    assert not SphereToEllipsoidField(splat, bisection_steps=3).is_lipschitz
