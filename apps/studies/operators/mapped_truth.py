"""`MappedTruth`: the part of the truth that a live map can contain."""

import dataclasses as dc
from collections.abc import Hashable, Sequence
from functools import lru_cache

import numpy as np

from remosplat_drake.mapping.store.session import Session
from remosplat_drake.oracle.point_distance import PointDistanceField
from remosplat_drake.oracle.signed_distance import SignedDistanceField
from remosplat_drake.robot.sphere_model import Spheres
from remosplat_drake.scene.primitive_scene import (
    Box,
    Cylinder,
    PrimitiveScene,
)

_ON = 0.005
"""A measured point lies on a solid if it is at most this far from the solid
[m]."""

_SPACING = 0.004
"""Of a frame's points, one is kept in each grid cell with edges of this length
[m]."""

_SEEN = 50
"""A frame shows a solid if at least this many of its points lie on the
solid."""


@dc.dataclass(frozen=True, eq=False)
class _Look:
    """Points of the scene that a frame measured.

    Attributes:
        p_W: Measured points in W, shape (n, 3) [m].
        time: Time of the frame [s].
    """

    p_W: np.ndarray
    time: float


class MappedTruth:
    """The part of a true, changing scene that the frames of a map measured.

    Attributes:
        scenes: The scene at first, and those that took turns with it.
    """

    def __init__(
        self,
        session: Session,
        scenes: Sequence[PrimitiveScene],
        changes: Sequence[float],
        max_depth: float,
    ):
        """Prepares the truth of one session.

        Args:
            session: Session with its frames and maps.
            scenes: The scene at first, and those that took turns with it.
            changes: Times at which the scene changed to the next one, in order
                [s].
            max_depth: Largest depth that maps use; farther pixels are ignored
                [m].
        """
        self.scenes = tuple(scenes)
        self._session = session
        self._changes = np.asarray(changes, float)
        self._max_depth = max_depth
        self._look = lru_cache(maxsize=None)(self._read)
        self.surfaces = lru_cache(maxsize=4)(self._surfaces)
        self.known = lru_cache(maxsize=4)(self._known)

    def changes_before(self, time: float) -> int:
        """Returns the number of changes of the scene until a time [s]."""
        return int(np.searchsorted(self._changes, time, "right"))

    def scene(self, changes: int) -> PrimitiveScene:
        """Returns the scene after a number of changes."""
        return self.scenes[changes % len(self.scenes)]

    def _surfaces(self, version: int, changes: int) -> PointDistanceField:
        """Makes distances to the measured surfaces that still exist.

        Points on objects that appeared or vanished since then are ignored.

        Args:
            version: Version of the map.
            changes: Number of changes of the scene so far.
        """
        scene = self.scene(changes)
        lasting, _ = self._split(changes)
        points = [np.zeros((0, 3))]
        for look in self._looks(version):
            solids = scene if self._is_recent(look, changes) else lasting
            points.append(look.p_W[_on(solids, look.p_W)])
        return PointDistanceField(np.concatenate(points))

    def _known(self, version: int, changes: int) -> PrimitiveScene:
        """Returns the scene without new objects that no frame shows."""
        lasting, recent = self._split(changes)
        for look in self._looks(version):
            if not self._is_recent(look, changes):
                continue
            if _on(recent, look.p_W).sum() >= _SEEN:
                return self.scene(changes)
        return lasting

    def _split(self, changes: int) -> tuple[PrimitiveScene, PrimitiveScene]:
        """Splits the scene into remaining and new solids of the last change."""
        scene = self.scene(changes)
        if not changes:
            return scene, PrimitiveScene()
        before = {_identity(p) for p in self.scene(changes - 1).primitives}
        stayed = [p for p in scene.primitives if _identity(p) in before]
        came = [p for p in scene.primitives if _identity(p) not in before]
        return _scene_of(stayed), _scene_of(came)

    def _is_recent(self, look: _Look, changes: int) -> bool:
        return not changes or look.time >= self._changes[changes - 1]

    def _looks(self, version: int) -> list[_Look]:
        if not version:
            return []
        return [self._look(n) for n in self._session.versions[version].frames]

    def _read(self, name: str) -> _Look:
        frames = self._session.frames
        frames.load((name,))
        capture = frames.capture((name,))
        near = capture.depth[0] <= self._max_depth
        p_W = capture.points_W(0)[near & (capture.depth[0] > 0)]
        time = frames.time(name)
        scene = self.scene(self.changes_before(time))
        # A point on no solid is at an edge, between foreground and background.
        p_W = p_W[_on(scene, p_W)]
        cells = np.floor(p_W / _SPACING).astype(np.int64)
        _, first = np.unique(cells, axis=0, return_index=True)
        return _Look(p_W[first], time)


def _on(scene: PrimitiveScene, p_W: np.ndarray) -> np.ndarray:
    """Returns which points are on a solid of a scene, shape (n,) bool."""
    on = np.zeros(len(p_W), bool)
    near = SignedDistanceField(scene).clearances(Spheres.at(p_W), _ON)
    on[near.sphere] = np.abs(near.distance) < _ON
    return on


def _identity(solid: Box | Cylinder) -> Hashable:
    return _scene_of([solid]).content_hash


def _scene_of(solids: Sequence[Box | Cylinder]) -> PrimitiveScene:
    return PrimitiveScene(
        tuple(s for s in solids if isinstance(s, Box)),
        tuple(s for s in solids if isinstance(s, Cylinder)),
    )
