"""Regions around a point, in worlds of discs whose objects are known."""

import numpy as np
import pytest

from remosplat_drake.base.errors import RemoSplatError
from remosplat_drake.scene.objects.region_growing import find_region

SIGMA = 0.005
"""Standard deviations of all discs [m]."""

STEP = 0.008
"""Distance of neighbouring discs [m]."""


def rows(ends: tuple[float, float]) -> np.ndarray:
    return np.arange(ends[0], ends[1], STEP)


class Discs:
    """Discs on surfaces, as those of a splat, each with its thing's name."""

    def __init__(self):
        self.points, self.normals, self.names = [], [], []

    def add(self, name, points, normals):
        self.points += list(points)
        self.normals += list(np.broadcast_to(normals, np.shape(points)))
        self.names += [name] * len(points)
        return self

    def plate(self, name, x, y, z, around=()):
        """A level plate, with a hole below each disc (x, y, radius)."""
        grid = np.meshgrid(rows(x), rows(y))
        xy = np.stack([axis.ravel() for axis in grid], axis=1)
        for *middle, radius in around:
            xy = xy[np.linalg.norm(xy - middle, axis=1) > radius]
        points = np.column_stack([xy, np.full(len(xy), z)])
        return self.add(name, points, [0.0, 0.0, 1.0])

    def can(self, name, x, y, radius, bottom, top):
        """The side and the top of an upright cylinder."""
        turns = np.arange(0.0, 2.0 * np.pi, STEP / radius)
        out = np.stack([np.cos(turns), np.sin(turns), 0 * turns], axis=1)
        for z in np.arange(bottom + STEP / 2, top, STEP):
            self.add(name, np.add([x, y, z], radius * out), out)
        for r in np.arange(STEP / 2, radius, STEP):
            turns = np.arange(0.0, 2.0 * np.pi, STEP / r)
            ring = np.stack([np.cos(turns), np.sin(turns), 0 * turns], axis=1)
            self.add(name, np.add([x, y, top], r * ring), [0.0, 0.0, 1.0])
        return self

    def wall(self, name, x, y, z):
        """A wall whose normal is along x."""
        grid = np.meshgrid(rows(y), rows(z))
        yz = np.stack([axis.ravel() for axis in grid], axis=1)
        points = np.column_stack([np.full(len(yz), x), yz])
        return self.add(name, points, [1.0, 0.0, 0.0])

    def region(self, near, largest=0.4):
        """Finds a region: how many discs of each thing it has, its bottom."""
        normals = np.array(self.normals)
        across = np.cross(normals, [0.3, 0.5, 0.8])
        across /= np.linalg.norm(across, axis=1)[:, None]
        axes = SIGMA * np.stack(
            [across, np.cross(normals, across), 0.0 * normals], axis=2
        )
        found = find_region(
            np.array(self.points), normals, axes, np.array(near), largest
        )
        names, count = np.unique(
            np.array(self.names)[found.index], return_counts=True
        )
        return dict(zip(names.tolist(), count.tolist(), strict=True)), found


def table(*cans, noise=0.0):
    """A table at 0.5 m with cans (x, y, radius, height) named a, b, ..."""
    discs = Discs().plate(
        "table",
        (0.0, 0.6),
        (-0.3, 0.3),
        0.5,
        [(x, y, radius) for x, y, radius, _ in cans],
    )
    for name, (x, y, radius, height) in zip("abc", cans, strict=False):
        discs.can(name, x, y, radius, 0.5, 0.5 + height)
    rng = np.random.default_rng(3)
    discs.points = [p + noise * rng.standard_normal(3) for p in discs.points]
    return discs


CAN = (0.2, 0.0, 0.03, 0.12)


@pytest.mark.parametrize("noise", [0.0, 0.001])
@pytest.mark.parametrize(
    "near", [(0.17, 0.0, 0.55), (0.2, 0.0, 0.62), (0.2, 0.035, 0.52)]
)
def test_all_of_a_can_and_nothing_else_is_found(near, noise):
    discs = table(CAN, noise=noise)
    found, region = discs.region(near)
    assert list(found) == ["a"]
    above = [
        name == "a" and p[2] > 0.5 + 0.008 + 5 * noise
        for name, p in zip(discs.names, discs.points, strict=True)
    ]
    assert found["a"] >= np.count_nonzero(above)
    assert region.bottom == pytest.approx(0.5, abs=0.001)
    assert (np.diff(region.index) > 0).all()


def test_a_neighbour_18_mm_away_is_another_thing():
    discs = table(CAN, (0.2, 0.078, 0.03, 0.2))
    assert list(discs.region((0.17, 0.0, 0.55))[0]) == ["a"]
    assert list(discs.region((0.2, 0.108, 0.65))[0]) == ["b"]


def test_things_that_touch_are_one():
    discs = table(CAN, (0.2, 0.06, 0.03, 0.2))
    assert list(discs.region((0.17, 0.0, 0.55))[0]) == ["a", "b"]


def test_the_top_of_a_neighbour_is_no_support():
    """A low box ends 12 mm beside the can: its top bears nothing of it."""
    discs = table(CAN).plate("box", (0.242, 0.34), (-0.05, 0.05), 0.55)
    found, region = discs.region((0.2, 0.0, 0.62))
    assert list(found) == ["a"]
    assert region.bottom == pytest.approx(0.5, abs=0.001)


def test_a_thing_on_another_stands_on_that():
    discs = table().plate("crate", (0.1, 0.3), (-0.1, 0.1), 0.6, [CAN[:3]])
    discs.can("a", *CAN[:3], 0.6, 0.72)
    found, region = discs.region((0.17, 0.0, 0.65))
    assert list(found) == ["a"]
    assert region.bottom == pytest.approx(0.6, abs=0.001)


def test_a_shoulder_bears_no_cap():
    """The level ring around a cap is too small to be a support."""
    discs = table(CAN).can("cap", 0.2, 0.0, 0.018, 0.62, 0.65)
    found, region = discs.region((0.2, 0.0, 0.65))
    assert list(found) == ["a", "cap"]
    assert region.bottom == pytest.approx(0.5, abs=0.001)


@pytest.mark.parametrize(
    ("near", "largest", "message"),
    [
        ((0.2, 0.0, 0.9), 0.4, "the map has no Gaussian within 0.05 m of"),
        ((0.17, 0.0, 0.55), 0.1, "is larger than 0.1 m"),
        ((0.17, 0.0, 0.55), 0.02, "no level surface within 0.02 m below"),
        ((0.4, 0.0, 0.5), 0.4, "no level surface within 0.4 m below"),
        ((0.6, 0.0, 0.7), 0.4, "is larger than 0.4 m"),
        ((0.45, 0.2, 0.72), 0.4, "ends 164 mm above the level surface below"),
        ((0.01, 0.2, 0.55), 0.4, "the middle of the object is not above"),
        ((0.45, -0.2, 0.55), 0.4, "fewer than 10 Gaussians"),
    ],
)
def test_what_is_no_object_is_refused(near, largest, message):
    discs = table(CAN).wall("wall", 0.6, (-0.5, 0.5), (0.51, 1.2))
    discs.can("lamp", 0.45, 0.2, 0.04, 0.66, 0.72)
    discs.can("shelf", -0.055, 0.2, 0.06, 0.508, 0.55)
    discs.add("speck", [[0.45, -0.2, 0.55]], [1.0, 0.0, 0.0])
    with pytest.raises(RemoSplatError, match=message) as error:
        discs.region(near, largest)
    assert "\n" not in str(error.value)
