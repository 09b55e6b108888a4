"""The sweep decides as its reference does, with every kind of map."""

import numpy as np
import pytest
from asked_in_python import AskedInPython
from effort import effort
from pydrake.math import RigidTransform
from scene_sweep_reference import sweeps_clear as sweeps_clear_of_any
from verified_commands import Around, make_path
from verify_reference import least_margins

from remosplat_drake.controller.verification.kernels.between_samples import (
    TOLERANCE,
    tolerated,
)
from remosplat_drake.controller.verification.kernels.map_sweep import (
    sweeps_clear,
)
from remosplat_drake.controller.verification.map_calls import (
    MapCalls,
    map_for_kernels,
)
from remosplat_drake.oracle.composite import CompositeDistanceField
from remosplat_drake.oracle.signed_distance import SignedDistanceField
from remosplat_drake.oracle.sphere_to_ellipsoid import SphereToEllipsoidField
from remosplat_drake.oracle.uncertain_placement import UncertainPlacement
from remosplat_drake.scene.primitive_scene import Box, PrimitiveScene
from remosplat_drake.splat.gaussian_splat import GaussianSplat

DT, STOPPING = 0.05, 0.02


def blobs(rng) -> SphereToEllipsoidField:
    """Small ellipsoids around the robot."""
    n = 20
    quaternions = rng.normal(size=(n, 4))
    return SphereToEllipsoidField(
        GaussianSplat(
            p_GK=rng.uniform([-1, -1, 0], [1, 1, 1.5], (n, 3)),
            quaternions=quaternions
            / np.linalg.norm(quaternions, axis=1, keepdims=True),
            scales=rng.uniform(0.002, 0.06, (n, 3)),
            opacities=np.full(n, 0.9),
            colors=np.full((n, 3), 0.5),
        )
    )


def boxes(rng) -> SignedDistanceField:
    places = rng.uniform([-1, -1, 0], [1, 1, 1.5], (4, 3))
    return SignedDistanceField(
        PrimitiveScene(
            boxes=tuple(
                Box(RigidTransform(p), rng.uniform(0.01, 0.1, 3))
                for p in places
            )
        )
    )


def keeps_off(robot, path, field, p_WS, clearance, level, tolerance):
    with MapCalls(robot, field) as line:
        placed = *map_for_kernels(field), line
        given = p_WS.copy(), clearance, level, tolerance
        return sweeps_clear(robot.arrays, path, placed, *given)


MAPS = {
    "splats": blobs,
    "boxes": boxes,
    "both": lambda rng: CompositeDistanceField([blobs(rng), boxes(rng)]),
    "misplaced": lambda rng: UncertainPlacement(
        blobs(rng), rng.uniform(-0.3, 0.3, 2), 0.01, 0.02
    ),
}


@pytest.mark.parametrize("kind", MAPS)
def test_it_decides_as_the_sweep_of_any_map(frankie, kind):
    rng = np.random.default_rng(5)
    decided, field = [], MAPS[kind](rng)
    for trial in range(effort(100, 400)):
        if trial % 20 == 0:
            field = MAPS[kind](rng)
        arm = rng.uniform(
            frankie.position_lower[3:], frankie.position_upper[3:]
        )
        q = np.array([*rng.uniform(-0.3, 0.3, 2), rng.uniform(-3, 3), *arm])
        u = rng.uniform(-1, 1, 9) * frankie.velocity_limit
        u *= rng.choice([0.02, 0.1, 0.4])
        spheres = frankie.spheres_at(q)
        clearance = field.clearances(spheres, 0.5).per_sphere(len(spheres))
        clearance = np.minimum(clearance, 0.5)
        assert field.placed is not None
        path = make_path(frankie.arrays, q, u, DT)
        level = np.minimum(STOPPING, clearance)
        tolerance = np.array([tolerated(one, STOPPING) for one in level])
        given = path, field, spheres.p_WS, clearance, level, tolerance
        is_clear = keeps_off(frankie, *given)
        assert is_clear == sweeps_clear_of_any(frankie, *given)
        in_python = path, AskedInPython(field), *given[2:]
        assert is_clear == keeps_off(frankie, *in_python)
        decided.append(is_clear)
        if is_clear and trial % 10 == 0:
            around = Around(
                frankie,
                field,
                frankie.state(q),
                clearance,
                STOPPING,
                DT,
                frankie.acceleration_limit,
            )
            at_ends, between = least_margins(around, u, samples=20)
            assert at_ends >= -1e-9 and between >= -1e-9
    assert 0.1 < np.mean(decided) < 0.9


def test_what_it_cannot_tell_it_refuses(three_link):
    box = SignedDistanceField(
        PrimitiveScene(boxes=(Box(RigidTransform([9, 9, 9]), np.full(3, 0.1)),))
    )
    q, u = three_link.q_home, np.full(3, 0.5)
    spheres = three_link.spheres_at(q)
    nothing = np.zeros(len(spheres))
    path = make_path(three_link.arrays, q, u, DT)
    for clearance, level, expected in (
        (5.0, 0.0, True),
        (0.0, 0.0, True),  # The map says more.
        (-np.inf, 0.0, False),  # The time before the path is not known.
        (np.nan, 0.0, False),
        (0.0, 99.0, False),
    ):
        given = path, box, spheres.p_WS, nothing + clearance, nothing + level
        for sweep in (keeps_off, sweeps_clear_of_any):
            tolerance = np.full(len(spheres), TOLERANCE)
            assert sweep(three_link, *given, tolerance) == expected
