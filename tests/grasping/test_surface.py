"""Points on surfaces, with outward normals."""

import numpy as np
import pytest
from pydrake.math import RigidTransform

from remosplat_drake.base.errors import RemoSplatError
from remosplat_drake.grasping.surface import (
    surface_of_mesh,
    surface_of_solid,
    surface_of_splat,
)
from remosplat_drake.scene.objects.convex_hull import ConvexHull
from remosplat_drake.scene.primitive_scene import Box, Cylinder
from remosplat_drake.splat.gaussian_splat import GaussianSplat

HALF = np.array([0.02, 0.03, 0.05])
CORNERS = (
    HALF * np.array(np.meshgrid([-1, 1], [-1, 1], [-1, 1])).reshape(3, 8).T
)


@pytest.mark.parametrize(
    "solid",
    [Box(RigidTransform(), HALF), ConvexHull(RigidTransform(), CORNERS)],
)
def test_a_box_has_points_on_six_faces(solid):
    surface = surface_of_solid(solid, 0.005)
    height = np.einsum("ni,ni->n", surface.points, surface.normals)
    faces = np.unique(surface.normals.round(6), axis=0)
    assert len(faces) == 6
    np.testing.assert_allclose(height, np.abs(surface.normals) @ HALF)
    assert (np.abs(surface.points) <= HALF + 1e-12).all()
    for normal in faces:
        on = (surface.normals.round(6) == normal).all(axis=1)
        np.testing.assert_allclose(
            surface.points[on].mean(axis=0), normal * HALF, atol=1e-3
        )


def test_a_cylinder_has_a_side_and_two_caps():
    surface = surface_of_solid(Cylinder(RigidTransform(), 0.03, 0.05), 0.005)
    p, n = surface.points, surface.normals
    side = np.abs(n[:, 2]) < 0.5
    np.testing.assert_allclose(np.linalg.norm(p[side, :2], axis=1), 0.03)
    np.testing.assert_allclose(p[side, :2], 0.03 * n[side, :2], atol=1e-12)
    np.testing.assert_allclose(p[~side, 2], 0.05 * n[~side, 2])
    assert (np.linalg.norm(p[~side, :2], axis=1) < 0.03).all()


def test_a_mesh_without_area_is_refused():
    line = np.array([[0.0, 0, 0], [1, 0, 0], [2, 0, 0]])
    with pytest.raises(RemoSplatError, match="no triangle with an area"):
        surface_of_mesh(line, np.array([[0, 1, 2]]))


def test_splats_are_discs_that_look_outwards():
    """Six discs on a cube; half of them are stored face down."""
    axes = np.concatenate([np.eye(3), -np.eye(3)])
    half = np.sqrt(0.5)
    # Turns of z to x, y, z; the discs of the far side keep the same turn.
    turns = np.array([[half, 0, half, 0], [half, -half, 0, 0], [1, 0, 0, 0]])
    n = len(axes)
    splat = GaussianSplat(
        p_GK=0.03 * axes,
        quaternions=np.concatenate([turns, turns]),
        scales=np.full((n, 2), 0.01),
        opacities=np.ones(n),
        colors=np.zeros((n, 3)),
    )
    surface = surface_of_splat(splat)
    order = [
        np.abs(surface.points - 0.03 * a).sum(axis=1).argmin() for a in axes
    ]
    np.testing.assert_allclose(surface.normals[order], axes, atol=1e-6)
