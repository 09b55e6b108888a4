"""`MovingCase`: a scene of solids with movers (moving obstacles)."""

import dataclasses as dc
from collections.abc import Sequence
from pathlib import Path

from remosplat_drake.benchmark.scene_case import SceneCase
from remosplat_drake.generation.moving_scenes import (
    MOVING_VERSION,
    draw_movers,
)
from remosplat_drake.scene.moving.mover_track import MoverConfig
from remosplat_drake.scene.moving.person import Person
from remosplat_drake.scene.moving.track import Track

MOVING = "moving"
"""Name of the kind of suite whose scenes have movers."""


@dc.dataclass(frozen=True)
class MovingCase(SceneCase):
    """A scene with random movers. The scene's name determines the movers."""

    @staticmethod
    def of(case: SceneCase) -> "MovingCase":
        """Adds movers to a scene of another suite.

        Args:
            case: The scene without movers.
        """
        fields = {f.name: getattr(case, f.name) for f in dc.fields(case)}
        suite = f"{case.suite} with movers v{MOVING_VERSION}"
        return MovingCase(**{**fields, "suite": suite})

    def movers(self) -> Sequence[MoverConfig | Person]:
        """Draws the scene's movers.

        Raises:
            RemoSplatError: The scene's file cannot be used.
        """
        return draw_movers(self.truth(), self.seed)

    def tracks(self) -> list[Track]:
        """Returns the motions of the movers over time."""
        return [mover.make(Path()) for mover in self.movers()]
