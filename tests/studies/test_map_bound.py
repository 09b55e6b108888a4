"""The study of maps' errors: its images, its disturbances, its counting."""

import numpy as np

from apps.studies.map_bound.case import Case, draw_case
from apps.studies.map_bound.disturbance import NAMED, Disturbance, disturbed
from apps.studies.map_bound.judge import Sight, random_queries
from apps.studies.map_bound.report import coverage, exceeding_scenes
from apps.studies.map_bound.trial import Result
from apps.studies.rigid_motion import CameraErrors
from remosplat_drake.capture.rendering.sensor_noise import sensor_noise
from remosplat_drake.oracle.signed_distance import SignedDistanceField
from remosplat_drake.robot.sphere_model import Spheres


def test_cast_depths_lie_on_the_solids_and_the_truth_has_no_error():
    case = Case("posts", 3, 3, Disturbance())
    scene, perfect, capture = case.captures()
    truth = SignedDistanceField(scene)
    points = np.concatenate(
        [perfect.points_W(i)[perfect.depth[i] > 0] for i in range(3)]
    )
    distance = truth.clearances(Spheres.at(points)).per_sphere(len(points))
    assert np.abs(distance).max() < 1e-5
    np.testing.assert_allclose(capture.X_WC, perfect.X_WC, atol=1e-12)
    sight = Sight(scene, perfect, capture.depth, sensor_noise("none"))
    queries = random_queries(sight, 500, np.random.default_rng(0))
    assert 0 < queries.seen.sum() < len(queries.seen)
    assert np.abs(queries.over_estimates(truth)).max() < 1e-9


def test_disturbances_are_as_large_as_they_say_and_repeat():
    _, perfect, _ = Case("posts", 3, 12, Disturbance()).captures()
    drifted = disturbed(perfect, NAMED["drift 50 mm"], 7)
    moved = np.linalg.norm((drifted.X_WC - perfect.X_WC)[:, :3, 3], axis=1)
    assert moved[0] < 1e-12 and abs(moved[-1] - 0.05) < 1e-9
    again = disturbed(perfect, NAMED["drift 50 mm"], 7)
    np.testing.assert_array_equal(again.X_WC, drifted.X_WC)
    scaled = disturbed(perfect, NAMED["depth +2 %"], 7)
    np.testing.assert_allclose(scaled.depth, 1.02 * perfect.depth, rtol=1e-6)
    assert draw_case("table", 5) == draw_case("table", 5)
    assert 20 <= draw_case("table", 5).views <= 120


def test_counting_is_by_scenes():
    errors = CameraErrors(0.0, 0.0, 0.0, 0.0)

    def result(exceeded: int, over: float) -> Result:
        return Result("", errors, errors, 100, exceeded, 0.0, over, 0.01)

    results = [result(0, 0.005)] * 9 + [result(10, 0.02)]
    share, low, high = coverage(results)
    assert share == 0.99 and 0.95 < low < 0.99 <= high <= 1
    count, limit = exceeding_scenes(results)
    assert count == 1 and 0.4 < limit < 0.5
