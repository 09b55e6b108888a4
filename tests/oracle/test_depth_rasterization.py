"""Depth views: worked by hand, and the fast backend against the reference."""

import copy
import dataclasses as dc

import numpy as np
import pytest
from effort import effort
from hypothesis import given, settings
from hypothesis import strategies as st

from remosplat_drake.base.errors import FieldError, RemoSplatError
from remosplat_drake.oracle import depth_rasterization_reference as reference
from remosplat_drake.oracle.depth_rasterization import DepthRasterizationField
from remosplat_drake.oracle.depth_sensor import R_DV, DepthSensor
from remosplat_drake.oracle.sphere_to_ellipsoid import SphereToEllipsoidField
from remosplat_drake.robot.sphere_model import Spheres
from remosplat_drake.splat.codecs.ply import read_ply
from remosplat_drake.splat.gaussian_splat import GaussianSplat

FACING_X = (np.sqrt(0.5), 0.0, np.sqrt(0.5), 0.0)
"""Quaternion that turns a disc's normal to the x axis."""


def _discs(rows, quaternion=FACING_X) -> GaussianSplat:
    """Discs of equal orientation from rows (x, y, z, scale, opacity)."""
    table = np.array(rows, float).reshape(-1, 5)
    n = len(table)
    return GaussianSplat(
        table[:, :3],
        np.tile(quaternion, (n, 1)),
        np.repeat(table[:, 3:4], 2, axis=1),
        table[:, 4],
        np.zeros((n, 3)),
    )


def _random_splat(rng, n, n_scales) -> GaussianSplat:
    return GaussianSplat(
        rng.uniform(-0.5, 0.5, (n, 3)),
        rng.normal(size=(n, 4)),
        np.exp(rng.uniform(np.log(0.005), np.log(0.4), (n, n_scales))),
        rng.uniform(0.002, 1.0, n),
        np.zeros((n, 3)),
    )


def _random_spheres(rng, n, ignore_below=-np.inf) -> Spheres:
    R_WL = np.linalg.qr(rng.normal(size=(n, 3, 3)))[0]
    R_WL *= np.linalg.det(R_WL)[:, None, None]
    return Spheres(
        rng.uniform(-0.5, 0.5, (n, 3)),
        R_WL,
        rng.uniform(0.02, 0.1, n),
        np.full(n, ignore_below),
    )


def _assert_same(splat, spheres, sensor, answer, limit=np.inf):
    """Equal to the reference, up to which of equally near pixels is named.

    Under the low-pass filter a whole footprint has its centre's depth, so
    that pixels placed symmetrically in a view tie but for rounding.
    """
    expected = reference.clearances(splat, spheres, sensor, limit)
    np.testing.assert_array_equal(answer.sphere, expected.sphere)
    np.testing.assert_allclose(
        answer.distance, expected.distance, rtol=0, atol=1e-9
    )
    off = np.abs(answer.direction_W - expected.direction_W).max(axis=1)
    for row in np.flatnonzero(off > 1e-9):
        assert _ties(splat, spheres, sensor, answer, row)
    reach = answer.distance + spheres.radius[answer.sphere]
    p_WS = spheres.p_WS[answer.sphere]
    p_WC = p_WS + reach[:, None] * answer.direction_W
    np.testing.assert_allclose(answer.p_WC, p_WC, rtol=0, atol=1e-9)


def _ties(splat, spheres, sensor, answer, row) -> bool:
    """Whether the reference sees that distance in the row's direction too."""
    i = answer.sphere[row]
    R_WD = sensor.R_WD(spheres.R_WL)[i]
    images = reference.render(
        splat,
        spheres.p_WS[i],
        R_WD,
        sensor,
        ignore_below=spheres.ignore_below[i],
    )
    rays_V = reference.pixel_rays(sensor)
    lengths = np.linalg.norm(rays_V, axis=2)
    units_V = rays_V / lengths[..., None]
    rays_W = np.einsum("vij,abj->vabi", R_WD @ R_DV, units_V)
    same = np.abs(rays_W - answer.direction_W[row]).max(axis=-1) < 1e-9
    ranges = images.depth * lengths
    reach = answer.distance[row] + spheres.radius[i]
    return bool((np.abs(ranges[same] - reach) < 1e-9).any())


def _distances(splat, sphere=None, **parameters):
    """Distances seen from the origin; odd, so that a ray follows each axis."""
    sensor = DepthSensor(**{"resolution": 41, **parameters})
    spheres = sphere or Spheres.at(np.zeros(3))
    field = DepthRasterizationField(splat, sensor)
    answer = field.clearances(spheres)
    _assert_same(splat, spheres, sensor, answer)
    return answer.distance


def test_views_look_along_the_six_axes():
    axes = R_DV[:, :, 2]
    np.testing.assert_array_equal(
        axes,
        [[0, 0, 1], [0, -1, 0], [0, 1, 0], [1, 0, 0], [0, 0, -1], [-1, 0, 0]],
    )
    np.testing.assert_allclose(np.linalg.det(R_DV), 1)
    np.testing.assert_allclose(R_DV @ np.swapaxes(R_DV, 1, 2), [np.eye(3)] * 6)


def test_an_opaque_disc_in_front():
    splat = _discs([(0.3, 0, 0, 0.05, 0.95)])
    field = DepthRasterizationField(splat, DepthSensor(resolution=41))
    answer = field.clearances(Spheres.at(np.zeros(3), 0.1))
    assert answer.sphere.tolist() == [0]
    assert answer.distance[0] == pytest.approx(0.2)
    np.testing.assert_allclose(answer.direction_W, [[1, 0, 0]], atol=1e-12)
    np.testing.assert_allclose(answer.p_WC, [[0.3, 0, 0]], atol=1e-7)
    assert answer.revision == field.revision
    assert not field.is_lipschitz


def test_a_disc_at_45_degrees_is_seen_at_its_edge_of_view():
    # The plane x + z = 0.4 is nearest on the ray (1, 0, 1), between two
    # views; the middles of the pixels beside it stay half a pixel off.
    turn = np.pi / 8
    splat = _discs(
        [(0.2, 0, 0.2, 1.0, 0.95)], (np.cos(turn), 0, np.sin(turn), 0)
    )
    half_pixel = 1 / 41
    ray = np.array([1 - half_pixel, 0, 1])
    expected = 0.4 / ray.sum() * np.linalg.norm(ray)
    nearest = np.sort(_distances(splat))[:2]
    np.testing.assert_allclose(nearest, expected, atol=1e-7)


def test_a_faint_floater_is_ignored():
    wall = (0.5, 0, 0, 0.1, 0.95)
    floater = (0.2, 0, 0, 0.1, 0.3)
    np.testing.assert_allclose(_distances(_discs([floater, wall])), [0.5])
    np.testing.assert_allclose(_distances(_discs([floater])), [])


def test_the_median_of_two_half_transparent_discs_is_the_one_behind():
    # T before: 1, 0.55; after: 0.3025, so 0.6975 < 0.7 accumulates on the
    # axis, and the pixel counts only with a lower cut-off.
    splat = _discs([(0.3, 0, 0, 0.1, 0.45), (0.4, 0, 0, 0.1, 0.45)])
    np.testing.assert_allclose(_distances(splat), [])
    np.testing.assert_allclose(_distances(splat, alpha_cutoff=0.69), [0.4])
    # T before: 1, 0.4: the first one stops half of the light.
    splat = _discs([(0.3, 0, 0, 0.1, 0.6), (0.4, 0, 0, 0.1, 0.45)])
    np.testing.assert_allclose(_distances(splat), [0.3], atol=1e-7)


def test_a_pixel_is_completed_by_what_lies_far_behind():
    # The near disc is the median (T = 0.4); only the wall, well beyond the
    # queried distance, makes the pixel opaque enough to count.
    near, wall = (0.2, 0, 0, 0.1, 0.6), (0.8, 0, 0, 0.1, 0.6)
    field = DepthRasterizationField(
        _discs([near, wall]), DepthSensor(resolution=41)
    )
    answer = field.clearances(Spheres.at(np.zeros(3)), max_distance=0.3)
    np.testing.assert_allclose(answer.distance, [0.2], atol=1e-7)
    assert len(_distances(_discs([near]))) == 0


def test_an_uncertain_disc_is_seen_nearer_by_its_uncertainty():
    # The one behind may be the one in front: it is opaque enough alone.
    splat = _discs([(0.5, 0, 0, 0.1, 0.95), (0.7, 0, 0, 0.1, 0.95)])
    uncertain = splat.with_uncertainty(np.array([0.1, 0.4]))
    np.testing.assert_allclose(_distances(uncertain), [0.3], atol=1e-7)
    # So may one that is drawn beyond the far plane, or around the sensor.
    far_off = splat.select(np.array([1])).with_uncertainty(0.25)
    np.testing.assert_allclose(_distances(far_off, far=0.5), [0.45], atol=1e-7)
    around = splat.select(np.array([0])).with_uncertainty(0.6)
    np.testing.assert_allclose(_distances(around), [-0.1], atol=1e-7)
    # A floater does not become a surface by being uncertain.
    faint = _discs([(0.3, 0, 0, 0.1, 0.3), (0.5, 0, 0, 0.1, 0.95)])
    faint = faint.with_uncertainty(np.array([0.2, 0.0]))
    np.testing.assert_allclose(_distances(faint), [0.5], atol=1e-7)


def test_uncertainty_may_be_ignored():
    splat = _discs([(0.5, 0, 0, 0.1, 0.95)]).with_uncertainty(0.1)
    field, ignoring = (
        DepthRasterizationField(splat, subtract_uncertainty=subtract)
        for subtract in (True, False)
    )
    sphere = Spheres.at(np.zeros(3))
    near = field.clearances(sphere).distance.min()
    far = ignoring.clearances(sphere).distance.min()
    assert far - near == pytest.approx(0.1)
    assert field.revision != ignoring.revision


def test_a_far_slanted_disc_does_not_hide_a_near_one():
    # Its centre (depth 0.1) is nearer than the small disc's (0.3), but the
    # axis meets it at depth 0.5.
    normal = np.array([0.2, 1.0]) / np.linalg.norm([0.2, 1.0])
    turn = np.arctan2(-normal[0], normal[1]) / 2
    slanted = GaussianSplat(
        np.array([[0.08, 0, 0.1], [0, 0, 0.3]]),
        np.array([[np.cos(turn), 0, -np.sin(turn), 0], [1, 0, 0, 0]]),
        np.array([[0.5, 0.5], [0.05, 0.05]]),
        np.array([0.9, 0.9]),
        np.zeros((2, 3)),
    )
    sensor = DepthSensor(resolution=41, n_sigma=4)
    spheres = Spheres.at(np.zeros(3))
    answer = DepthRasterizationField(slanted, sensor).clearances(spheres)
    _assert_same(slanted, spheres, sensor, answer)


def test_discs_whose_centres_lie_behind_or_beside_the_view_are_seen():
    # A floor disc centred 0.1 m behind the sensor reaches far before it.
    floor = _discs([(-0.1, 0, -0.1, 0.5, 0.95)], (1, 0, 0, 0))
    answer = DepthRasterizationField(
        floor, DepthSensor(resolution=40)
    ).clearances(Spheres.at(np.zeros(3)))
    forward = answer.direction_W[:, 0] > 0.7
    half_pixel = 1 / 40
    ray = np.array([1, half_pixel, 1 - half_pixel])
    assert answer.distance[forward].min() == pytest.approx(
        0.1 / ray[2] * np.linalg.norm(ray), abs=1e-6
    )


def test_near_and_far_planes():
    splat = _discs([(0.3, 0, 0, 0.05, 0.95)])
    np.testing.assert_allclose(_distances(splat, near=0.301), [])
    np.testing.assert_allclose(_distances(splat, far=0.299), [])
    inside = _discs([(0.02, 0, 0, 0.05, 0.95)])
    distance = _distances(inside, Spheres.at(np.zeros(3), 0.1))
    assert distance.min() == pytest.approx(-0.08)


def test_ignore_below_is_per_sphere_and_by_the_splats_centre():
    splat = _discs([(0.3, 0, 0.0, 0.1, 0.95), (0.6, 0, 0.1, 0.3, 0.95)])
    spheres = Spheres(
        np.zeros((3, 3)),
        np.tile(np.eye(3), (3, 1, 1)),
        np.zeros(3),
        np.array([-np.inf, 0.05, 0.2]),
    )
    answer = DepthRasterizationField(
        splat, DepthSensor(resolution=41)
    ).clearances(spheres)
    nearest = answer.per_sphere(3)
    np.testing.assert_allclose(nearest[:2], [0.3, 0.6], atol=1e-6)
    assert nearest[2] == np.inf


def test_the_sensor_turns_with_the_link_or_stays_aligned_with_the_world():
    # At 45 degrees the axis of no view meets the disc.
    splat = _discs([(0.3, 0, 0, 0.02, 0.95)])
    turned = Spheres.at(np.zeros(3))
    c = np.sqrt(0.5)
    turned = dc.replace(
        turned, R_WL=np.array([[[c, -c, 0], [c, c, 0], [0, 0, 1]]])
    )
    assert _distances(splat, turned, orientation="world").min() == (
        pytest.approx(0.3)
    )
    assert (_distances(splat, turned) > 0.3 + 1e-5).all()


def test_low_pass_filter_shows_an_edge_on_disc_at_its_centres_depth():
    edge_on = _discs([(0.001, 0, 0.4, 0.01, 0.95)])
    np.testing.assert_allclose(_distances(edge_on), [])
    filtered = _distances(edge_on, low_pass_filter=True)
    np.testing.assert_allclose(filtered, [0.4], atol=1e-6)


def test_an_ellipsoid_is_seen_where_it_is_densest_along_the_ray():
    ball = GaussianSplat(
        np.array([[0.3, 0, 0]]),
        np.array([[1.0, 0, 0, 0]]),
        np.full((1, 3), 0.05),
        np.array([0.95]),
        np.zeros((1, 3)),
    )
    # For an isotropic Gaussian at c that is the foot of c on the ray: nearer
    # the more the ray is tilted, down to the last ray with alpha >= 0.7.
    tilt = np.arcsin(0.05 * np.sqrt(2 * np.log(0.95 / 0.7)) / 0.3)
    distance = _distances(ball, resolution=161)
    assert 0.3 * np.cos(tilt) <= distance.min() < 0.3 * np.cos(tilt) + 1e-3


@settings(max_examples=effort(10, 40))
@given(
    st.integers(0, 2**32 - 1),
    st.integers(1, 60),
    st.sampled_from([2, 3]),
    st.booleans(),
    st.sampled_from([4, 9, 16, 24]),
    st.sampled_from([None, 0.0, 0.05, 0.5]),
)
def test_equals_the_reference(
    seed, n, n_scales, low_pass_filter, resolution, most_uncertain
):
    rng = np.random.default_rng(seed)
    splat = _random_splat(rng, n, n_scales)
    if most_uncertain is not None:
        splat = splat.with_uncertainty(rng.uniform(0, most_uncertain, n))
    spheres = _random_spheres(rng, 2, rng.choice([-np.inf, -0.1]))
    sensor = DepthSensor(
        resolution=resolution,
        low_pass_filter=low_pass_filter,
        orientation=rng.choice(["link", "world"]),
        alpha_cutoff=rng.uniform(0.5, 0.9),
        near=rng.uniform(0.005, 0.1),
        far=rng.uniform(0.2, 1.0),
    )
    limit = rng.choice([np.inf, 0.3])
    field = DepthRasterizationField(splat, sensor)
    answer = field.clearances(spheres, limit)
    _assert_same(splat, spheres, sensor, answer, limit)
    assert np.isfinite(answer.distance).all()
    np.testing.assert_allclose(np.linalg.norm(answer.direction_W, axis=1), 1)
    nearest = DepthRasterizationField(splat, sensor, nearest_only=True)
    answer_per_sphere = nearest.clearances(spheres, limit)
    assert len(np.unique(answer_per_sphere.sphere)) == len(answer_per_sphere)
    np.testing.assert_array_equal(
        answer_per_sphere.per_sphere(2), answer.per_sphere(2)
    )


@pytest.mark.parametrize(
    ("n_scales", "most_uncertain"),
    [
        (2, None),
        (3, 0.1),
        pytest.param(2, 0.1, marks=pytest.mark.slow),
        pytest.param(3, None, marks=pytest.mark.slow),
    ],
)
def test_equals_the_reference_among_many_splats(n_scales, most_uncertain):
    # Many enough for a deep hierarchy, and for splats to wait for others;
    # small enough for views to see past them.
    rng = np.random.default_rng(n_scales)
    splat = _random_splat(rng, 1500, n_scales)
    splat = dc.replace(splat, scales=0.2 * splat.scales)
    if most_uncertain is not None:
        splat = splat.with_uncertainty(rng.uniform(0, most_uncertain, 1500))
    spheres, sensor = _random_spheres(rng, 2), DepthSensor(resolution=19)
    answer = DepthRasterizationField(splat, sensor).clearances(spheres)
    assert len(answer) > 6
    _assert_same(splat, spheres, sensor, answer)


@pytest.mark.parametrize("thickness", [1e-3, 1e-6, 1e-9, 1e-11])
@pytest.mark.parametrize("axis", [0, 2])
def test_flat_ellipsoids_are_not_lost(thickness, axis):
    """As trained splats may be flat: their outlines must not be lost."""
    rng = np.random.default_rng(7)
    for _ in range(effort(3, 8)):
        splat = _random_splat(rng, 8, 3)
        scales = splat.scales.copy()
        scales[:, axis] = thickness
        splat = dc.replace(splat, scales=scales)
        spheres = _random_spheres(rng, 4)
        sensor = DepthSensor(resolution=25)
        answer = DepthRasterizationField(splat, sensor).clearances(spheres)
        _assert_same(splat, spheres, sensor, answer)


@pytest.mark.parametrize("size", [1e30, 1e37, 1.5e38, 3e38])
@pytest.mark.parametrize("n", [1, 20])
def test_a_disc_beyond_all_numbers_hides_nothing(size, n):
    rows = [(0.3 + 0.001 * i, 0, 0, 0.1, 0.95) for i in range(n)]
    wall, huge = _discs(rows), _discs([(0, 0, 5, size, 0.95)], (1, 0, 0, 0))
    splat = GaussianSplat(
        *(
            np.concatenate([getattr(wall, name), getattr(huge, name)])
            for name in (
                "p_GK",
                "quaternions",
                "scales",
                "opacities",
                "colors",
            )
        )
    )
    spheres = Spheres.at(np.zeros((1, 3)), 0.05)
    answer = DepthRasterizationField(splat).clearances(spheres)
    assert answer.distance[0] == pytest.approx(0.25, abs=1e-3)


@pytest.mark.parametrize("low_pass_filter", [False, True])
@pytest.mark.parametrize("resolution", [1, 2, 3, 4, 5])
def test_a_single_splat_and_few_pixels(resolution, low_pass_filter):
    rng = np.random.default_rng(resolution)
    for n in (1, 2):
        splat, spheres = _random_splat(rng, n, 2), _random_spheres(rng, 6)
        sensor = DepthSensor(
            resolution=resolution, low_pass_filter=low_pass_filter
        )
        answer = DepthRasterizationField(splat, sensor).clearances(spheres)
        _assert_same(splat, spheres, sensor, answer)


def test_a_far_plane_at_infinity():
    rng = np.random.default_rng(3)
    splat, spheres = _random_splat(rng, 60, 3), _random_spheres(rng, 6)
    sensor = DepthSensor(resolution=16, far=np.inf)
    answer = DepthRasterizationField(splat, sensor).clearances(spheres)
    _assert_same(splat, spheres, sensor, answer)


@pytest.mark.parametrize("low_pass_filter", [False, True])
@pytest.mark.parametrize("name", ["table_0001", "table_0001_noise"])
def test_equals_the_reference_on_trained_splats(
    shared_data, name, low_pass_filter
):
    # Around the edge of the table.
    splat = read_ply(shared_data / "splats" / f"{name}.ply").cropped(
        np.array([0.9, -0.06, 0.45]), np.array([1.06, 0.06, 0.65])
    )
    rng = np.random.default_rng(7)
    spheres = _random_spheres(rng, 3)
    spheres = dc.replace(
        spheres, p_WS=np.array([0.9, 0, 0.65]) + 0.2 * spheres.p_WS
    )
    sensor = DepthSensor(resolution=16, low_pass_filter=low_pass_filter)
    answer = DepthRasterizationField(splat, sensor).clearances(spheres)
    assert len(answer) >= 3
    _assert_same(splat, spheres, sensor, answer)


def test_many_fragments_outgrow_the_first_canvas():
    # 30 faint discs fill every pixel of the views: more fragments than the
    # canvas first holds, and no pixel may be lost.
    rows = [(0.3 + 0.01 * i, 0, 0, 5.0, 0.05) for i in range(30)]
    sensor = DepthSensor(resolution=8, alpha_cutoff=0.75)
    splat, spheres = _discs(rows), Spheres.at(np.zeros(3))
    answer = DepthRasterizationField(splat, sensor).clearances(spheres)
    assert len(answer) > 0
    _assert_same(splat, spheres, sensor, answer)


def test_of_equally_near_pixels_the_first_is_named():
    # A wall across the axis of a view with an even number of pixels: the four
    # around its middle are equally near.
    splat = _discs([(0.3, 0, 0, 0.2, 0.95)])
    field = DepthRasterizationField(splat, DepthSensor(resolution=40))
    answer = field.clearances(Spheres.at(np.zeros(3)))
    forward = answer.direction_W[:, 0].argmax()
    expected = np.array([1, -1 / 40, 1 / 40])
    expected /= np.linalg.norm(expected)
    np.testing.assert_allclose(answer.direction_W[forward], expected)


def test_what_is_asked_in_between_does_not_change_an_answer():
    # Threads keep their memory from query to query, one for a resolution.
    rng = np.random.default_rng(3)
    splat, spheres = _random_splat(rng, 200, 2), _random_spheres(rng, 9)
    other = _random_splat(rng, 300, 3)
    fields = [
        DepthRasterizationField(splat, DepthSensor(resolution=resolution))
        for resolution in (20, 21)
    ]
    between = DepthRasterizationField(other, DepthSensor(resolution=20))
    first = [field.clearances(spheres) for field in fields]
    between.clearances(spheres)
    for field, before in zip(fields, first, strict=True):
        after = field.clearances(spheres)
        np.testing.assert_array_equal(before.distance, after.distance)
        np.testing.assert_array_equal(before.direction_W, after.direction_W)


def test_threads_answer_alike():
    rng = np.random.default_rng(3)
    splat, spheres = _random_splat(rng, 200, 2), _random_spheres(rng, 9)
    one = DepthRasterizationField(splat).clearances(spheres)
    two = DepthRasterizationField(splat, num_threads=2).clearances(spheres)
    for name in ("sphere", "distance", "direction_W", "p_WC"):
        np.testing.assert_array_equal(getattr(one, name), getattr(two, name))


def test_nothing_to_see_and_no_sphere():
    faint = _discs([(0.3, 0, 0, 0.1, 0.001)])
    spheres = Spheres.at(np.zeros(3))
    assert len(DepthRasterizationField(faint).clearances(spheres)) == 0
    splat = _discs([(0.3, 0, 0, 0.1, 0.9)])
    none = spheres.select(np.zeros(1, bool))
    assert len(DepthRasterizationField(splat).clearances(none)) == 0
    with pytest.raises(ValueError, match="not finite"):
        DepthRasterizationField(splat).clearances(
            Spheres.at(np.full(3, np.nan))
        )


def test_revision_tells_maps_and_sensors_apart():
    splat = _discs([(0.3, 0, 0, 0.1, 0.9)])
    other = _discs([(0.3, 0, 0, 0.1, 0.8)])
    fields = [
        DepthRasterizationField(splat),
        DepthRasterizationField(other),
        DepthRasterizationField(splat, DepthSensor(far=0.5)),
        DepthRasterizationField(splat, nearest_only=True),
    ]
    assert len({field.revision for field in fields}) == len(fields)
    assert DepthRasterizationField(splat).revision == fields[0].revision
    assert copy.deepcopy(fields[0]) is fields[0]


@pytest.mark.parametrize(
    "parameters",
    [
        {"orientation": "camera"},
        {"resolution": 0},
        {"near": 0.0},
        {"far": 0.001},
        {"transmittance": 1.0},
        {"alpha_cutoff": 0.4},
        {"n_sigma": 0.0},
        {"min_alpha": -0.1},
    ],
)
def test_rejects_unusable_parameters(parameters):
    with pytest.raises(FieldError, match=next(iter(parameters))[:4]):
        DepthSensor(**parameters)


def test_rejects_unusable_choices():
    splat = _discs([(0.3, 0, 0, 0.1, 0.9)])
    with pytest.raises(FieldError, match="num_threads"):
        DepthRasterizationField(splat, num_threads=0)
    with pytest.raises(RemoSplatError, match="order"):
        reference.render(
            splat, np.zeros(3), np.eye(3), DepthSensor(), order="depth"
        )


def test_paths_are_searched_among_the_splats_solids():
    rng = np.random.default_rng(3)
    splat, spheres = _random_splat(rng, 40, 2), _random_spheres(rng, 10)
    planned = DepthRasterizationField(splat).for_look_ahead.for_planning
    assert planned.is_lipschitz
    answer = planned.clearances(spheres)
    wanted = SphereToEllipsoidField(splat).clearances(spheres)
    np.testing.assert_array_equal(answer.distance, wanted.distance)


@pytest.mark.parametrize("resolution", [80, 8])
def test_for_look_ahead_it_is_the_same_map_by_a_coarser_sensor(resolution):
    rng = np.random.default_rng(3)
    splat, spheres = _random_splat(rng, 40, 2), _random_spheres(rng, 10)
    sensor = DepthSensor(resolution=resolution, alpha_cutoff=0.6)
    field = DepthRasterizationField(splat, sensor)
    ahead = field.for_look_ahead
    assert ahead is field.for_look_ahead
    coarse = dc.replace(sensor, resolution=min(resolution, 24))
    expected = DepthRasterizationField(splat, coarse, nearest_only=True)
    answer, wanted = ahead.clearances(spheres), expected.clearances(spheres)
    np.testing.assert_array_equal(answer.sphere, wanted.sphere)
    np.testing.assert_array_equal(answer.distance, wanted.distance)
    assert ahead.revision != field.revision
    # The field itself has not changed.
    assert field.sensor == sensor
    assert len(field.clearances(spheres)) > len(answer)
