"""Generates random problems of picking and placing objects."""

import dataclasses as dc
from collections.abc import Callable, Sequence

import numpy as np
from pydrake.math import RigidTransform

from remosplat_drake.base.errors import RemoSplatError, unknown_name
from remosplat_drake.generation.object_library import (
    draw_solid,
    placed_object,
    standing,
)
from remosplat_drake.generation.room import room
from remosplat_drake.generation.scene_families import box
from remosplat_drake.grasping.grasps import FRICTION, Grasp, plan_grasps
from remosplat_drake.grasping.gripper import ParallelGripper
from remosplat_drake.grasping.hand_spheres import HandSpheres
from remosplat_drake.grasping.surface import Surface, surface_of_solid
from remosplat_drake.oracle.composite import CompositeDistanceField
from remosplat_drake.oracle.object_field import ObjectField
from remosplat_drake.oracle.signed_distance import SignedDistanceField
from remosplat_drake.scene.objects.convex_hull import ConvexHull
from remosplat_drake.scene.objects.drake_shapes import object_inertia
from remosplat_drake.scene.objects.scene_object import SceneObject, Solid
from remosplat_drake.scene.primitive_scene import Box, PrimitiveScene

TARGET, SUPPORT, GOAL_SUPPORT = "target", "table", "shelf"
"""Names of the object to grasp (the target), and of its supports before and
after the task."""

LEAST_GAP = 0.09
"""The gap between two objects is at least this wide [m]. It has room for a
finger and the finger's clearances."""

GRASPS = 12
"""A problem has at most this many grasps."""

_LOOKS = 25
"""Grasps are searched at no more than this many points of an object."""

_KEPT = 0.025
"""The spheres of the hand are at least this far from all objects except the
target [m]. This distance is larger than the controllers' stopping distance."""

_TRIES = 200
"""For an object, this many random places are tried."""

_SPACING = 0.015
"""Spacing of points on the surroundings of an object [m]."""

_NEAR = 0.25
"""Surfaces up to this distance count as the surroundings of an object [m]."""


@dc.dataclass(frozen=True, eq=False)
class Spot:
    """A level rectangle on which objects are put.

    Attributes:
        support: Name of the solid that contains the rectangle.
        lower: Corner with the least x and y; z is the rectangle's height, (3,)
            [m].
        upper: Opposite corner, shape (3,) [m].
        approach_W: Best direction of approach of a hand, shape (3,).
    """

    support: str
    lower: np.ndarray
    upper: np.ndarray
    approach_W: np.ndarray


@dc.dataclass(frozen=True, eq=False)
class PickAndPlace:
    """A problem: the robot takes the target, and puts it down elsewhere.

    Attributes:
        name: Family and seed.
        robot: Name of the robot.
        scene: The furniture.
        objects: The objects, the target first.
        pick: Rectangle on which the target stands.
        place: Rectangle on which the target must be put down.
        X_WO_goal: Pose of the target in W at the goal.
        grasps: Grasps of the target that are possible at both places, the best
            first; empty if the hand is too small for the target.
    """

    name: str
    robot: str
    scene: PrimitiveScene
    objects: tuple[SceneObject, ...]
    pick: Spot
    place: Spot
    X_WO_goal: RigidTransform
    grasps: tuple[Grasp, ...]


def pick_and_place(
    family: str,
    seed: int,
    gripper: ParallelGripper,
    hulls: Sequence[np.ndarray] = (),
) -> PickAndPlace:
    """Generates a problem of picking and placing.

    - `table`: a Panda in front of a table, whose top is 0 to 0.15 m above the
      Panda's foot; the goal is another place on the table.
    - `shelf`: as `table`, but the goal is in a bay beside the robot.
    - `room`: Frankie drives through a doorway to a table (family `room` of the
      scenes), and puts the target elsewhere on it.

    One to four other objects are near the target. Half of all objects are from
    `hulls`, if there are any.

    Args:
        family: One of `FAMILIES`.
        seed: Any non-negative integer; with the family and the hulls it
            determines the result.
        gripper: The gripper of the family's robot.
        hulls: Vertices of further objects, as in `MeshLibrary.hulls`.

    Raises:
        RemoSplatError: There is no such family, or no place for the target.
    """
    if family not in FAMILIES:
        raise RemoSplatError(unknown_name("family", family, FAMILIES))
    rng = np.random.default_rng([*family.encode(), seed])
    robot, make = FAMILIES[family]
    name = f"{family}-{seed:04d}"
    scene, pick, place = make(rng, name)
    objects: list[SceneObject] = []
    for i in range(2 + int(rng.integers(4))):
        solid = _draw(rng, hulls)
        label = TARGET if not i else f"thing {i}"
        p_W = _free_place(rng, pick, solid, objects)
        if p_W is not None:
            yaw = rng.uniform(-np.pi, np.pi)
            objects.append(placed_object(solid, label, p_W, yaw, rng))
        elif not i:
            raise RemoSplatError(f"{name}: there is no place for the target")
    target = objects[0]
    p_W = _free_place(rng, place, target.solid, objects)
    if p_W is None:
        raise RemoSplatError(f"{name}: there is no place for the goal")
    up = p_W[2] - target.corners[0, 2]
    X_WO_goal = RigidTransform(target.X_WO.rotation(), [p_W[0], p_W[1], up])
    grasps = _grasps(scene, objects, (pick, place), X_WO_goal, gripper, rng)
    return PickAndPlace(
        name,
        robot,
        scene,
        tuple(objects),
        pick,
        place,
        X_WO_goal,
        tuple(grasps),
    )


def _draw(rng: np.random.Generator, hulls: Sequence[np.ndarray]) -> Solid:
    if len(hulls) and rng.random() < 0.5:
        stood = standing(hulls[int(rng.integers(len(hulls)))])
        if stood is not None:
            return ConvexHull(RigidTransform(), stood, "mesh")
    return draw_solid(rng)


def _free_place(
    rng: np.random.Generator,
    spot: Spot,
    solid: Solid,
    objects: Sequence[SceneObject],
) -> np.ndarray | None:
    """A free place on a spot, shape (3,); None if there is none."""
    radius = footprint(solid)
    for _ in range(_TRIES):
        p_W = rng.uniform(spot.lower, spot.upper)
        gaps = [
            np.linalg.norm(p_W[:2] - other.X_WO.translation()[:2])
            - radius
            - footprint(other.solid)
            for other in objects
        ]
        if all(gap > LEAST_GAP for gap in gaps):
            return p_W
    return None


def footprint(solid: Solid) -> float:
    """Returns the radius of a solid's footprint [m].

    A circle of this radius about the solid's origin O contains the footprint.
    """
    if isinstance(solid, Box):
        return float(np.linalg.norm(solid.half_extents[:2]))
    if isinstance(solid, ConvexHull):
        return float(np.linalg.norm(solid.vertices[:, :2], axis=1).max())
    return solid.radius


def _grasps(
    scene: PrimitiveScene,
    objects: Sequence[SceneObject],
    spots: tuple[Spot, Spot],
    X_WO_goal: RigidTransform,
    gripper: ParallelGripper,
    rng: np.random.Generator,
) -> list[Grasp]:
    target, pick, place = objects[0], *spots
    X_WO = target.X_WO
    others = [each.solid for each in objects[1:]]
    solids = [*scene.primitives, *others]
    around = points_near(solids, X_WO)
    approach_W = pick.approach_W + place.approach_W
    approach_W = approach_W / np.linalg.norm(approach_W)
    grasps = plan_grasps(
        surface_of_solid(target.solid),
        gripper,
        approach_O=X_WO.rotation().matrix().T @ approach_W,
        around=around,
        p_OOcm=object_inertia(target).get_com(),
        friction=FRICTION,
        most=_LOOKS,
        rng=rng,
    )
    hand = HandSpheres.of(gripper)
    rest = SignedDistanceField(scene)
    if others:
        rest = CompositeDistanceField([rest, ObjectField(objects[1:])])
    suiting = []
    for grasp in grasps:
        if all(
            hand.keeps(rest, X_WX @ grasp.X_OE, _KEPT)
            for X_WX in (X_WO.GetAsMatrix4(), X_WO_goal.GetAsMatrix4())
        ):
            suiting.append(grasp)
        if len(suiting) == GRASPS:
            break
    return suiting


def points_near(solids: Sequence[Solid], X_WO: RigidTransform) -> np.ndarray:
    """Returns points on solids near an object, in its frame O, (n, 3) [m].

    Args:
        solids: The solids, placed in W.
        X_WO: Pose of the object.
    """
    p_WO, found = X_WO.translation(), [np.zeros((0, 3))]
    for solid in solids:
        p_W = in_world(surface_of_solid(solid, _SPACING), solid.X_WP).points
        found.append(p_W[np.abs(p_W - p_WO).max(axis=1) < _NEAR])
    p_W = np.concatenate(found)
    return X_WO.inverse().multiply(p_W.T).T.reshape(-1, 3)


def in_world(surface: Surface, X_WO: RigidTransform) -> Surface:
    """Expresses the surface of an object in W.

    Args:
        surface: The surface in O.
        X_WO: The object's pose.
    """
    R_WO = X_WO.rotation().matrix()
    return Surface(
        surface.points @ R_WO.T + X_WO.translation(),
        surface.normals @ R_WO.T,
        surface.spacing,
    )


Family = tuple[PrimitiveScene, Spot, Spot]
"""The furniture, and the rectangles for the target before and after the
task."""

_DOWN = np.array([0.0, 0.0, -1.0])


def _named(solid: Box, name: str) -> Box:
    return dc.replace(solid, name=name)


def _table(rng: np.random.Generator, name: str) -> Family:
    """A table top before the Panda, whose foot is at the origin, and a wall."""
    height = rng.uniform(0.02, 0.15)
    top = box([0.525, 0.0, height - 0.01], [0.275, 0.6, 0.01])
    wall = _named(box([-0.75, 0.0, 0.5], [0.02, 1.0, 0.5]), "wall")
    scene = PrimitiveScene(boxes=(_named(top, SUPPORT), wall), name=name)
    lower, upper = np.array([0.4, -0.35]), np.array([0.62, 0.35])
    spot = Spot(
        SUPPORT, np.append(lower, height), np.append(upper, height), _DOWN
    )
    return scene, spot, spot


def _shelf(rng: np.random.Generator, name: str) -> Family:
    """A table before the Panda, and a bay at its left side."""
    scene, pick, _ = _table(rng, name)
    pick = dc.replace(pick, upper=np.array([0.62, 0.15, pick.upper[2]]))
    floor = pick.lower[2] + rng.uniform(0.1, 0.3)
    front, deep, bay = rng.uniform(0.42, 0.5), 0.35, rng.uniform(0.36, 0.42)
    middle, half = front + deep / 2, deep / 2
    x, wide = rng.uniform(-0.1, 0.15), rng.uniform(0.28, 0.4)
    boards = [
        box([x, middle, floor - 0.01], [wide, half, 0.01]),
        box([x, middle, floor + bay + 0.01], [wide, half, 0.01]),
        box([x, front + deep + 0.01, floor + bay / 2], [wide, 0.01, bay / 2]),
    ]
    boards[0] = _named(boards[0], GOAL_SUPPORT)
    scene = dc.replace(scene, boxes=(*scene.boxes, *boards))
    place = Spot(
        GOAL_SUPPORT,
        np.array([x - wide + 0.15, front + 0.06, floor]),
        np.array([x + wide - 0.15, front + 0.14, floor]),
        np.array([0.0, 1.0, 0.0]),
    )
    return scene, pick, place


def _room(rng: np.random.Generator, name: str) -> Family:
    """Returns the family `room` without its cylinders."""
    scene = room(rng, name)
    tops = [i for i, each in enumerate(scene.boxes) if _is_table_top(each)]
    boxes = list(scene.boxes)
    (i,) = tops
    boxes[i] = _named(boxes[i], SUPPORT)
    p_WP, half = boxes[i].X_WP.translation(), boxes[i].half_extents
    edge = p_WP + half * [-1.0, 0.0, 1.0]
    lower = edge + np.array([0.08, -0.8 * half[1], 0.0])
    upper = edge + np.array([0.3, 0.8 * half[1], 0.0])
    spot = Spot(SUPPORT, lower, upper, _DOWN)
    scene = dc.replace(
        scene, boxes=tuple(boxes), cylinders=(), X_WE_target=None
    )
    return scene, spot, spot


def _is_table_top(solid: Box) -> bool:
    return bool(solid.half_extents[2] < 0.03 and solid.half_extents[0] > 0.3)


FAMILIES: dict[str, tuple[str, Callable[..., Family]]] = {
    "table": ("panda", _table),
    "shelf": ("panda", _shelf),
    "room": ("frankie", _room),
}
"""The families of problems, with their robots."""
