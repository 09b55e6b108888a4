"""Depth images of simulated cameras against distances to the same solids."""

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st
from pydrake.math import RigidTransform, RotationMatrix
from scipy.spatial.transform import Rotation

from remosplat_drake.detection.enclosure import RoundedBox
from remosplat_drake.detection.simulated.simulated_camera import SimulatedCamera
from remosplat_drake.oracle.signed_distance import SignedDistanceField
from remosplat_drake.robot.sphere_model import Spheres
from remosplat_drake.scene.mover import Mover, Movers
from remosplat_drake.scene.primitive_scene import Box, Cylinder, PrimitiveScene

K = np.array([[15.0, 0, 8], [0, 15.0, 6], [0, 0, 1]])
SIZE = (12, 16)


def draw(rng) -> tuple[PrimitiveScene, Movers, Spheres]:
    """A few solids of each kind before the camera."""

    def pose() -> RigidTransform:
        R = RotationMatrix(Rotation.random(rng=rng).as_matrix())
        return RigidTransform(R, rng.uniform([-1, -1, 0.8], [1, 1, 3]))

    boxes = [Box(pose(), rng.uniform(0.05, 0.4, 3)) for _ in range(2)]
    cylinders = [Cylinder(pose(), *rng.uniform(0.05, 0.3, 2))]
    movers = [
        Mover("round", pose(), rng.uniform(0, 0.3, 3), 0.1),
        Mover("box", pose(), rng.uniform(0.05, 0.3, 3), 0.0),
        Mover("capsule", pose(), np.array([0, 0, rng.uniform(0, 0.5)]), 0.15),
        Mover.sphere("ball", pose().translation(), 0.2),
    ]
    spheres = Spheres.at(rng.uniform([-1, -1, 1], [1, 1, 3], (3, 3)), 0.15)
    return (
        PrimitiveScene(tuple(boxes), tuple(cylinders)),
        Movers(0, movers),
        spheres,
    )


def distances(scene, movers, spheres, p_W) -> np.ndarray:
    field = SignedDistanceField(scene)
    apart = [field.clearances(Spheres.at(p_W)).per_sphere(len(p_W))]
    for m in movers:
        box = RoundedBox(
            m.X_WM.rotation().matrix(),
            m.X_WM.translation(),
            m.half_extents,
            m.radius,
        )
        apart.append(box.distance(p_W))
    for p_WS, radius in zip(spheres.p_WS, spheres.radius, strict=True):
        apart.append(np.linalg.norm(p_W - p_WS, axis=1) - radius)
    return np.min(apart, axis=0)


@given(seed=st.integers(0, 2**32 - 1))
@settings(max_examples=15)
def test_a_ray_ends_where_it_first_meets_something(seed):
    scene, movers, spheres = draw(np.random.default_rng(seed))
    camera = SimulatedCamera("it", K, SIZE, scene)
    depth = camera.take(np.eye(4), 0.0, movers, spheres).image.depth
    rows, columns = np.indices(SIZE)
    rays = np.stack(
        [(columns + 0.5 - 8) / 15, (rows + 0.5 - 6) / 15, np.ones(SIZE)], -1
    ).reshape(-1, 3)
    z = np.minimum(depth.reshape(-1), 5.0)
    hit = np.isfinite(depth.reshape(-1))
    ends = z[:, None] * rays
    assert (
        np.abs(distances(scene, movers, spheres, ends[hit])).max(initial=0)
        < 2e-3
    )
    for share in np.linspace(0.02, 0.98, 40):
        before = distances(scene, movers, spheres, share * ends)
        assert before.min() > -1e-3


def test_pixels_are_counted_by_mover():
    camera = SimulatedCamera("it", K, SIZE, None)
    near = Mover.sphere("near", [0, 0, 1.0], 0.3)
    behind = Mover.sphere("behind", [0, 0, 2.0], 0.3)
    aside = Mover.sphere("aside", [1.0, 0, 3.0], 0.3)
    shot = camera.take(np.eye(4), 0.0, Movers(0.0, [behind, near, aside]))
    assert shot.pixels[0] == 0
    assert shot.pixels[1] > 40 > shot.pixels[2] > 3
