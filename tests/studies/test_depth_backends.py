"""The comparison of the depth backends: the parts that need no GPU."""

import numpy as np
import pytest

from apps.studies.depth_backends.__main__ import (
    main,
    read_states,
    write_states,
)
from apps.studies.depth_backends.differences import by_view
from remosplat_drake.base.errors import FileError
from remosplat_drake.oracle.depth_rasterization import DepthRasterizationField
from remosplat_drake.oracle.depth_rows import nearest_rows
from remosplat_drake.oracle.depth_sensor import DepthSensor
from remosplat_drake.robot.sphere_model import Spheres
from remosplat_drake.splat.gaussian_splat import GaussianSplat


def _spheres(rng, n) -> Spheres:
    R_WL = np.linalg.qr(rng.normal(size=(n, 3, 3)))[0]
    R_WL *= np.linalg.det(R_WL)[:, None, None]
    p_WS = rng.uniform(-0.3, 0.3, (n, 3))
    return Spheres(p_WS, R_WL, np.full(n, 0.05), np.full(n, -np.inf))


def test_rows_are_sorted_by_view_and_back():
    rng = np.random.default_rng(0)
    splat = GaussianSplat(
        rng.uniform(-0.5, 0.5, (100, 3)),
        rng.normal(size=(100, 4)),
        np.full((100, 2), 0.05),
        np.full(100, 0.9),
        np.zeros((100, 3)),
    )
    sensor, spheres = DepthSensor(resolution=20), _spheres(rng, 5)
    answer = DepthRasterizationField(splat, sensor).clearances(spheres)
    views = by_view(answer, spheres, sensor)
    reach = views.distance + spheres.radius[:, None]
    again = nearest_rows(spheres, sensor, reach, views.pixel, "")
    np.testing.assert_array_equal(again.sphere, answer.sphere)
    for name in ("distance", "direction_W", "p_WC"):
        np.testing.assert_allclose(
            getattr(again, name), getattr(answer, name), atol=1e-12
        )


def test_states_survive_a_file(tmp_path):
    states = [_spheres(np.random.default_rng(i), 3) for i in range(2)]
    write_states(tmp_path / "states.npz", states)
    for state, again in zip(
        states, read_states(tmp_path / "states.npz"), strict=True
    ):
        np.testing.assert_allclose(again.p_WS, state.p_WS, atol=1e-7)
        np.testing.assert_array_equal(again.ignore_below, state.ignore_below)


def test_a_file_that_holds_no_states(tmp_path, capsys):
    path = tmp_path / "states.npz"
    path.write_text("nothing")
    with pytest.raises(FileError, match="not a file of --write-states"):
        read_states(path)
    assert main(["--states", str(path)]) == 2
    assert "states.npz" in capsys.readouterr().err
