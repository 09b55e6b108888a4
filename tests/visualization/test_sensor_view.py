"""One sphere's sensor on the page."""

import numpy as np

from remosplat_drake.oracle.depth_sensor import DepthSensor
from remosplat_drake.oracle.view_images import look_around
from remosplat_drake.robot.sphere_model import Spheres
from remosplat_drake.splat.gaussian_splat import GaussianSplat
from remosplat_drake.visualization.sensor_view import (
    SEEN,
    SENSOR,
    SensorView,
    frustum_edges,
)


def test_frusta_fill_a_cube_around_the_sensor():
    p_WS = np.array([1.0, 2.0, 3.0])
    start, end = frustum_edges(p_WS, np.eye(3), 0.2)
    length = np.linalg.norm(end - start, axis=1)
    np.testing.assert_allclose(length[:8], 0.2 * np.sqrt(3))
    np.testing.assert_allclose(length[8:], 0.4)
    np.testing.assert_array_equal(start[:8], np.tile(p_WS, (8, 1)))
    corners = np.unique(np.concatenate([start[8:], end[8:]]), axis=0)
    np.testing.assert_allclose(np.abs(corners - p_WS), 0.2)
    assert len(corners) == 8


def test_only_views_that_see_something_have_a_ray(page, pose_of):
    wall = GaussianSplat(
        p_GK=np.array([[0.5, 0, 0]]),
        quaternions=np.array([[np.sqrt(0.5), 0, np.sqrt(0.5), 0]]),
        scales=np.array([[0.1, 0.1]]),
        opacities=np.array([0.99]),
        colors=np.zeros((1, 3)),
    )
    sphere = Spheres.at(np.zeros(3), 0.1)
    sensor = DepthSensor(resolution=9)
    SensorView(page, look_around(wall, sensor, sphere, 0))
    meshcat = page.meshcat
    seen = [
        view
        for view in range(6)
        if meshcat.HasPath(f"{SENSOR}/closest/{view}/ray")
    ]
    assert seen == [3]
    p_WC = pose_of(meshcat, f"{SENSOR}/closest/3/point")[:3, 3]
    np.testing.assert_allclose(p_WC, [0.5, 0, 0], atol=1e-6)
    assert meshcat.HasPath(SEEN)
