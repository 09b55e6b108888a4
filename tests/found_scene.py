"""A table with a can that only the splat shows, as a scenario."""

from pathlib import Path

import numpy as np
from pydrake.math import RigidTransform

from remosplat_drake.generation.primitive_surfels import surfel_splat
from remosplat_drake.scene.primitive_scene import Box, Cylinder, PrimitiveScene
from remosplat_drake.scene.rmmi import write_rmmi
from remosplat_drake.splat.codecs.ply import write_ply

TOP, RADIUS, HEIGHT = 0.5558, 0.033, 0.12
"""Height of the table, and the can's radius and height [m]."""

CAN = np.array([1.12, 0.5, TOP + 0.5 * HEIGHT])
"""Position of the can [m]."""

ON_IT = CAN - [RADIUS, 0.0, 0.0]
"""A point on the can [m]."""

_TEXT = """
FoundObjects:
  scene: {splat: splat.ply, truth: scene.json}
  mapping: {enabled: false}
  teleop:
    workspace_lower: [-1.0, -1.5, 0.1]
    workspace_upper: [2.0, 1.5, 1.8]
    found_objects: {mass: 0.35}
  objects:
  - name: tray
    X_WO: {translation: [1.14, 0.8, 0.5758]}
    box: [0.24, 0.3, 0.04]
    in_splat: false
  - name: table
    X_WO: {translation: [1.3, 0.4, 0.5258]}
    box: [0.6, 1.2, 0.06]
"""


def write_found_scene(folder: Path) -> str:
    """Writes the scene; returns what `load_scenario` takes."""
    table = RigidTransform([1.3, 0.4, TOP - 0.03])
    truth = PrimitiveScene(
        (Box(table, np.array([0.3, 0.6, 0.03]), "table"),),
        (Cylinder(RigidTransform(CAN), RADIUS, 0.5 * HEIGHT, "can"),),
        X_WB_start=(0.0, 0.0, 0.0),
    )
    write_ply(folder / "splat.ply", surfel_splat(truth, 30_000))
    write_rmmi(folder / "scene.json", truth)
    file = folder / "scenarios.yaml"
    file.write_text(_TEXT)
    return f"{file}:FoundObjects"
