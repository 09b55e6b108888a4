"""A case of the study: a scene, its perfect capture, and a disturbed one."""

import dataclasses as dc

import numpy as np

from apps.studies.true_maps.cameras import Cameras, pinhole
from apps.studies.true_maps.disturbance import Disturbance, draw_disturbance
from apps.studies.true_maps.disturbed import disturbed, true_cameras
from apps.studies.true_maps.ray_casting import RayCaster
from apps.studies.true_maps.scene import MeshScene, draw_scene
from apps.studies.true_maps.walk import RATE, Walk, draw_walk
from remosplat_drake.base.errors import RemoSplatError
from remosplat_drake.capture.capture import Capture

CLEARANCE = 0.15
"""Least distance of the camera from every surface [m]."""

_DRAWS = 200
"""Number of random walks after which a scene fails."""


@dc.dataclass(frozen=True)
class Case:
    """A scene and the disturbance of its capture.

    Attributes:
        seed: Seed of the scene, of the camera's path and of the disturbance.
        disturbance: The errors of the capture.
        views: Number of views, ten a second.
        kind: Content of the scene, see `scene.KINDS`.
    """

    seed: int
    disturbance: Disturbance
    views: int = 60
    kind: str = "room"

    @property
    def key(self) -> str:
        """Name of the case, unique."""
        what = str(self.disturbance) or "exact"
        return f"{self.kind} {self.seed}, {self.views} views, {what}"

    def captures(self) -> tuple[MeshScene, Capture, Capture]:
        """Returns the scene, its perfect capture, and the disturbed one."""
        taken = self.taken()
        return taken.scene, taken.perfect(), taken.capture

    def taken(self) -> "Taken":
        """Draws the scene and takes the disturbed capture of it.

        Raises:
            RemoSplatError: The scene leaves no room for a walk.
            MissingExtraError: Open3D is not installed.
        """
        scene = draw_scene(self.seed, self.kind)
        caster = RayCaster(scene)
        time = np.arange(self.views) / RATE
        walk = _free_walk(scene, caster, time, self.seed)
        what = self.disturbance
        cameras = true_cameras(walk, time, what, self.seed)
        capture = disturbed(caster, cameras, what, self.seed)
        return Taken(scene, caster, cameras, capture)


@dc.dataclass(frozen=True, eq=False)
class Taken:
    """A disturbed capture and the true data.

    Attributes:
        scene: The scene.
        caster: Casts rays into it.
        cameras: The cameras that took the images.
        capture: The resulting capture.
    """

    scene: MeshScene
    caster: RayCaster
    cameras: Cameras
    capture: Capture

    def perfect(self) -> Capture:
        """Takes the same images by pinhole cameras with true poses.

        All rows are taken at the time of the middle one.
        """
        ideal = Cameras(self.cameras.walk, self.cameras.time, pinhole())
        rgb, depth = ideal.images(self.caster)
        K = np.tile(ideal.K, (len(ideal), 1, 1))
        return Capture(K=K, X_WC=ideal.X_WC, rgb=rgb, depth=depth)


def draw_case(seed: int, kind: str = "room") -> Case:
    """Draws 40 to 120 views and a disturbance for a scene."""
    rng = np.random.default_rng([seed, 7])
    views = int(np.rint(np.exp(rng.uniform(np.log(40), np.log(120)))))
    return Case(seed, draw_disturbance(rng), views, kind)


def _free_walk(
    scene: MeshScene, caster: RayCaster, time: np.ndarray, seed: int
) -> Walk:
    """A walk on which the camera keeps a distance from all surfaces."""
    rng = np.random.default_rng([seed, 8])
    for _ in range(_DRAWS):
        walk = draw_walk(scene, time[-1] - time[0] + 1 / RATE, rng)
        near = caster.nearest(walk.X_WC(time)[:, :3, 3])
        if near.distance.min() > CLEARANCE:
            return walk
    raise RemoSplatError(f"scene {seed} leaves no room for a walk")
