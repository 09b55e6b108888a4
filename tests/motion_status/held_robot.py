"""A Panda that is driven somewhere, and held on its way."""

import dataclasses as dc
from pathlib import Path

import numpy as np
from pydrake.math import RigidTransform

from remosplat_drake.app.diagram import build
from remosplat_drake.app.run_result import RunResult
from remosplat_drake.app.scenario import load_scenario
from remosplat_drake.app.simulation import run
from remosplat_drake.app.world import load_world
from remosplat_drake.scene.primitive_scene import Box, PrimitiveScene
from remosplat_drake.scene.rmmi import write_rmmi
from remosplat_drake.signals.distance_field import DistanceField

PLAIN = """
One:
  scene: {truth: scene.json}
  robot: {model: panda}
  oracle: !GroundTruth {}
  control_period: 0.02
  controller: {guidance: {enabled: false}}
  time_limit: 12
  targets:
  - {translation: %s, rpy_deg: [180, 0, 0]}
"""


def drive(
    folder: Path,
    target: list[float],
    *boxes: Box,
    text: str = "",
    field: DistanceField | None = None,
    **parts,
) -> RunResult:
    """Drives a Panda without guidance among boxes to a target.

    Args:
        folder: Where the scenario's files are written.
        target: Where the hand is sent [m].
        boxes: What is truly there.
        text: Fields of the scenario to override.
        field: What the robot believes to be there; None: the truth.
        parts: Further parts of the diagram.
    """
    far = Box(RigidTransform([0.0, 0.0, -9.0]), np.full(3, 0.1), "far away")
    write_rmmi(folder / "scene.json", PrimitiveScene(boxes=(*boxes, far)))
    (folder / "test.yaml").write_text(PLAIN % target)
    scenario = load_scenario(f"{folder}/test.yaml:One", text)
    world = load_world(scenario)
    if field is not None:
        world = dc.replace(world, field=field)
    return run(build(scenario, world, **parts))


SHELF = Box(
    RigidTransform([0.55, 0, 0.25]), np.array([0.3, 0.6, 0.02]), "shelf"
)
