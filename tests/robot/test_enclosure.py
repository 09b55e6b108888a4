"""The spheres of shipped robots enclose them; shapes see them touch themselves.

What is proved here is what `remosplat_drake.robot.fitting.enclosure` promises.
"""

from functools import cache
from pathlib import Path

import numpy as np
import pytest
from pydrake.geometry import Box, Convex, Cylinder, Role, SceneGraph, Sphere
from pydrake.multibody.plant import AddMultibodyPlantSceneGraph, MultibodyPlant
from pydrake.systems.framework import DiagramBuilder
from scipy.spatial import ConvexHull

from remosplat_drake.base import resources
from remosplat_drake.base.directions import spread_directions
from remosplat_drake.base.errors import MissingExtraError
from remosplat_drake.robot.fitting.enclosure import standing_out
from remosplat_drake.robot.fitting.link_spheres import (
    LinkSpheres,
    measure_bulge,
)
from remosplat_drake.robot.fitting.model_surfaces import (
    SurfaceOptions,
    mesh_triangles,
    model_surfaces,
)
from remosplat_drake.robot.model_file import add_robot_model
from remosplat_drake.robot.robot_description import (
    load_robot_description,
    shipped_robots,
)
from remosplat_drake.robot.robot_model import RobotModel, load_robot
from remosplat_drake.robot.self_collision.pairs import self_collision_pairs
from remosplat_drake.robot.visuals import load_visuals

ROBOTS = shipped_robots()
MESHED = [
    pytest.param(name, marks=[pytest.mark.slow] * (name == "two_pandas"))
    for name in ROBOTS
]
"""Of each arm of `two_pandas`, the meshes and shapes are those of `panda`."""
MARGIN = 0.01
ROUND = 3e-3  # For self-collision, cylinders are prisms, a little wider.
SIDES = 64  # Then a prism is wider than its cylinder by 0.12 %.
DIRECTIONS = 3000  # Then a polyhedron is wider than its ball by 0.13 %.
CORNERS = np.array(
    [[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)], float
)


def hull_triangles(p: np.ndarray) -> np.ndarray:
    return p[ConvexHull(p).simplices]


def shape_corners(shape) -> np.ndarray:
    if isinstance(shape, Box):
        return 0.5 * shape.size() * CORNERS
    if isinstance(shape, Cylinder):  # The prism around it.
        angle = 2 * np.pi * np.arange(SIDES) / SIDES
        r, half = shape.radius() / np.cos(np.pi / SIDES), 0.5 * shape.length()
        x, y = r * np.cos(angle), r * np.sin(angle)
        ends = [
            np.column_stack([x, y, np.full(SIDES, z)]) for z in (-half, half)
        ]
        return np.vstack(ends)
    if isinstance(shape, Sphere):  # The polyhedron around it.
        p = spread_directions(DIRECTIONS)
        return shape.radius() * p / -ConvexHull(p).equations[:, 3].max()
    assert isinstance(shape, Convex), "a shape that no proof is written for"
    hull = shape.GetConvexHull()
    return np.array([hull.vertex(i) for i in range(hull.num_vertices())])


@cache
def shapes(robot: str) -> dict[str, list[np.ndarray]]:
    """The corners of each link's collision shapes in its frame."""
    plant, scene_graph = MultibodyPlant(0.0), SceneGraph()
    plant.RegisterAsSourceForSceneGraph(scene_graph)
    add_robot_model(load_robot_description(robot), plant)
    plant.Finalize()
    inspector = scene_graph.model_inspector()
    found: dict[str, list[np.ndarray]] = {}
    for geometry in inspector.GetAllGeometryIds(Role.kProximity):
        body = plant.GetBodyFromFrameId(inspector.GetFrameId(geometry))
        p_GV = shape_corners(inspector.GetShape(geometry))
        p_LV = (inspector.GetPoseInFrame(geometry) @ p_GV.T).T
        found.setdefault(body.name(), []).append(p_LV)
    return found


@cache
def meshes(robot: str) -> dict[str, np.ndarray]:
    description = load_robot_description(robot)
    if not description.visuals:
        return {}  # It is drawn as what it collides with.
    folder = Path(description.source).parent
    visuals = load_visuals(resources.resolve(description.visuals, folder))
    try:
        return {link: mesh_triangles(x) for link, x in visuals.items()}
    except MissingExtraError as error:
        pytest.skip(str(error))


def worst_mm(robot: str, spheres: str) -> dict[str, float]:
    """How far the shapes of each link stand out of a set of spheres."""
    model = load_robot(robot, spheres).spheres
    return {
        link: 1e3
        * max(
            standing_out(hull_triangles(p), model.on_link(link))
            for p in corners
        )
        for link, corners in shapes(robot).items()
        if link in model.links
    }


def test_a_cube_stands_out_by_its_corners():
    cube = hull_triangles(CORNERS)
    around = LinkSpheres(np.zeros((1, 3)), np.array([np.sqrt(3) + 1e-3]))
    assert -2e-3 < standing_out(cube, around) <= 0
    inside = LinkSpheres(np.zeros((1, 3)), np.array([1.5]))
    assert standing_out(cube, inside) == pytest.approx(np.sqrt(3) - 1.5)


def test_a_bar_stands_out_of_the_neck_between_two_spheres():
    # Spheres of radius 2 at x = -1.5 and 1.5 meet in a circle of radius
    # sqrt(1.75) = 1.323 at x = 0; the bar's edge there is 1 sqrt(2) away.
    bar = hull_triangles(CORNERS * [2, 1, 1])
    spheres = LinkSpheres(np.array([[-1.5, 0, 0], [1.5, 0, 0]]), np.full(2, 2))
    edge = np.hypot(1.5, np.sqrt(2)) - 2
    out = standing_out(bar, spheres, 1e-4)
    assert edge <= out <= edge + 1e-4
    # No corner tells.
    assert spheres.outside(CORNERS * [2, 1, 1]).max() < 0
    wider = LinkSpheres(spheres.p_LS, spheres.radius + edge + 1e-3)
    assert standing_out(bar, wider, 1e-4) <= 0


@pytest.mark.parametrize("robot", ROBOTS)
def test_every_link_that_has_shapes_has_spheres(robot):
    spheres = load_robot(robot, "covering").spheres
    assert set(spheres.links) == set(shapes(robot))


@pytest.mark.parametrize("robot", ROBOTS)
def test_the_spheres_enclose_all_collision_shapes(robot):
    assert max(worst_mm(robot, "covering").values()) <= 0


@pytest.mark.parametrize("robot", MESHED)
def test_the_spheres_enclose_all_meshes(robot):
    spheres = load_robot(robot, "covering").spheres
    for link, triangles in meshes(robot).items():
        assert standing_out(triangles, spheres.on_link(link)) <= 0, link


@pytest.mark.parametrize("robot", MESHED)
def test_the_meshes_lie_in_the_collision_shapes(robot):
    """By a millimetre: what the shapes gave away for fewer corners."""
    floor_links = load_robot_description(robot).floor_links
    for link, triangles in meshes(robot).items():
        p = triangles.reshape(-1, 3)
        if link in floor_links:  # Its shapes do not touch the floor.
            p = p[p[:, 2] > 0.005]
        above = np.full(len(p), np.inf)
        for corners in shapes(robot)[link]:
            planes = ConvexHull(corners).equations
            height = (p @ planes[:, :3].T + planes[:, 3]).max(axis=1)
            above = np.minimum(above, height)
        assert above.max() <= 1.01e-3, link


@pytest.mark.parametrize("robot", ROBOTS)
def test_contact_shapes_stay_simple(robot):
    for link, pieces in shapes(robot).items():
        assert len(pieces) <= 12, link
        # A ball is simple, for any model of it here.
        counts = {len(corners) for corners in pieces} - {DIRECTIONS}
        assert max(counts, default=0) <= 200, link


def test_the_paper_set_encloses_little():
    """What its file says: it is there to reproduce published numbers."""
    out = worst_mm("frankie", "paper")
    assert min(out.values()) > 10
    assert 90 < max(out.values()) < 105


def test_fingertips_stay_slim():
    # A gripper works next to things: see how far its spheres stand out.
    model = resources.models_dir() / "frankie/frankie.dmd.yaml"
    fingers = ("panda_leftfinger", "panda_rightfinger")
    options = SurfaceOptions(links=(*fingers, "panda_hand"))
    surfaces = model_surfaces(model, options, 17)
    spheres = load_robot("frankie", "covering").spheres
    for link in fingers:
        bulge = measure_bulge(spheres.on_link(link), surfaces[link].solid)
        assert bulge.max < 0.012


class Body:
    """The robot with its collision shapes, to be asked what touches."""

    def __init__(self, robot: RobotModel):
        self.robot = robot
        builder = DiagramBuilder()
        plant, scene_graph = AddMultibodyPlantSceneGraph(builder, 0.0)
        add_robot_model(robot.description, plant)
        for name, position in robot.description.locked.items():
            plant.GetJointByName(name).set_default_positions([position])
        plant.Finalize()
        self._diagram = builder.Build()
        self._root = self._diagram.CreateDefaultContext()
        self._context = plant.GetMyMutableContextFromRoot(self._root)
        self._plant, self._inspector = plant, scene_graph.model_inspector()
        self._joints = [plant.GetJointByName(n) for n in robot.joint_names]

    def contacts(self, q: np.ndarray) -> dict[frozenset, float]:
        """The depth of each pair of links that overlap [m]."""
        positions = self._plant.GetPositions(self._context)
        positions[[joint.position_start() for joint in self._joints]] = q
        self._plant.SetPositions(self._context, positions)
        query = self._plant.get_geometry_query_input_port().Eval(self._context)
        depth: dict[frozenset, float] = {}
        for pair in query.ComputePointPairPenetration():
            links = frozenset(map(self._link, (pair.id_A, pair.id_B)))
            depth[links] = max(depth.get(links, 0.0), pair.depth)
        return depth

    def _link(self, geometry) -> str:
        frame = self._inspector.GetFrameId(geometry)
        return self._plant.GetBodyFromFrameId(frame).name()


def contacts_and_distances(robot: RobotModel, n: int, seed: int):
    """(links, depth, our distance) wherever links overlap."""
    body, rng = Body(robot), np.random.default_rng(seed)
    pairs = self_collision_pairs(robot, MARGIN)
    arm = np.isfinite(robot.position_lower)
    lower = np.where(arm, robot.position_lower, 0)
    upper = np.where(arm, robot.position_upper, 0)
    for q in rng.uniform(lower, upper, (n, robot.n_q)):
        contacts = body.contacts(q)
        if not contacts:
            continue
        distance = dict.fromkeys(contacts, np.inf)
        for k, d in enumerate(pairs.distances(q)):
            touching = frozenset(pairs.links(k))
            if touching in distance:
                distance[touching] = min(distance[touching], d)
        for touching, depth in contacts.items():
            yield touching, depth, distance[touching]


@pytest.mark.parametrize("robot", ROBOTS)
def test_no_link_touches_another_unseen(robot):
    """Wherever Drake's shapes overlap, ours do; and many arms fold up.

    A fixed arm has no base to fold onto, so it touches itself less often. How
    deep hulls overlap, Drake rather exaggerates.
    """
    seen = list(contacts_and_distances(load_robot(robot), 200, 3))
    assert len(seen) > 8
    for links, depth, distance in seen:
        assert -depth - ROUND < distance < 0, links


@pytest.mark.parametrize("robot", ["frankie", "panda"])
def test_no_link_of_a_panda_touches_the_one_after_next(robot):
    """So no collision filter has to hide such contacts from the stations.

    A UR5e folds its forearm onto its shoulder, in truth, too.
    """
    model = load_robot(robot)
    body, tree = Body(model), model.tree
    q_home = np.r_[np.zeros(model.n_q - len(model.home)), model.home]
    rng = np.random.default_rng(5)
    for i in range(model.n_q - len(model.home), model.n_q - 1):
        middle, last = (list(tree.position).index(k) for k in (i, i + 1))
        links = {tree.names[tree.parent[middle]], tree.names[last]}
        limits = (
            model.position_lower[i : i + 2],
            model.position_upper[i : i + 2],
        )
        for angles in rng.uniform(*limits, (40, 2)):
            q = q_home.copy()
            q[i : i + 2] = angles
            assert frozenset(links) not in body.contacts(q)
