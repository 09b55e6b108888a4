"""Measures maps of rods of 4 to 16 mm in front of the wrist camera.

Depth and poses are exact. Maps are those of `remosplat reconstruct` and live
maps, without and with unseen space as an obstacle.
"""

import dataclasses as dc
from collections.abc import Callable, Iterator

import numpy as np
from rich.table import Table

from apps.studies.map_bound.judge import NOTHING
from apps.studies.true_maps.cameras import Cameras
from apps.studies.true_maps.meshes.furniture import Thing
from apps.studies.true_maps.meshes.mesh import box, tube
from apps.studies.true_maps.ray_casting import RayCaster
from apps.studies.true_maps.scene import MeshScene, parts_of
from apps.studies.true_maps.walk import Walk
from remosplat_drake.camera.wrist_camera_config import WristCameraConfig
from remosplat_drake.capture.capture import Capture
from remosplat_drake.mapping.map_builder import build_map
from remosplat_drake.mapping.mapping_config import MappingConfig
from remosplat_drake.oracle.sphere_to_ellipsoid import SphereToEllipsoidField
from remosplat_drake.reconstruction.pipeline import reconstruct
from remosplat_drake.robot.sphere_model import Spheres
from remosplat_drake.signals.distance_field import DistanceField
from remosplat_drake.signals.scene_map import SceneMap

DIAMETERS = (0.004, 0.006, 0.008, 0.01, 0.012, 0.016)
"""Diameters of the rods [m]."""

DISTANCES = (0.6, 0.9, 1.2)
"""Distances of the cameras from the middle of the rods [m]."""

LEANS = (0.0, 20.0)
"""Tilts of the rods to the side [deg]."""

BESIDE = 0.04
"""Distance from a rod's surface at which the map is queried [m]."""

FRAMES = 10

_APART, _LENGTH = 0.12, 0.4  # Of the rods [m].
_JUDGED = 0.6
"""Evaluated fraction of a rod's length, around its middle."""

_MIDDLE = np.array([0.0, 0.0, 0.6])
_WALL = 0.6
"""Distance of the wall behind the rods [m]."""

_ARC = np.deg2rad(25)
"""Largest angle of the cameras to either side."""

Fields = Iterator[tuple[str, DistanceField]]


@dc.dataclass(frozen=True)
class Setup:
    """A setup of rods and cameras.

    Attributes:
        distance: Distance of the cameras from the middle of the rods [m].
        lean: Tilt of the rods to the side [deg].
        before_wall: Whether a wall is behind them.
    """

    distance: float
    lean: float
    before_wall: bool

    @property
    def pitch(self) -> float:
        """Distance between neighbouring pixels at the rods [m]."""
        return self.distance / WristCameraConfig().intrinsics().focal_x()

    @property
    def axis_W(self) -> np.ndarray:
        """Direction of the rods, shape (3,)."""
        lean = np.deg2rad(self.lean)
        return np.array([0, np.sin(lean), np.cos(lean)])

    def middle_W(self, number: int) -> np.ndarray:
        """Returns the middle of a rod, shape (3,) [m]."""
        across = _APART * (number - (len(DIAMETERS) - 1) / 2)
        return _MIDDLE + np.array([0, across, 0])

    def scene(self) -> MeshScene:
        """Makes the rods on a board, and the wall."""
        half_W = _LENGTH / 2 * self.axis_W
        things: list[Thing] = []
        for number, diameter in enumerate(DIAMETERS):
            middle_W = self.middle_W(number)
            ends = np.array([middle_W - half_W, middle_W + half_W])
            things.append({"rod": tube(ends, diameter / 2)})
        under = _MIDDLE[2] - _LENGTH / 2
        board = box([-0.1, -0.4, under - 0.02], [0.1, 0.4, under])
        things.append({"table": board})
        if self.before_wall:
            things.append({"wall": box([-_WALL - 0.1, -2, 0], [-_WALL, 2, 2])})
        return MeshScene(parts_of(things), _MIDDLE)

    def capture(self) -> Capture:
        """Takes exact images from an arc in front of the rods."""
        still = np.zeros(3)
        there_and_back = [_ARC, 0.25, -np.pi / 2]
        walk = Walk(
            _MIDDLE,
            np.array([0.0, self.distance, np.deg2rad(12)]),
            np.array([[there_and_back], [still], [still]]),
            np.zeros((4, 1, 3)),
        )
        lens = WristCameraConfig().intrinsics()
        time = np.linspace(0, 2, FRAMES)
        cameras = Cameras(walk, time, lens.intrinsic_matrix())
        rgb, depth = cameras.images(RayCaster(self.scene()))
        K = np.tile(cameras.K, (FRAMES, 1, 1))
        return Capture(K=K, X_WC=cameras.X_WC, rgb=rgb, depth=depth)

    def beside(self, number: int) -> np.ndarray:
        """Returns points to the left and right of a rod, shape (n, 3) [m]."""
        aside = DIAMETERS[number] / 2 + BESIDE
        across_W = np.cross(self.axis_W, [1, 0, 0])
        along = _JUDGED * _LENGTH * np.linspace(-0.5, 0.5, 61)[:, None]
        on_axis = self.middle_W(number) + along * self.axis_W
        return np.concatenate(
            [on_axis + aside * across_W, on_axis - aside * across_W]
        )


SETUPS = [
    Setup(distance, lean, before_wall)
    for distance in DISTANCES
    for before_wall in (True, False)
    for lean in LEANS
]


@dc.dataclass(frozen=True)
class RodResult:
    """Over-estimate of a map's distances to a rod.

    Attributes:
        setup: The setup.
        map: Name of the method that made the map.
        diameter: Diameter of the rod [m].
        pixels: Width of the rod in images [pixels].
        over: Largest over-estimate beside it, after subtraction of the discs'
            uncertainty [m].
    """

    setup: Setup
    map: str
    diameter: float
    pixels: float
    over: float


def offline(capture: Capture) -> DistanceField:
    """Makes the field of the map of `remosplat reconstruct`."""
    made = reconstruct(capture, "cpu", bounded=True)
    return SphereToEllipsoidField(made.splat)


def live(
    capture: Capture, unseen_is_solid: bool, robot_free: Spheres | None = None
) -> SceneMap:
    """Makes the map that grows while a robot moves.

    Args:
        capture: The frames.
        unseen_is_solid: Whether unseen space is part of the map.
        robot_free: The robot's spheres; None for none.
    """
    return build_map(
        capture,
        MappingConfig(),
        version=1,
        parent=None,
        frames=tuple(f"frame_{i}" for i in range(len(capture))),
        time=0.0,
        make_field=SphereToEllipsoidField,
        unseen_is_solid=unseen_is_solid,
        robot_free=robot_free,
    )


MAPS: dict[str, Callable[[Capture], DistanceField]] = {
    "offline": offline,
    "live": lambda capture: live(capture, False).field,
    "live, unseen solid": lambda capture: live(capture, True).field,
}
"""The maps that are made, by name."""


def measure(setup: Setup) -> Iterator[RodResult]:
    """Makes all maps of a setup and queries distances to its rods."""
    capture = setup.capture()
    for name, make in MAPS.items():
        field = make(capture)
        for number, diameter in enumerate(DIAMETERS):
            p_W = setup.beside(number)
            measured = field.clearances(Spheres.at(p_W)).per_sphere(len(p_W))
            pixels = diameter / setup.pitch
            over = float(min(measured.max(), NOTHING) - BESIDE)
            yield RodResult(setup, name, diameter, pixels, over)


def table(results: list[RodResult]) -> Table:
    """Lists over-estimates in millimetres, a row for each map of a setup."""
    shown = Table("cameras at", "before", "lean", "map")
    for diameter in DIAMETERS:
        shown.add_column(f"{1e3 * diameter:.0f} mm", justify="right")
    each = len(DIAMETERS)
    for start in range(0, len(results), each):
        row = results[start : start + each]
        if start % (each * len(MAPS)) == 0:
            setup = row[0].setup
            behind = "a wall" if setup.before_wall else "nothing"
            shown.add_section()
            shown.add_row(
                f"{setup.distance} m",
                behind,
                f"{setup.lean:.0f} deg",
                "(pixels)",
                *(f"({r.pixels:.1f})" for r in row),
            )
        shown.add_row(
            "", "", "", row[0].map, *(f"{1e3 * r.over:.1f}" for r in row)
        )
    return shown
