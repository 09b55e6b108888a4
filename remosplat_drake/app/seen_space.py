"""`SeenSpace`: the space that the cameras of a splat's capture have seen."""

import dataclasses as dc
from collections.abc import Iterable
from functools import cached_property
from pathlib import Path

import numpy as np
from pydrake.math import RigidTransform

from remosplat_drake.app.scenario import Scenario
from remosplat_drake.base import resources
from remosplat_drake.base.errors import FieldError, FileError
from remosplat_drake.base.pose_config import make_transform
from remosplat_drake.oracle.oracle_config import GroundTruth
from remosplat_drake.oracle.placed_unknown_space import PlacedUnknownSpace
from remosplat_drake.reconstruction.seen_file import read_seen_space, seen_path
from remosplat_drake.robot.sphere_model import Spheres
from remosplat_drake.signals.coverage import (
    SURFACE,
    UNSEEN,
    Coverage,
    with_free,
)

_AROUND = 0.3
"""The robot's path is assumed to be within this distance of the box around its
start and targets [m]."""

_STEP = 0.04
"""Spacing of the points at which space is sampled [m]."""


@dc.dataclass(frozen=True, eq=False)
class SeenSpace:
    """The space that cameras saw, and the space of the robot at its start.

    Attributes:
        coverage: The voxels, in the splat's frame G.
        X_WG: Pose of G in W.
        floor_height: Links on the floor ignore the scene below this height in W
            [m].
    """

    coverage: Coverage
    X_WG: RigidTransform
    floor_height: float

    @cached_property
    def field(self) -> PlacedUnknownSpace:
        """The map in which all unseen space is an obstacle."""
        return PlacedUnknownSpace(self.coverage, self.X_WG, self.floor_height)

    def unseen_fraction(self, places_W: Iterable[np.ndarray]) -> float:
        """Returns the unseen fraction of the space around given places.

        The space is a box around all places, above the floor. The inside of
        objects in the box counts as unseen.

        Args:
            places_W: Points in W, shape (3,) each [m].
        """
        places = np.array(list(places_W))
        lower, upper = places.min(axis=0) - _AROUND, places.max(0) + _AROUND
        lower[2] = max(lower[2], self.floor_height)
        upper = np.maximum(upper, lower + _STEP)
        axes = [
            np.arange(a, b, _STEP) for a, b in zip(lower, upper, strict=True)
        ]
        p_W = np.stack(np.meshgrid(*axes), axis=-1).reshape(-1, 3)
        return float(np.mean(self.hides(p_W)))

    def hides(self, p_W: np.ndarray) -> np.ndarray:
        """Returns which points, (n, 3) in W [m], no camera has seen."""
        p_G = self.X_WG.inverse().multiply(p_W.T).T
        return self.coverage.states_at(p_G) == UNSEEN


def load_seen_space(scenario: Scenario, start: Spheres) -> SeenSpace | None:
    """Reads the seen space of a scenario's splat.

    The robot's own space at its start counts as free. Surfaces that the
    scenario crops are removed.

    Args:
        scenario: The scenario.
        start: The robot's spheres at its start, in W.

    Returns:
        The seen space. None if there is no such file, or if the oracle uses the
        true geometry and needs no seen space.

    Raises:
        RemoSplatError: The file is unusable, or belongs to another splat.
    """
    path = seen_file(scenario)
    if path is None or isinstance(scenario.oracle, GroundTruth):
        return None
    scene, where = scenario.scene, scenario.source
    splat = resources.resolve(scene.splat, scenario.folder)
    coverage = read_seen_space(path, splat)
    X_WG = make_transform(scene.X_WG, where, "scene.X_WG")
    if scene.crop is not None:
        crop = np.array(scene.crop.lower), np.array(scene.crop.upper)
        coverage = _cropped(coverage, X_WG, *crop)
    p_GS = X_WG.inverse().multiply(start.p_WS.T).T
    coverage = with_free(
        coverage, dc.replace(start, p_WS=p_GS), scenario.mapping.start_margin
    )
    return SeenSpace(coverage, X_WG, scene.floor_height)


def seen_file(scenario: Scenario) -> Path | None:
    """Returns the file of a scenario's seen space; None if there is no file.

    Args:
        scenario: The scenario. If its `scene.seen` is empty, the function looks
            for the file beside the splat.

    Raises:
        FieldError: The scenario names a file that does not exist, or names a
            file but no splat.
    """
    scene = scenario.scene
    if scene.seen and not scene.splat:
        problem = "contains the seen space of a splat, but scene.splat is empty"
        raise FieldError(scenario.source, "scene.seen", problem)
    try:
        if scene.seen:
            return resources.resolve(scene.seen, scenario.folder)
        if not scene.splat:
            return None
        beside = seen_path(resources.resolve(scene.splat, scenario.folder))
    except FileError as error:
        field = "scene.seen" if scene.seen else "scene.splat"
        raise FieldError(scenario.source, field, str(error)) from error
    return beside if beside.is_file() else None


def _cropped(
    coverage: Coverage,
    X_WG: RigidTransform,
    lower: np.ndarray,
    upper: np.ndarray,
) -> Coverage:
    """Removes surfaces outside a box in W, where the splat is cropped."""
    voxels = np.argwhere(coverage.state == SURFACE)
    p_G = coverage.lower + coverage.voxel * (voxels + 0.5)
    p_W = X_WG.multiply(p_G.T).T
    outside = ((p_W < lower) | (p_W > upper)).any(axis=1)
    state = coverage.state.copy()
    state[tuple(voxels[outside].T)] = UNSEEN
    return dc.replace(coverage, state=state)
