"""Spheres in corners have rows to all surfaces that are about as near."""

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st
from pydrake.math import RigidTransform, RollPitchYaw

from remosplat_drake.base.kernels.packed import Packed
from remosplat_drake.oracle.signed_distance import SignedDistanceField
from remosplat_drake.robot.sphere_model import Spheres
from remosplat_drake.scene.primitive_scene import Box, PrimitiveScene
from remosplat_drake.signals.distance_field import Clearances
from remosplat_drake.signals.row_arrays import row_arrays
from remosplat_drake.signals.side_rows import side_rows

RADIUS = 0.05
BALL = Spheres(
    np.zeros((1, 3)), np.eye(3)[None], np.array([RADIUS]), np.array([-np.inf])
)


def rows_of(boxes, below) -> tuple[Clearances, Clearances]:
    """The rows of a ball at the origin, without and with those beside."""
    field = SignedDistanceField(PrimitiveScene(tuple(boxes)))
    near = field.clearances(BALL)
    more = side_rows(
        field.compiled_rows,
        Packed(row_arrays(near)),
        BALL.p_WS.copy(),
        BALL.radius.copy(),
        BALL.ignore_below.copy(),
        BALL.index.copy(),
        below,
    )
    return near, Clearances(*more)


def wall(axis: int, at: float) -> Box:
    """A wall whose surface crosses an axis, thick enough to fill the rest."""
    p = np.zeros(3)
    p[axis] = at + 1.0
    return Box(RigidTransform(p), np.ones(3))


def test_a_ball_in_a_corner_has_a_row_to_each_wall():
    walls = [wall(0, 0.060), wall(1, 0.062), wall(2, 0.080)]
    near, more = rows_of(walls, below=0.02)
    np.testing.assert_allclose(near.direction_W, [[1, 0, 0]], atol=1e-12)
    # The third wall is not the nearest from anywhere 5 mm to the side.
    np.testing.assert_allclose(
        more.direction_W, [[1, 0, 0], [0, 1, 0]], atol=1e-12
    )
    np.testing.assert_allclose(more.distance, [0.010, 0.012])
    np.testing.assert_allclose(more.p_WC[1, 1], 0.062)


def test_a_ball_between_walls_that_it_enters_has_a_row_to_each():
    _, more = rows_of([wall(0, 0.04), wall(1, 0.042)], below=0.02)
    np.testing.assert_allclose(more.distance, [-0.010, -0.008])


def test_a_ball_that_is_far_enough_or_before_one_wall_gets_no_row():
    corner = [wall(0, 0.060), wall(1, 0.062)]
    assert len(rows_of(corner, below=0.01)[1].distance) == 1
    assert len(rows_of(corner[:1], below=0.1)[1].distance) == 1


@given(st.integers(0, 2**32 - 1))
@settings(max_examples=60)
def test_a_row_is_no_farther_than_its_obstacle_and_no_nearer_than_any(seed):
    rng = np.random.default_rng(seed)
    boxes = []
    for _ in range(4):
        half = rng.uniform(0.02, 0.1, 3)
        direction = rng.normal(size=3)
        direction *= rng.uniform(0.1, 0.2) / np.linalg.norm(direction)
        turn = RollPitchYaw(rng.uniform(-3, 3, 3))
        boxes.append(Box(RigidTransform(turn, direction), half))
    near, more = rows_of(boxes, below=0.05)
    alone = [rows_of([box], below=-1.0)[0] for box in boxes]
    for row in range(1, len(more.distance)):
        assert more.distance[row] >= near.distance[0]
        # The obstacle is the one whose surface the row's point lies on.
        on = [abs(_distance(box, more.p_WC[row])) for box in boxes]
        obstacle = alone[int(np.argmin(on))]
        assert more.distance[row] <= obstacle.distance[0] + 1e-9
        assert np.linalg.norm(more.direction_W[row]) > 1.0 - 1e-9


def _distance(box: Box, p_W: np.ndarray) -> float:
    """The distance of a point to a box's surface, as its faces say."""
    p = np.abs(box.X_WP.inverse().multiply(p_W)) - box.half_extents
    outside = np.linalg.norm(np.maximum(p, 0.0))
    return float(outside + min(p.max(), 0.0))
