"""Meshes of furniture: table, chairs, floor lamp.

Each piece is a dictionary of meshes by label, in a frame whose z axis points up
from the floor.
"""

import numpy as np

from apps.studies.true_maps.meshes.mesh import (
    Mesh,
    box,
    curve,
    joined,
    sheet,
    tube,
    upright,
)

Thing = dict[str, Mesh]
"""Meshes by label, such as "chair leg"."""


def room(walls: tuple[float, float], reach: float, height: float) -> Thing:
    """Makes a floor at z = 0 and two walls.

    Args:
        walls: Distances of the walls from the origin, along -x and -y [m].
        reach: Largest x and y of the floor [m].
        height: Height of the walls [m].
    """
    x, y = -np.asarray(walls)
    thick = 0.1
    return {
        "floor": box([x - thick, y - thick, -thick], [reach, reach, 0]),
        "wall": joined(
            [
                box([x - thick, y - thick, 0], [x, reach, height]),
                box([x, y - thick, 0], [reach, y, height]),
            ]
        ),
    }


def table(rng: np.random.Generator, half: np.ndarray, top: float) -> Thing:
    """Makes a table: a round top or a rectangular one, on four legs.

    Args:
        rng: Source of randomness.
        half: Half the length and width of the top, shape (2,) [m].
        top: Height of the top's upper side [m].
    """
    thick = rng.uniform(0.015, 0.04)
    under = top - thick
    if rng.random() < 0.5:
        board = box([*-half, under], [*half, top])
        corner = half - 0.06
    else:
        board = upright([under, top], half.max(), 64)
        corner = np.full(2, 0.6 * half.max())
    sides, radius = rng.choice([4, 20]), rng.uniform(0.015, 0.03)
    legs = [
        _bar([*(corner * sign), 0], [*(corner * sign), under], radius, sides)
        for sign in _CORNERS
    ]
    return {"table": board, "table leg": joined(legs)}


def chair(rng: np.random.Generator) -> Thing:
    """Makes a chair with thin legs and a back of slats; it faces along x."""
    half, seat = rng.uniform(0.17, 0.22), rng.uniform(0.42, 0.48)
    back = seat + rng.uniform(0.35, 0.5)
    radius, lean = rng.uniform(0.008, 0.016), rng.uniform(0.02, 0.08)
    board = box([-half, -half, seat - 0.02], [half, half, seat])
    inner = half - radius
    legs = [
        _bar([*(1.1 * inner * sign), 0], [*(inner * sign), seat - 0.02], radius)
        for sign in _CORNERS
    ]
    posts = [
        _bar([-inner, y, seat], [-inner - lean, y, back], radius)
        for y in (-inner, inner)
    ]
    count, slats = int(rng.integers(2, 6)), []
    width, thick = rng.uniform(0.012, 0.03), rng.uniform(0.004, 0.009)
    if rng.random() < 0.5:
        for part in (np.arange(count) + 0.7) / (count + 0.2):
            x, z = -inner - lean * part, seat + (back - seat) * part
            slats.append(
                box([x - thick, -inner, z - width], [x + thick, inner, z])
            )
    else:
        for y in np.linspace(-inner, inner, count + 2)[1:-1]:
            slats.append(
                _bar([-inner, y, seat], [-inner - lean, y, back], thick)
            )
        slats.append(
            _bar([-inner - lean, -inner, back], [-inner - lean, inner, back],
                 radius)
        )  # fmt: skip
    return {
        "chair seat": board,
        "chair leg": joined([*legs, *posts]),
        "chair slat": joined(slats),
    }


def lamp(rng: np.random.Generator, height: float, shade: float) -> Thing:
    """Makes a lamp: a foot, a stalk of 8 to 20 mm, and a shade without a top.

    Args:
        rng: Source of randomness.
        height: Height of the lamp [m].
        shade: Radius of the shade's lower edge [m].
    """
    radius, lean = rng.uniform(0.004, 0.01), rng.uniform(0, 0.3) * height
    bend = curve(
        [[0, 0, 0.01], [0, 0, 0.7 * height], [0, 0, height], [lean, 0, height]]
    )
    angle = np.linspace(0, 2 * np.pi, 33)
    ring = np.stack([np.cos(angle), np.sin(angle), 0 * angle], axis=1)
    edges = np.stack([shade * ring, rng.uniform(0.4, 0.9) * shade * ring])
    edges[0, :, 2] -= 0.6 * shade
    edges[1, :, 2] += 0.6 * shade
    return {
        "lamp foot": upright([0, 0.02], 0.55 * shade),
        "lamp stalk": tube(bend, radius),
        "lamp shade": sheet(edges + bend[-1]),
    }


_CORNERS = np.array([[1, 1], [1, -1], [-1, 1], [-1, -1]])


def _bar(start, end, radius: float, sides: int = 12) -> Mesh:
    return tube(np.array([start, end]), radius, int(sides))
