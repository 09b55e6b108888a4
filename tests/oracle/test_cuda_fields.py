"""The fields on a CUDA device against the CPU's, and their batches."""

import copy
import pickle

import numpy as np
import pytest

from remosplat_drake.oracle.backend import missing_for_cuda
from remosplat_drake.oracle.cuda.depth_rasterization import CudaDepthField
from remosplat_drake.oracle.cuda.sphere_to_ellipsoid import (
    CudaSphereToEllipsoidField,
)
from remosplat_drake.oracle.depth_rasterization import DepthRasterizationField
from remosplat_drake.oracle.depth_sensor import DepthSensor
from remosplat_drake.oracle.sphere_to_ellipsoid import SphereToEllipsoidField
from remosplat_drake.robot.sphere_batch import SphereBatch
from remosplat_drake.robot.sphere_model import Spheres
from remosplat_drake.splat.gaussian_splat import GaussianSplat
from remosplat_drake.timing.oracle_cases import robot_spheres, table_scene
from tests.oracle.toy_views import (
    assert_equal_but_for_rounding,
    random_spheres,
    random_splat,
)

pytestmark = pytest.mark.gpu


@pytest.fixture(autouse=True, scope="module")
def cuda():
    problem = missing_for_cuda()
    if problem:
        pytest.skip(f"the CUDA backend {problem}")


def _ranges(field: CudaDepthField, spheres: Spheres, limit: float):
    answer = field.clearances(spheres, limit)
    batch = field.clearances_batch(SphereBatch.stacked([spheres]), limit)
    distance = batch.distance[0]
    rows = distance[np.isfinite(distance)]
    np.testing.assert_allclose(rows, answer.distance, atol=1e-6)
    return distance + spheres.radius[:, None]


@pytest.mark.parametrize("n_scales", [2, 3])
@pytest.mark.parametrize("uncertain", [False, True])
@pytest.mark.parametrize("seed", range(8))
def test_views_see_what_the_cpu_sees(seed, n_scales, uncertain):
    rng = np.random.default_rng(seed)
    n = [1, 20, 200, 2000][seed % 4]
    splat = random_splat(rng, n, n_scales, [0.4, 0.05][seed // 4], uncertain)
    spheres = random_spheres(rng, 20)
    sensor = DepthSensor(resolution=[80, 33, 24, 100][seed // 2])
    limit = [0.1, 0.5, np.inf][seed % 3]
    found = _ranges(CudaDepthField(splat, sensor), spheres, limit)
    assert_equal_but_for_rounding(found, splat, spheres, sensor, limit)


def test_a_robot_before_a_table():
    splat, spheres = table_scene(60_000), robot_spheres()
    solids = SphereToEllipsoidField(splat).clearances(spheres, 0.5)
    answer = CudaSphereToEllipsoidField(splat).clearances(spheres, 0.5)
    np.testing.assert_array_equal(answer.sphere, solids.sphere)
    for name in ("distance", "direction_W", "p_WC"):
        np.testing.assert_allclose(
            getattr(answer, name), getattr(solids, name), atol=3e-6
        )
    views = DepthRasterizationField(splat).clearances(spheres, 0.5)
    answer = CudaDepthField(splat).clearances(spheres, 0.5)
    np.testing.assert_array_equal(answer.sphere, views.sphere)
    for name in ("distance", "direction_W", "p_WC"):
        np.testing.assert_allclose(
            getattr(answer, name), getattr(views, name), atol=3e-6
        )


def test_the_same_question_has_the_same_answer():
    """To the last bit, in any order of threads."""
    splat, spheres = table_scene(20_000), robot_spheres()
    for field in (CudaDepthField(splat), CudaSphereToEllipsoidField(splat)):
        first = field.clearances(spheres, 0.5)
        for _ in range(20):
            again = field.clearances(spheres, 0.5)
            np.testing.assert_array_equal(again.distance, first.distance)
            np.testing.assert_array_equal(again.direction_W, first.direction_W)


def test_little_room_changes_nothing():
    """What cannot be listed is drawn with the whole scene."""
    field, spheres = CudaDepthField(table_scene(20_000)), robot_spheres()
    expected = field.clearances(spheres, 0.5)
    for rules in (field._rules, field._rules_of_few):
        rules.room = 30
    answer = field.clearances(spheres, 0.5)
    np.testing.assert_array_equal(answer.sphere, expected.sphere)
    np.testing.assert_allclose(answer.distance, expected.distance, atol=1e-6)


@pytest.mark.parametrize("n_scales", [2, 3])
@pytest.mark.parametrize("uncertain", [False, True])
@pytest.mark.parametrize("n", [1, 40, 3000])
def test_solids_are_as_far_as_on_the_cpu(n, n_scales, uncertain):
    rng = np.random.default_rng(n)
    splat = random_splat(rng, n, n_scales, uncertain=uncertain)
    spheres = random_spheres(rng, 200)
    field = CudaSphereToEllipsoidField(splat, min_opacity=0.0)
    for limit in (0.1, np.inf):
        expected = SphereToEllipsoidField(splat, min_opacity=0.0).clearances(
            spheres, limit
        )
        answer = field.clearances(spheres, limit)
        far, found = (a.per_sphere(200) for a in (expected, answer))
        edge = np.minimum(far, found) > limit - 3e-6
        with np.errstate(invalid="ignore"):
            close = np.abs(far - found) < 3e-6
        assert (edge | (far == found) | close).all()


def test_only_the_nearest_view():
    rng = np.random.default_rng(2)
    splat, spheres = random_splat(rng, 300, 2, 0.1), random_spheres(rng, 30)
    expected = DepthRasterizationField(splat, nearest_only=True)
    field = CudaDepthField(splat, nearest_only=True)
    right = expected.clearances(spheres, 0.4)
    answer = field.clearances(spheres, 0.4)
    np.testing.assert_array_equal(answer.sphere, right.sphere)
    np.testing.assert_allclose(answer.distance, right.distance, atol=3e-6)
    batch = field.clearances_batch(SphereBatch.stacked([spheres]), 0.4)
    assert (np.isfinite(batch.distance).sum(axis=2) <= 1).all()
    np.testing.assert_allclose(
        batch.distance.min(axis=2)[0], right.per_sphere(30), atol=3e-6
    )


@pytest.mark.parametrize("kind", [CudaDepthField, CudaSphereToEllipsoidField])
def test_batches_of_tensors_and_their_gradient(kind):
    import torch

    rng = np.random.default_rng(4)
    splat = random_splat(rng, 500, 3, 0.05)
    field = kind(splat)
    asked = [random_spheres(rng, 10) for _ in range(30)]
    asked = [
        Spheres(s.p_WS, s.R_WL, asked[0].radius, asked[0].ignore_below)
        for s in asked
    ]
    stacked = SphereBatch.stacked(asked)
    expected = [field.clearances(s, 0.3) for s in asked]
    answer = field.clearances_batch(stacked, 0.3)
    np.testing.assert_allclose(
        answer.distance.min(axis=2),
        [each.per_sphere(10) for each in expected],
        atol=1e-6,
    )
    p_WS = torch.tensor(stacked.p_WS, device="cuda", requires_grad=True)
    on_device = SphereBatch(
        p_WS, torch.tensor(stacked.R_WL), stacked.radius, stacked.ignore_below
    )
    tensors = field.clearances_batch(on_device, 0.3)
    assert tensors.distance.device.type == "cuda"
    np.testing.assert_array_equal(
        tensors.distance.detach().cpu().numpy(), answer.distance
    )
    np.testing.assert_array_equal(
        tensors.minimum().detach().cpu().numpy(), answer.minimum()
    )
    near = torch.isfinite(tensors.distance)
    tensors.distance[near].sum().backward()
    np.testing.assert_allclose(
        p_WS.grad.cpu().numpy(), -answer.direction_W.sum(axis=2), atol=1e-6
    )


@pytest.mark.parametrize("kind", [CudaDepthField, CudaSphereToEllipsoidField])
def test_what_is_not_known_is_refused_and_nothing_is_nothing(kind):
    rng = np.random.default_rng(0)
    field, spheres = kind(random_splat(rng, 5, 2)), random_spheres(rng, 3)
    spheres.p_WS[1] = np.nan
    with pytest.raises(ValueError, match="centre"):
        field.clearances(spheres)
    with pytest.raises(ValueError, match="centre"):
        field.clearances_batch(SphereBatch.stacked([spheres]))
    none = random_spheres(rng, 0)
    assert len(field.clearances(none)) == 0
    empty = kind(GaussianSplat.empty())
    assert len(empty.clearances(random_spheres(rng, 3))) == 0


@pytest.mark.parametrize("kind", [CudaDepthField, CudaSphereToEllipsoidField])
def test_fields_travel_to_other_processes(kind):
    rng = np.random.default_rng(0)
    splat, spheres = random_splat(rng, 100, 2, 0.1), random_spheres(rng, 5)
    field = kind(splat)
    assert copy.deepcopy(field) is field
    for other in (
        kind(splat, prepared=field.prepared),
        pickle.loads(pickle.dumps(field)),
    ):
        np.testing.assert_array_equal(
            other.clearances(spheres).distance,
            field.clearances(spheres).distance,
        )
        assert other.revision == field.revision
