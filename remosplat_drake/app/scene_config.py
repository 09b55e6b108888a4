"""`SceneConfig`: a robot's surroundings in a scenario."""

import dataclasses as dc
from collections.abc import Iterator
from typing import Annotated

from annotated_types import Interval, Len
from pydrake.multibody.parsing import ModelDirective

from remosplat_drake.base.pose_config import PoseConfig
from remosplat_drake.base.ranges import (
    Config,
    OneOf,
    Position,
    field_types,
)
from remosplat_drake.splat.gaussian_splat import LARGEST_SCALE, LEAST_SCALE

FREE, WARN, OBSTACLE = "free", "warn", "obstacle"
UNKNOWN = (FREE, WARN, OBSTACLE)
"""Choices of `unknown`, the treatment of unseen space."""


@dc.dataclass
class CropConfig(Config):
    """A box in W; splats whose centres lie outside are left out."""

    # Corner of the box with the smallest coordinates x, y, z in W [m].
    lower: Position = dc.field(default_factory=lambda: [-1e3] * 3)
    # Corner of the box with the largest coordinates x, y, z in W [m].
    upper: Position = dc.field(default_factory=lambda: [1e3] * 3)


@dc.dataclass
class SceneConfig(Config):
    """Surroundings of a robot; file names are relative to the scenario file."""

    # Splat file (.ply, or any format that `remosplat convert` reads), in frame
    # G; empty: no splat.
    splat: str = ""
    # Pose of the splat's frame G in the world W.
    X_WG: PoseConfig = dc.field(default_factory=PoseConfig)
    # Metres per unit of the splat's file [m], applied before X_WG. It must be 1
    # if a quality report or a file of seen space is beside the splat, since
    # these are in metres.
    scale: Annotated[float, Interval(ge=LEAST_SCALE, le=LARGEST_SCALE)] = 1.0
    crop: CropConfig | None = None
    # File of the true geometry (RMMI JSON), for metrics, contact and
    # !GroundTruth; empty: unknown.
    truth: str = ""
    # File of an alternative true geometry (RMMI JSON), which a person selects
    # during a simulated teleoperation; empty: no alternative.
    truth_later: str = ""
    # Further objects, as Drake's model directives (`add_model`, `add_weld`):
    # boxes and cylinders that are fixed to the world. They are added to both
    # true geometries; the splat is unchanged.
    directives: Annotated[list[ModelDirective], Len(0, 1000)] = dc.field(
        default_factory=list
    )
    # Map error: the largest amount by which a distance to the splat exceeds the
    # true distance [m]; absent: unknown. If a quality report is beside the
    # splat, the larger of the two values is used. Stopping distances must
    # exceed the map error.
    map_error: Annotated[float, Interval(ge=0, le=1)] | None = None
    # File of `remosplat reconstruct` with the space that the cameras of the
    # splat's capture have seen; empty: the file beside the splat, if it exists.
    seen: str = ""
    # Treatment of space that no camera has seen: `free`, `obstacle`, or `warn`,
    # which counts as free and prints a warning. Absent: `obstacle` with
    # --hardware, `warn` in simulation.
    unknown: Annotated[str, OneOf(UNKNOWN)] | None = None
    # Height in W below which the robot's floor links ignore the scene, so that
    # wheels may stand on the floor [m].
    floor_height: Annotated[float, Interval(ge=-100, le=0.1)] = 0.03

    def check(self) -> Iterator[tuple[str, str]]:
        """Checks that each entry of the directives has exactly one key.

        Yields:
            The name of a field and its problem.
        """
        for i, directive in enumerate(self.directives):
            names = field_types(ModelDirective)
            given = [n for n in names if getattr(directive, n) is not None]
            if len(given) != 1:
                problem = f"give one of {', '.join(names)}, got {len(given)}"
                yield f"directives[{i}]", problem
