"""A floor in the splat: what a mobile base must not see, and what it must.

The splat is the trained one of a table that stands on a captured floor.
"""

from pathlib import Path

import numpy as np
import pytest
from pydrake.math import RigidTransform
from runs import load_application, run_scenario

from remosplat_drake.app.diagram import Application
from remosplat_drake.app.run_result import REACHED
from remosplat_drake.app.simulation import run
from remosplat_drake.base.errors import FieldError
from remosplat_drake.oracle.signed_distance import SignedDistanceField
from remosplat_drake.robot.sphere_model import Spheres
from remosplat_drake.scene.primitive_scene import Box, Cylinder, PrimitiveScene
from remosplat_drake.splat.codecs.ply import read_ply, write_ply
from remosplat_drake.splat.gaussian_splat import GaussianSplat

FLOOR_HEIGHT = 0.03
STOPPING = 0.021
SURFEL = 0.004  # Radius and spacing of the surfels added here [m].

# In the way of the base: left of the target, before the table.
LEG_RADIUS, LEG_HEIGHT, LEG_XY = 0.03, 0.5, (0.62, 0.30)
# Behind the base's start.
WALL_X = -0.55


def surfels(p_GK: np.ndarray, normals: np.ndarray) -> GaussianSplat:
    """Opaque discs at points, (n, 3), facing along horizontal unit normals."""
    n = len(p_GK)
    # Turn z to the normal: a quarter turn about the horizontal axis z x n.
    axis = np.column_stack([-normals[:, 1], normals[:, 0], np.zeros(n)])
    return GaussianSplat(
        p_GK=p_GK,
        quaternions=np.sqrt(0.5) * np.column_stack([np.ones(n), axis]),
        scales=np.full((n, 2), SURFEL),
        opacities=np.full(n, 0.99),
        colors=np.full((n, 3), 0.5),
    )


def leg() -> GaussianSplat:
    count = int(2 * np.pi * LEG_RADIUS / SURFEL)
    angle, z = np.meshgrid(
        np.linspace(0, 2 * np.pi, count, endpoint=False),
        np.arange(0, LEG_HEIGHT, SURFEL),
    )
    normals = np.stack([np.cos(angle), np.sin(angle), 0 * z], -1)
    points = LEG_RADIUS * normals + [*LEG_XY, 0.0]
    points[..., 2] = z
    return surfels(points.reshape(-1, 3), normals.reshape(-1, 3))


def wall() -> GaussianSplat:
    y, z = np.meshgrid(np.arange(-0.2, 1.0, SURFEL), np.arange(0, 0.8, SURFEL))
    points = np.stack([np.full_like(y, WALL_X), y, z], -1).reshape(-1, 3)
    return surfels(points, np.tile([1.0, 0.0, 0.0], (len(points), 1)))


def merged(*splats: GaussianSplat) -> GaussianSplat:
    names = ("p_GK", "quaternions", "scales", "opacities", "colors")
    return GaussianSplat(
        **{
            name: np.concatenate([getattr(splat, name) for splat in splats])
            for name in names
        }
    )


@pytest.fixture(scope="module")
def scenarios(shared_data, tmp_path_factory) -> Path:
    """The captured floor as it is, and with a leg and a wall upon it."""
    folder = tmp_path_factory.mktemp("floor")
    splat = shared_data / "splats" / "table_0001_floor.ply"
    furnished = folder / "furnished.ply"
    write_ply(furnished, merged(read_ply(splat), leg(), wall()))
    scenes = shared_data / "rmmi_scenes" / "table_new"
    file = folder / "floor.yaml"
    file.write_text(
        "\n".join(
            f"{name}: {{scene: {{splat: {path},"
            f" truth: {scenes / 'table_new_0001.json'}}}}}"
            for name, path in {"Floor": splat, "Furnished": furnished}.items()
        )
    )
    return file


@pytest.fixture(scope="module")
def furnished(scenarios) -> Application:
    return load_application(f"{scenarios}:Furnished")


def base_spheres(application: Application, q: np.ndarray) -> Spheres:
    robot = application.world.robot
    on_base = robot.spheres.on_links({"base_link"})
    return robot.spheres_at(q).select(on_base)


def added_solids(lowest: float) -> PrimitiveScene:
    """The leg and the wall from a height on, as solids."""
    half = (LEG_HEIGHT - lowest) / 2
    column = Cylinder(
        RigidTransform([*LEG_XY, lowest + half]), LEG_RADIUS, half
    )
    high = (0.8 - lowest) / 2
    slab = Box(
        RigidTransform([WALL_X - 0.1, 0.4, lowest + high]),
        np.array([0.1, 0.6, high]),
    )
    return PrimitiveScene(boxes=(slab,), cylinders=(column,))


def test_the_floor_stops_no_robot(scenarios):
    application = load_application(f"{scenarios}:Floor")
    splat_W = application.world.splat_W
    assert splat_W is not None
    assert (np.abs(splat_W.p_GK[:, 2]) < 0.02).sum() > 10_000
    result = run(application)
    assert result.outcome == REACHED
    assert set(result.metrics.statuses) == {"optimal"}
    assert result.metrics.clearance_min > STOPPING
    assert result.metrics.truth_clearance_min > 0


@pytest.mark.parametrize("spheres", ["covering", "paper"])
def test_a_base_that_sees_the_floor_stands_in_it(scenarios, spheres):
    text = f"scene: {{floor_height: -10}}, robot: {{spheres: {spheres}}}"
    with pytest.raises(FieldError, match="inside the scene: base_link"):
        load_application(f"{scenarios}:Floor", f"{{{text}}}")


def test_the_arm_does_see_the_floor(furnished):
    """Only the base is excused: a hand near the floor is told so."""
    robot, field = furnished.world.robot, furnished.world.field
    q = furnished.world.q0.copy()
    q[3:] = [np.pi / 2, 1.6, 0, -1.0, 0, 1.6, 0.8]  # Down to the left.
    clearances = field.clearances(robot.spheres_at(q))
    row = int(clearances.distance.argmin())
    assert "finger" in robot.spheres.links[clearances.sphere[row]]
    assert abs(clearances.p_WC[row, 2]) < 0.02
    assert clearances.direction_W[row, 2] < -0.9


def test_the_base_sees_legs_and_walls_at_their_true_distance(furnished):
    world = furnished.world
    assert world.truth_field is not None
    solids = SignedDistanceField(added_solids(FLOOR_HEIGHT))
    compared = 0
    for x in np.linspace(-0.05, 0.15, 5):
        for yaw in (-0.5, 0.0, 0.4):
            q = world.q0.copy()
            q[[0, 2]] = x, yaw
            spheres = base_spheres(furnished, q)
            n = len(spheres)
            true = solids.clearances(spheres).per_sphere(n)
            other = world.truth_field.clearances(spheres).per_sphere(n)
            seen = world.field.clearances(spheres).per_sphere(n)
            nearest = (true > 0) & (true < other - 0.03)
            compared += nearest.sum()
            np.testing.assert_allclose(seen[nearest], true[nearest], atol=2e-3)
    assert compared > 100


@pytest.mark.slow
def test_the_base_keeps_its_distance_from_a_leg(scenarios, furnished):
    result = run_scenario(f"{scenarios}:Furnished", "{time_limit: 6}")
    assert set(result.metrics.statuses) == {"optimal"}
    solids = SignedDistanceField(added_solids(0.0))
    nearest = [
        solids.clearances(
            base_spheres(furnished, q), max_distance=1.0
        ).minimum()
        for q in result.trajectory.q
    ]
    # The surfels' circles touch the leg's surface to a fraction of this.
    assert min(nearest) > STOPPING - 1e-3
    # It did matter: without the leg the base would have stood there.
    free = run_scenario(f"{scenarios}:Floor")
    assert (
        min(
            solids.clearances(base_spheres(furnished, q)).minimum()
            for q in free.trajectory.q
        )
        < 0
    )
