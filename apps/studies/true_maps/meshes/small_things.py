"""Meshes of small objects: plants, bottles, cables, rods.

Each is a dictionary of meshes by label, in a frame whose z axis points up from
the supporting surface.
"""

import numpy as np

from apps.studies.true_maps.meshes.furniture import Thing
from apps.studies.true_maps.meshes.mesh import (
    Mesh,
    curve,
    joined,
    sheet,
    tube,
    upright,
)


def plant(rng: np.random.Generator, size: float) -> Thing:
    """Makes a pot with stems that bend outwards, and leaves along them.

    Args:
        rng: Source of randomness.
        size: Height of the plant, about [m].
    """
    pot, height = rng.uniform(0.15, 0.22) * size, rng.uniform(0.2, 0.3) * size
    stems, leaves = [], []
    for turn in _around(int(rng.integers(4, 8)), rng):
        out = np.array([np.cos(turn), np.sin(turn), 0])
        reach, top = rng.uniform([0.1, 0.6], [0.45, 1.0]) * size
        stem = curve(
            [
                0.3 * pot * out + [0, 0, 0.9 * height],
                0.3 * pot * out + [0, 0, 0.7 * top],
                reach * out + [0, 0, top],
            ]
        )
        stems.append(tube(stem, rng.uniform(0.0015, 0.004), 8))
        for number in rng.choice(np.arange(18, 40), 4, replace=False):
            side = turn + rng.uniform(-1.3, 1.3)
            length = rng.uniform(0.15, 0.35) * size
            leaves.append(_leaf(rng, stem[number], side, length))
    return {
        "pot": upright(
            [0, height, height, 0.9 * height],
            [0.75 * pot, pot, 0.93 * pot, 0.93 * pot],
        ),
        "stem": joined(stems),
        "leaf": joined(leaves),
    }


def bottle(rng: np.random.Generator) -> Thing:
    """Makes a bottle: a body, a shoulder and a neck, all of revolution."""
    radius, height = rng.uniform(0.025, 0.045), rng.uniform(0.15, 0.32)
    neck, shoulder = rng.uniform(0.3, 0.6) * radius, rng.uniform(0.5, 0.7)
    part = np.linspace(0, 1, 9)
    fall = radius + (neck - radius) * (1 - np.cos(np.pi * part)) / 2
    rings = height * (shoulder + 0.2 * part)
    return {"bottle": upright([0, *rings, height], [radius, *fall, neck])}


def lying_cable(rng: np.random.Generator, half: np.ndarray) -> Thing:
    """Makes a cable of 3 to 12 mm that winds over a table and off its edge.

    Args:
        rng: Source of randomness.
        half: Half the length and width of the table, shape (2,) [m].
    """
    radius = rng.uniform(0.0015, 0.006)
    edge = half[0] + radius
    y = rng.uniform(-0.8, 0.8, 5) * half[1]
    x = np.linspace(-0.8, 0.85, 5) * half[0]
    winding = curve([[a, b, radius] for a, b in zip(x, y, strict=True)], 60)
    over = curve(
        [
            winding[-1],
            [edge, y[-1], radius],
            [edge + radius, y[-1], radius],
            [edge + radius, y[-1], -0.1],
            [edge + 0.05, y[-1], -rng.uniform(0.3, 0.5)],
        ]
    )
    return {"cable": tube(np.concatenate([winding, over[1:]]), radius)}


def hanging_cable(rng: np.random.Generator, height: float) -> Thing:
    """Makes a cable of 3 to 12 mm that sags from above to its foot.

    Args:
        rng: Source of randomness.
        height: Height of its upper end [m].
    """
    radius, turn = rng.uniform(0.0015, 0.006), rng.uniform(0, 2 * np.pi)
    away = rng.uniform(0.1, 0.6) * np.array([np.cos(turn), np.sin(turn)])
    hung = curve(
        [
            [*away, height],
            [*(0.9 * away), 0.4 * height],
            [*(0.5 * away), 0.05],
            [0, 0, radius],
        ]
    )
    return {"cable": tube(hung, radius)}


def rod(rng: np.random.Generator, diameter: float, length: float) -> Thing:
    """Makes a rod that stands upright, or leans by up to 60 degrees.

    Args:
        rng: Source of randomness.
        diameter: Thickness of the rod [m].
        length: Length of the rod [m].
    """
    lean = rng.choice([0.0, rng.uniform(0, np.deg2rad(60))])
    turn = rng.uniform(0, 2 * np.pi)
    axis = [np.sin(lean) * np.cos(turn), np.sin(lean) * np.sin(turn)]
    end = length * np.array([*axis, np.cos(lean)])
    return {"rod": tube(np.array([np.zeros(3), end]), diameter / 2)}


def _around(count: int, rng: np.random.Generator) -> np.ndarray:
    """Directions around a circle, with distances between them [rad]."""
    free = 2 * np.pi / count
    return free * (np.arange(count) + rng.uniform(-0.3, 0.3, count))


def _leaf(
    rng: np.random.Generator, p_W: np.ndarray, turn: float, length: float
) -> Mesh:
    """A sheet that bends down along its length and up at its sides."""
    width = rng.uniform(0.25, 0.5) * length
    rise, fall = rng.uniform(0.0, 0.6), rng.uniform(0.3, 0.9)
    u, v = np.meshgrid(
        np.linspace(0, 1, 12), np.linspace(-1, 1, 7), indexing="ij"
    )
    out = np.array([np.cos(turn), np.sin(turn), 0])
    across = np.array([-np.sin(turn), np.cos(turn), 0])
    half = width / 2 * np.sin(np.pi * u**0.8) * v
    height = length * (rise * u - fall * u**2) + 0.15 * width * v**2
    return sheet(
        p_W
        + length * u[..., None] * out
        + half[..., None] * across
        + height[..., None] * [0, 0, 1]
    )
