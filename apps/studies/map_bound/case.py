"""A case of the study: a scene, its perfect capture, and a disturbed one."""

import dataclasses as dc

import numpy as np
from pydrake.math import RigidTransform

from apps.studies.map_bound.disturbance import (
    Disturbance,
    disturbed,
    draw_disturbance,
)
from apps.studies.map_bound.ray_casting import cast_capture
from remosplat_drake.capture.capture import Capture
from remosplat_drake.capture.rendering.renderer import FIELD_OF_VIEW
from remosplat_drake.capture.rendering.synthetic import survey_poses
from remosplat_drake.generation.scene_generators import generate
from remosplat_drake.scene.primitive_scene import PrimitiveScene

WIDTH, HEIGHT = 320, 240
"""Size of the images [pixels]."""


@dc.dataclass(frozen=True)
class Case:
    """A scene and the disturbance of its capture.

    Attributes:
        family: Name of the scene's family.
        seed: Seed of the scene, of the camera poses and of the disturbance.
        views: Number of views.
        disturbance: Disturbance of the views.
    """

    family: str
    seed: int
    views: int
    disturbance: Disturbance

    @property
    def key(self) -> str:
        """Name of the case, unique."""
        disturbance = str(self.disturbance) or "exact"
        return f"{self.family} {self.seed}, {self.views} views, {disturbance}"

    def captures(self) -> tuple[PrimitiveScene, Capture, Capture]:
        """Returns the scene, its perfect capture, and the disturbed one."""
        scene = generate(self.family, self.seed)
        poses = in_order(survey_poses(scene, self.views, self.seed))
        perfect = cast_capture(scene, poses, WIDTH, HEIGHT, FIELD_OF_VIEW)
        return scene, perfect, disturbed(perfect, self.disturbance, self.seed)


def draw_case(family: str, seed: int) -> Case:
    """Draws 20 to 120 views and a disturbance for a scene."""
    rng = np.random.default_rng([seed, *family.encode()])
    views = int(np.rint(np.exp(rng.uniform(np.log(20), np.log(120)))))
    return Case(family, seed, views, draw_disturbance(rng))


def in_order(poses: list[RigidTransform]) -> list[RigidTransform]:
    """Orders camera poses like a walk: the nearest one left is the next."""
    rest = np.array([X_WC.translation() for X_WC in poses])
    order = [0]
    left = set(range(1, len(poses)))
    while left:
        here = rest[order[-1]]
        order.append(min(left, key=lambda i: np.linalg.norm(rest[i] - here)))
        left.remove(order[-1])
    return [poses[i] for i in order]
