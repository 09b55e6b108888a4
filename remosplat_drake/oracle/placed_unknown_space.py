"""`PlacedUnknownSpace`: unseen voxels in a splat's frame G, queried in W."""

import dataclasses as dc
import hashlib

import numpy as np
from pydrake.math import RigidTransform

from remosplat_drake.base.kernels.packed import Packed
from remosplat_drake.oracle.unknown_space import (
    UnknownSpaceField,
    unknown_space_field,
)
from remosplat_drake.robot.sphere_model import Spheres
from remosplat_drake.signals.compiled_map import Maps
from remosplat_drake.signals.coverage import FREE, UNSEEN, Coverage
from remosplat_drake.signals.distance_field import Clearances, DistanceField
from remosplat_drake.signals.thing import UNSEEN_SPACE, Thing

_UPRIGHT = 1e-9
"""If a horizontal component of G's z axis in W exceeds this value, G is tilted;
smaller components are rounding errors."""

_BENEATH = 0.4
"""Thickness of the layer of free space beneath the floor that is added around a
tilted grid [m]."""


class PlacedUnknownSpace(DistanceField):
    """The exact signed distance, in W, to the unseen space of a capture.

    Queries are transformed into the grid's frame G, and not the grid into W. So
    the result is exact for any pose X_WG. For each sphere, voxels with centres
    below its `ignore_below` in W count as seen. If G is tilted, the layers of
    the grid are not horizontal in W. Then spheres whose `ignore_below` is at or
    above `floor_height` query a second grid, in which the voxels below
    `floor_height` are seen.

    Args:
        coverage: The space that cameras have seen, in G.
        X_WG: Pose of G in W.
        floor_height: Height in W below which links close to the floor ignore
            the scene [m].

    Raises:
        RemoSplatError: No voxel has been seen.
    """

    def __init__(
        self, coverage: Coverage, X_WG: RigidTransform, floor_height: float
    ):
        self._R_WG = X_WG.rotation().matrix()
        self._p_WG = X_WG.translation()
        self._floor_height = floor_height
        self._field = unknown_space_field(coverage)
        self._over_floor = self._field
        self._is_upright = bool(
            np.abs(self._R_WG[2] - [0, 0, 1]).max() < _UPRIGHT
        )
        self.revision = self._field.revision
        if not self._is_upright:
            over_floor = _without_floor(coverage, X_WG, floor_height)
            self._over_floor = unknown_space_field(over_floor)
        self._is_in_W = X_WG.IsExactlyIdentity()
        if not self._is_in_W:
            pose = hashlib.sha256(X_WG.GetAsMatrix34().tobytes())
            pose.update(repr(floor_height).encode())
            self.revision += f"@{pose.hexdigest()[:8]}"

    @property
    def for_planning(self) -> DistanceField:
        """The field of the grid if G is W; see `DistanceField.for_planning`."""
        return self._field if self._is_in_W else self

    @property
    def compiled(self) -> Packed | None:
        """The grid's compiled map if G is W; see `DistanceField.compiled`."""
        return self._field.compiled if self._is_in_W else None

    @property
    def compiled_rows(self) -> Packed[Maps] | None:
        """The grid's rows if G is W; see `DistanceField.compiled_rows`."""
        return self._field.compiled_rows if self._is_in_W else None

    def clearances(
        self, spheres: Spheres, max_distance: float = np.inf
    ) -> Clearances:
        """Measures the clearances of all spheres; see `DistanceField`.

        Raises:
            ValueError: A centre is not finite, or a radius or `ignore_below` is
                NaN.
        """
        if self._is_upright:
            floor = spheres.ignore_below - self._p_WG[2]
            return self._ask(self._field, spheres, floor, max_distance)
        if np.isnan(spheres.ignore_below).any():
            raise ValueError("`ignore_below` of a sphere is NaN")
        rolls = spheres.ignore_below >= self._floor_height
        answers = []
        for field, chosen in (self._field, ~rolls), (self._over_floor, rolls):
            index = np.flatnonzero(chosen)
            everything = np.full(len(index), -np.inf)
            asked = spheres.select(index)
            answer = self._ask(field, asked, everything, max_distance)
            answers.append(dc.replace(answer, sphere=index[answer.sphere]))
        return _merged(answers)

    @property
    def surfaces(self) -> None:
        """None: unseen space has no surface; see `DistanceField.surfaces`."""
        return None

    def thing_at(self, p_W: np.ndarray) -> Thing:
        """Returns "unseen space"; see `DistanceField.thing_at`."""
        return UNSEEN_SPACE

    def _ask(
        self,
        field: UnknownSpaceField,
        spheres: Spheres,
        floor_G: np.ndarray,
        max_distance: float,
    ) -> Clearances:
        """Queries a grid in its frame, and transforms the result to W."""
        p_GS = (spheres.p_WS - self._p_WG) @ self._R_WG
        asked = dc.replace(spheres, p_WS=p_GS, ignore_below=floor_G)
        answer = field.clearances(asked, max_distance)
        return Clearances(
            answer.sphere,
            answer.distance,
            answer.direction_W @ self._R_WG.T,
            answer.p_WC @ self._R_WG.T + self._p_WG,
            self.revision,
        )


def _without_floor(
    coverage: Coverage, X_WG: RigidTransform, floor_height: float
) -> Coverage:
    """Returns an enlarged grid in which the space below the floor is seen."""
    layers = int(np.ceil(_BENEATH / coverage.voxel))
    state = np.pad(coverage.state, layers, constant_values=UNSEEN)
    lower = coverage.lower - layers * coverage.voxel
    up_G = X_WG.rotation().matrix()[2]
    axes = [
        up_G[i] * (lower[i] + coverage.voxel * (np.arange(n) + 0.5))
        for i, n in enumerate(state.shape)
    ]
    x, y, z = np.ix_(*axes)
    height = x + y + z + X_WG.translation()[2]
    state[height < floor_height] = FREE
    return Coverage(lower, coverage.voxel, state)


def _merged(answers: list[Clearances]) -> Clearances:
    """Merges the clearances of different spheres."""
    names = "sphere", "distance", "direction_W", "p_WC"
    parts = {
        name: np.concatenate([getattr(answer, name) for answer in answers])
        for name in names
    }
    order = np.argsort(parts["sphere"], kind="stable")
    merged = {name: part[order] for name, part in parts.items()}
    return Clearances(**merged, revision=answers[0].revision)
