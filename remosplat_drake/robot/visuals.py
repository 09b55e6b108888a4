"""Visual meshes of a robot's links: the table `visuals.yaml`."""

import dataclasses as dc
from pathlib import Path
from typing import Annotated

import numpy as np
from annotated_types import Interval, Len
from pydrake.math import RigidTransform, RollPitchYaw

from remosplat_drake.base.errors import FieldError
from remosplat_drake.base.ranges import Config, Position, RollPitchYawDeg
from remosplat_drake.robot.link_table import LinkTable, load_link_table


@dc.dataclass
class LinkVisual(Config):
    """One visual mesh V on a link L."""

    # Path of the mesh inside the rtb-data package.
    mesh: str = ""
    # Position of the mesh's origin in the link [m].
    translation: Position = dc.field(default_factory=lambda: [0.0] * 3)
    # Roll, pitch and yaw of the mesh in the link [deg].
    rpy_deg: RollPitchYawDeg = dc.field(default_factory=lambda: [0.0] * 3)
    # Red, green, blue and alpha in [0, 1] of the collision shape that is drawn
    # if the mesh is missing.
    colour: Annotated[
        list[Annotated[float, Interval(ge=0, le=1)]], Len(4, 4)
    ] = dc.field(default_factory=lambda: [0.9, 0.9, 0.9, 1])

    @property
    def X_LV(self) -> RigidTransform:
        """Pose of the mesh V in its link L."""
        return RigidTransform(
            RollPitchYaw(np.deg2rad(self.rpy_deg)), self.translation
        )


@dc.dataclass
class VisualTable(LinkTable):
    """The visual meshes of every link of a robot."""

    # The visual meshes by link name.
    links: dict[str, list[LinkVisual]] = dc.field(default_factory=dict)


def load_visuals(path: Path) -> dict[str, list[LinkVisual]]:
    """Reads a `visuals.yaml`; returns the visual meshes by link name.

    Raises:
        FileError: The file is missing or not YAML.
        FieldError: A field is unknown, has the wrong type or length.
    """
    links = load_link_table(VisualTable, path, "links")
    for link, visuals in links.items():
        for i, visual in enumerate(visuals):
            if not visual.mesh:
                raise FieldError(
                    str(path), f"links.{link}[{i}].mesh", "is missing"
                )
    return links
