"""The hall: discs on its floor, walls and boxes, evenly spread."""

import numpy as np

from remosplat_drake.reconstruction.splat_floor import find_splat_floor
from remosplat_drake.timing.hall_scene import SIZE, hall_scene


def test_discs_lie_on_surfaces():
    splat = hall_scene(40_000)
    assert len(splat) == 40_000
    half = np.array([SIZE[0] / 2, SIZE[1] / 2, SIZE[2] / 2])
    p_MK = splat.p_GK - [0, 0, half[2]]
    assert (np.abs(p_MK) < half + 0.02).all()
    # A disc's normal is that of its surface: of what lies on the floor, z.
    on_floor = np.abs(splat.p_GK[:, 2]) < 0.01
    upright = np.abs(splat.R_GK[:, 2, 2]) > 0.99
    assert upright[on_floor].mean() > 0.98
    # Planes are told apart by hundredths of the scene, which is 60 m long.
    X_FG = find_splat_floor(splat).X_FG.GetAsMatrix4()
    np.testing.assert_allclose(X_FG, np.eye(4), atol=0.02)


def test_the_floor_is_as_dense_everywhere():
    p_WK = hall_scene(100_000).p_GK
    middle = p_WK[np.linalg.norm(p_WK[:, :2], axis=1) < 1.0]
    density = len(middle) / np.pi
    floor = p_WK[np.abs(p_WK[:, 2]) < 0.01]
    # A disc of 1 m holds 60 of them, give or take 8.
    assert 0.6 < density / (len(floor) / (SIZE[0] * SIZE[1])) < 1.4


def test_one_number_gives_one_hall():
    one, other = hall_scene(20_000), hall_scene(20_000)
    assert one.content_hash == other.content_hash
