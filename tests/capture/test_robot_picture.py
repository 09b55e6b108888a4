"""A robot's picture shows all of it, and little else."""

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from remosplat_drake.capture.rendering.robot_picture import framing
from remosplat_drake.robot.sphere_model import Spheres

FIELD = 0.6


@given(st.integers(0, 2**32 - 1))
def test_spheres_are_inside_the_view_and_fill_it(seed):
    rng = np.random.default_rng(seed)
    n = rng.integers(1, 20)
    spheres = Spheres(
        rng.uniform(-1, 1, (n, 3)) * rng.uniform(0, [2, 2, 5]),
        np.tile(np.eye(3), (n, 1, 1)),
        rng.uniform(0.01, 0.5, n),
        np.full(n, -np.inf),
    )
    p_CS = np.array([framing(spheres).inverse() @ p for p in spheres.p_WS])
    # The angle between the axis and what of a sphere is farthest from it, seen
    # from the side and from above.
    x, y, z = p_CS.T
    angles = []
    for across in (x, y):
        distance = np.hypot(across, z)
        assert (distance > spheres.radius).all()
        angle = np.abs(np.arctan2(across, z))
        angles.append(angle + np.arcsin(spheres.radius / distance))
    widest = np.max(angles)
    assert 0.85 * FIELD / 2 < widest < 0.95 * FIELD / 2
