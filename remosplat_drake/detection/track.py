"""`Track`: one moving object over many images."""

import dataclasses as dc
import math

import numpy as np

from remosplat_drake.detection.detection_config import DetectionConfig
from remosplat_drake.detection.edge_filter import Edges
from remosplat_drake.detection.enclosure import RoundedBox, enclose
from remosplat_drake.scene.mover import Mover

TRUSTED = 2
"""A small object is reported when this many images have shown it."""

_PLAIN = 40
"""An object with at least this many points is reported after its first image.
"""

_HIDDEN_PARTS = 2
"""At most this many boxes enclose the hidden part of an object."""


@dc.dataclass(frozen=True, eq=False)
class Stretches:
    """Segments from an object's seen points to its possible extent behind them.

    Attributes:
        face_W: Points that were seen, in W, shape (n, 3) [m].
        back_W: Farthest possible points of the object behind them, shape (n, 3)
            [m].
        seen: Time at which each point was last seen, shape (n,) [s].
    """

    face_W: np.ndarray
    back_W: np.ndarray
    seen: np.ndarray

    def __len__(self) -> int:
        return len(self.seen)

    def select(self, index: np.ndarray) -> "Stretches":
        """Returns the segments that a boolean mask or index array selects."""
        return Stretches(
            self.face_W[index], self.back_W[index], self.seen[index]
        )

    def moved(self, way_W: np.ndarray) -> "Stretches":
        """Returns the segments after a translation, shape (3,) [m]."""
        return Stretches(self.face_W + way_W, self.back_W + way_W, self.seen)

    @staticmethod
    def joined(*parts: "Stretches") -> "Stretches":
        """Concatenates segments."""
        return Stretches(
            np.concatenate([part.face_W for part in parts]),
            np.concatenate([part.back_W for part in parts]),
            np.concatenate([part.seen for part in parts]),
        )

    @staticmethod
    def none() -> "Stretches":
        """Makes an empty set of segments."""
        return Stretches(np.zeros((0, 3)), np.zeros((0, 3)), np.zeros(0))


@dc.dataclass(frozen=True, eq=False)
class Track:
    """One moving object over many images, with its position and motion.

    Attributes:
        name: Name of the object, such as "seen 3", which does not change while
            it is tracked.
        parts: Boxes around the visible part, at the time of `edges`.
        shown: The visible part, at the same time.
        hidden: The part that was seen before and may be hidden from all cameras
            now, at its predicted position.
        edges: The object's outlines and their velocities.
        images: Number of images that showed the object. If it has separated
            from another object, the images of that object count, too.
        padding: Margin of the object's extent beyond its points [m].
        error: Bound on position errors of the points [m].
        still_since: Time since which the object has been at rest [s].
        home: The object's outline at that time, shape (2, 3) [m].
    """

    name: str
    parts: tuple[RoundedBox, ...]
    shown: Stretches
    hidden: Stretches
    edges: Edges
    images: int
    padding: float
    error: float
    still_since: float
    home: np.ndarray

    def __deepcopy__(self, memo) -> "Track":
        return self

    @property
    def is_trusted(self) -> bool:
        """Whether the object is large, or was seen in several images."""
        return self.images >= TRUSTED or len(self.shown) >= _PLAIN

    @property
    def face_W(self) -> np.ndarray:
        """All present and former visible points, shape (n, 3) [m]."""
        return np.concatenate([self.shown.face_W, self.hidden.face_W])

    @property
    def seen(self) -> float:
        """Time at which any part was last seen [s]."""
        return max(
            self.shown.seen.max(initial=-np.inf),
            self.hidden.seen.max(initial=-np.inf),
        )

    def after(self, time: float, config: DetectionConfig) -> "Track":
        """Predicts the track at a later time, without an observation.

        Args:
            time: The later time [s].
            config: Settings, with bounds on the motion of objects.
        """
        v, _ = self.edges.velocity(config.max_speed)
        way = (time - self.edges.time) * v
        hidden = Stretches.joined(self.shown, self.hidden).moved(way)
        edges = self.edges.after(time, config.max_acceleration)
        return dc.replace(
            self, parts=(), shown=Stretches.none(), hidden=hidden, edges=edges
        )

    def growth(self, since: float, config: DetectionConfig) -> float:
        """Bounds the distance of the object from its prediction.

        Args:
            since: Time at which the object was last seen [s].
            config: Settings, with bounds on the motion of objects.
        """
        t = self.edges.time - since
        v, error = self.edges.velocity(config.max_speed)
        soon = error * t + 0.5 * config.max_acceleration * t**2
        fast = config.max_speed + float(np.linalg.norm(v))
        return min(soon, fast * t)

    def movers(
        self, config: DetectionConfig, *, coarse: bool = False
    ) -> tuple[Mover, ...]:
        """Returns the object as movers, with bounds on its motion.

        Args:
            config: Settings, with bounds on the motion of objects.
            coarse: Whether the visible part gets one box instead of several.
        """
        parts = [(part, self.error) for part in self._seen_parts(coarse)]
        if len(self.hidden):
            oldest = float(self.hidden.seen.min())
            error = self.error + self.growth(oldest, config)
            most = 1 if coarse else _HIDDEN_PARTS
            hidden = self.hidden
            for part in enclose(
                hidden.face_W, hidden.back_W, self.padding, most
            ):
                parts.append((part, error))
        v_WM, velocity_error = self.edges.velocity(config.max_speed)
        names = [self.name]
        if len(parts) > 1:
            names = [f"{self.name}.{i + 1}" for i in range(len(parts))]
        return tuple(
            Mover(
                name,
                part.X_WM,
                part.half_extents,
                part.radius,
                v_WM=v_WM,
                max_speed=config.max_speed,
                max_acceleration=config.max_acceleration,
                velocity_error=velocity_error,
                position_error=error,
            )
            for name, (part, error) in zip(names, parts, strict=True)
        )

    def _seen_parts(self, coarse: bool) -> tuple[RoundedBox, ...]:
        if len(self.parts) < 2 or not coarse:
            return self.parts
        shown = self.shown
        return enclose(shown.face_W, shown.back_W, self.padding, most=1)

    def is_still(self, config: DetectionConfig) -> bool:
        """Whether the object has rested long enough to be in a map."""
        return self.seen - self.still_since >= config.settle

    @staticmethod
    def nearness(p_W: np.ndarray, q_W: np.ndarray) -> float:
        """Returns the approximate distance between two sets of points [m]."""
        p_W = p_W[:: max(1, len(p_W) // 40)]
        q_W = q_W[:: max(1, len(q_W) // 200)]
        apart = p_W[:, None] - q_W[None]
        return math.sqrt(float((apart**2).sum(axis=2).min()))
