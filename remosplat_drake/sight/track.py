"""`Track`: one thing that cameras see move, over many images."""

import dataclasses as dc
import math

import numpy as np

from remosplat_drake.scene.mover import Mover
from remosplat_drake.sight.edge_filter import Edges
from remosplat_drake.sight.enclosure import RoundedBox, enclose
from remosplat_drake.sight.sight_config import SightConfig

TRUSTED = 2
"""Number of images that must show a small thing before it counts."""

_PLAIN = 40
"""So many points count at once."""

_HIDDEN_PARTS = 2
"""Most boxes around what is hidden of a thing."""


@dc.dataclass(frozen=True, eq=False)
class Stretches:
    """What is seen of a thing, and what may be behind it.

    Attributes:
        face_W: Points that were seen, in W, shape (n, 3) [m].
        back_W: How far the thing may reach behind each, shape (n, 3) [m].
        seen: When each was seen last, shape (n,) [s].
    """

    face_W: np.ndarray
    back_W: np.ndarray
    seen: np.ndarray

    def __len__(self) -> int:
        return len(self.seen)

    def select(self, index: np.ndarray) -> "Stretches":
        """Returns those that a boolean mask or index array selects."""
        return Stretches(
            self.face_W[index], self.back_W[index], self.seen[index]
        )

    def moved(self, way_W: np.ndarray) -> "Stretches":
        """Returns them after a motion, shape (3,) [m]."""
        return Stretches(self.face_W + way_W, self.back_W + way_W, self.seen)

    @staticmethod
    def joined(*parts: "Stretches") -> "Stretches":
        """Joins some."""
        return Stretches(
            np.concatenate([part.face_W for part in parts]),
            np.concatenate([part.back_W for part in parts]),
            np.concatenate([part.seen for part in parts]),
        )

    @staticmethod
    def none() -> "Stretches":
        """Makes none."""
        return Stretches(np.zeros((0, 3)), np.zeros((0, 3)), np.zeros(0))


@dc.dataclass(frozen=True, eq=False)
class Track:
    """A thing that was seen to be new, and where it is.

    Attributes:
        name: Its name, "seen 3" for example; it keeps it while it is followed.
        parts: Boxes around what is seen of it, at the time of `edges`.
        shown: What is seen of it then.
        hidden: What of it was seen before, and may be where no camera sees now,
            moved on as it was predicted.
        edges: Its outlines, and how fast they move.
        images: Number of images that showed it, or what it came off.
        padding: How far it may reach beyond its points [m].
        error: By how much these may be misplaced [m].
        still_since: Since when it has not left its place [s].
        home: Its outline then, shape (2, 3) [m].
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
        """Whether it is more than a speck that one image shows."""
        return self.images >= TRUSTED or len(self.shown) >= _PLAIN

    @property
    def face_W(self) -> np.ndarray:
        """All points of it that are or were seen, shape (n, 3) [m]."""
        return np.concatenate([self.shown.face_W, self.hidden.face_W])

    @property
    def seen(self) -> float:
        """When any of it was seen last [s]."""
        return max(
            self.shown.seen.max(initial=-np.inf),
            self.hidden.seen.max(initial=-np.inf),
        )

    def after(self, time: float, config: SightConfig) -> "Track":
        """Predicts the track: nothing of it is seen at a later time yet.

        Args:
            time: The later time [s].
            config: How it may move.
        """
        v, _ = self.edges.velocity(config.max_speed)
        way = (time - self.edges.time) * v
        hidden = Stretches.joined(self.shown, self.hidden).moved(way)
        edges = self.edges.after(time, config.max_acceleration)
        return dc.replace(
            self, parts=(), shown=Stretches.none(), hidden=hidden, edges=edges
        )

    def growth(self, since: float, config: SightConfig) -> float:
        """Bounds how far it is from where it is predicted.

        Args:
            since: When it was seen last [s].
            config: How it may move.
        """
        t = self.edges.time - since
        v, error = self.edges.velocity(config.max_speed)
        soon = error * t + 0.5 * config.max_acceleration * t**2
        fast = config.max_speed + float(np.linalg.norm(v))
        return min(soon, fast * t)

    def movers(
        self, config: SightConfig, *, coarse: bool = False
    ) -> tuple[Mover, ...]:
        """Tells where it is, and what it may do.

        Args:
            config: How it may move.
            coarse: Whether what is seen gets one box, and not several.
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

    def is_still(self, config: SightConfig) -> bool:
        """Whether it has stayed where it is for so long that a map has it."""
        return self.seen - self.still_since >= config.settle

    @staticmethod
    def nearness(p_W: np.ndarray, q_W: np.ndarray) -> float:
        """Returns about the least distance between two sets of points [m]."""
        p_W = p_W[:: max(1, len(p_W) // 40)]
        q_W = q_W[:: max(1, len(q_W) // 200)]
        apart = p_W[:, None] - q_W[None]
        return math.sqrt(float((apart**2).sum(axis=2).min()))
