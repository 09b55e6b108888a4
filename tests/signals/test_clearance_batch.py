"""Many configurations in one question, answered one by one."""

import numpy as np

from remosplat_drake.oracle.signed_distance import SignedDistanceField
from remosplat_drake.robot.sphere_batch import SphereBatch
from remosplat_drake.robot.sphere_model import Spheres


def test_rows_of_every_configuration(scene):
    rng = np.random.default_rng(0)
    asked = [Spheres.at(rng.uniform(-1, 2, (5, 3)), 0.1) for _ in range(4)]
    field = SignedDistanceField(scene, rows="per_primitive")
    batch = field.clearances_batch(SphereBatch.stacked(asked), 1.0)
    assert batch.direction_W.shape == (*batch.distance.shape, 3)
    assert len(batch) == 4 and batch.distance.shape[:2] == (4, 5)
    for c, spheres in enumerate(asked):
        rows = field.clearances(spheres, 1.0)
        assert batch.minimum()[c] == rows.minimum()
        for i in range(5):
            mine = rows.sphere == i
            n = mine.sum()
            np.testing.assert_array_equal(
                batch.distance[c, i, :n], rows.distance[mine]
            )
            np.testing.assert_array_equal(
                batch.direction_W[c, i, :n], rows.direction_W[mine]
            )
            assert np.isinf(batch.distance[c, i, n:]).all()
            assert (batch.direction_W[c, i, n:] == 0).all()


def test_where_nothing_is_near(scene):
    far_off = Spheres.at(np.full((3, 3), 100.0))
    batch = SignedDistanceField(scene).clearances_batch(
        SphereBatch.stacked([far_off]), 0.5
    )
    assert batch.distance.shape == (1, 3, 1)
    assert np.isinf(batch.minimum()).all()
