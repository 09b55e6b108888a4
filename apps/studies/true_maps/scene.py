"""`MeshScene`: a room of triangle meshes, drawn from a seed.

It uses no boxes and cylinders of `remosplat_drake.generation`, so constants
tuned on those scenes have no advantage here.
"""

import dataclasses as dc

import numpy as np
from pydrake.math import RigidTransform, RollPitchYaw

from apps.studies.true_maps.meshes.furniture import (
    Thing,
    chair,
    lamp,
    room,
    table,
)
from apps.studies.true_maps.meshes.mesh import Mesh
from apps.studies.true_maps.meshes.small_things import (
    bottle,
    hanging_cable,
    lying_cable,
    plant,
    rod,
)

KINDS = {
    "room": ("bottles", "chairs", "lamps", "plants", "cables", "rods"),
    "solids": ("bottles",),
    "chairs": ("bottles", "chairs"),
    "plants": ("bottles", "plants"),
    "lamps": ("bottles", "lamps"),
    "cables": ("bottles", "cables"),
    "rods": ("rods",),
}
"""Content of scenes besides floor, walls and table, by kind."""

COLORS = {
    "floor": (150, 120, 95),
    "wall": (205, 200, 190),
    "table": (160, 105, 60),
    "table leg": (110, 75, 45),
    "chair seat": (70, 90, 120),
    "chair leg": (60, 60, 65),
    "chair slat": (90, 70, 55),
    "lamp foot": (70, 70, 75),
    "lamp stalk": (180, 180, 185),
    "lamp shade": (230, 215, 170),
    "pot": (175, 95, 65),
    "stem": (80, 105, 50),
    "leaf": (70, 140, 65),
    "bottle": (55, 120, 95),
    "cable": (40, 40, 45),
    "rod": (170, 170, 180),
}
"""Colour of each label of a part, in sRGB."""

_APART = 0.12
"""Least distance between the bases of objects on the table [m]."""

_ROOM_HEIGHT = 2.4  # [m]


@dc.dataclass(frozen=True, eq=False)
class Part:
    """A mesh with its label.

    Attributes:
        label: A key of `COLORS`.
        mesh: The surface, in W.
    """

    label: str
    mesh: Mesh


@dc.dataclass(frozen=True, eq=False)
class MeshScene:
    """A scene whose surfaces are known exactly; z is up, the floor at z = 0.

    Attributes:
        parts: All surfaces.
        focus_W: Centre of the robot's workspace, shape (3,) [m].
        open_to: Direction from the focus in the floor's plane that faces away
            from both walls [rad].
        open_by: Largest angle of cameras to either side of it [rad].
    """

    parts: tuple[Part, ...]
    focus_W: np.ndarray
    open_to: float = np.pi / 4
    open_by: float = np.pi


def draw_scene(seed: int, kind: str = "room") -> MeshScene:
    """Draws a room with a table, and the other objects of its kind.

    The table's centre is at x = y = 0; a wall is 0.75 to 1.6 m away from it
    along -x, and another one along -y.

    Args:
        seed: Seed of all random numbers.
        kind: A key of `KINDS`.
    """
    rng = np.random.default_rng([seed, *kind.encode()])
    half = rng.uniform([0.4, 0.3], [0.75, 0.5])
    top = rng.uniform(0.68, 0.8)
    walls = tuple(rng.uniform(half.max() + 0.05, 1.6, 2))
    things = [
        room(walls, 2.6, _ROOM_HEIGHT),
        table(rng, half, top),
    ]
    feet = _feet(rng, half, top)
    for group in KINDS[kind]:
        things += _GROUPS[group](rng, half, top, feet)
    focus_W = np.array([*rng.uniform(-0.15, 0.15, 2), top])
    focus_W[2] += rng.uniform(0.05, 0.3)
    return MeshScene(parts_of(things), focus_W, np.pi / 4, np.deg2rad(105))


def parts_of(things: list[Thing]) -> tuple[Part, ...]:
    """Returns the meshes of objects with their labels, in order."""
    return tuple(
        Part(label, mesh) for thing in things for label, mesh in thing.items()
    )


def _feet(
    rng: np.random.Generator, half: np.ndarray, top: float
) -> list[np.ndarray]:
    """Places on the table that are apart from each other, in random order."""
    chosen: list[np.ndarray] = []
    # A round table's radius is the larger half; both tops hold this ellipse.
    for _ in range(200):
        turn, part = rng.uniform(0, 2 * np.pi), np.sqrt(rng.uniform(0, 0.7))
        foot = part * half * [np.cos(turn), np.sin(turn)]
        if all(np.linalg.norm(foot - other[:2]) > _APART for other in chosen):
            chosen.append(np.array([*foot, top]))
    return chosen


def _placed(thing: Thing, p_W: np.ndarray, turn: float = 0.0) -> Thing:
    """An object at its place, rotated about the vertical [rad]."""
    X_WT = RigidTransform(RollPitchYaw(0, 0, turn), p_W)
    return {label: mesh.moved(X_WT) for label, mesh in thing.items()}


def _bottles(rng, half, top, feet) -> list[Thing]:
    return [_placed(bottle(rng), feet.pop()) for _ in range(rng.integers(1, 4))]


def _chairs(rng, half, top, feet) -> list[Thing]:
    """Chairs that face the table from its open sides."""
    chairs = []
    sides = rng.permutation(3)[: rng.integers(1, 4)]
    for turn in np.deg2rad(-35) + np.deg2rad(80) * sides:
        turn += rng.uniform(-0.2, 0.2)
        away = half.max() + rng.uniform(0.05, 0.35)
        p_W = np.array([away * np.cos(turn), away * np.sin(turn), 0])
        facing = turn + np.pi + rng.uniform(-0.4, 0.4)
        chairs.append(_placed(chair(rng), p_W, facing))
    return chairs


def _lamps(rng, half, top, feet) -> list[Thing]:
    """A lamp on the floor behind the table, one on the table, or both."""
    floor, desk = [(True, False), (False, True), (True, True)][rng.integers(3)]
    lamps = []
    if floor:
        p_W = np.array([-half.max(), rng.uniform(-0.3, 0.5), 0])
        thing = lamp(rng, rng.uniform(1.3, 1.7), rng.uniform(0.12, 0.2))
        lamps.append(_placed(thing, p_W, rng.uniform(-1, 1)))
    if desk:
        thing = lamp(rng, rng.uniform(0.3, 0.5), rng.uniform(0.06, 0.1))
        lamps.append(_placed(thing, feet.pop(), rng.uniform(0, 2 * np.pi)))
    return lamps


def _plants(rng, half, top, feet) -> list[Thing]:
    """A plant on the table, and sometimes one on the floor."""
    plants = [_placed(plant(rng, rng.uniform(0.25, 0.5)), feet.pop())]
    if rng.random() < 0.4:
        p_W = np.array([rng.uniform(-0.3, 0.3), -half.max() - 0.25, 0])
        plants.append(_placed(plant(rng, rng.uniform(0.7, 1.2)), p_W))
    return plants


def _cables(rng, half, top, feet) -> list[Thing]:
    """Cables on the table, cables from above, or both."""
    lying, hanging = [(1, 0), (0, 1), (1, 1), (2, 2)][rng.integers(4)]
    on_table = np.array([0, 0, top])
    cables = [_placed(lying_cable(rng, half), on_table) for _ in range(lying)]
    for _ in range(hanging):
        height = _ROOM_HEIGHT - top
        cables.append(_placed(hanging_cable(rng, height), feet.pop()))
    return cables


def _rods(rng, half, top, feet) -> list[Thing]:
    return [
        _placed(
            rod(rng, rng.uniform(0.006, 0.016), rng.uniform(0.2, 0.6)),
            feet.pop(),
        )
        for _ in range(rng.integers(1, 5))
    ]


_GROUPS = {
    "bottles": _bottles,
    "chairs": _chairs,
    "lamps": _lamps,
    "plants": _plants,
    "cables": _cables,
    "rods": _rods,
}
