"""Converts a suggested task into an entry of a scenario file."""

import math
from pathlib import Path

import yaml
from pydrake.math import RigidTransform, RollPitchYaw

from remosplat_drake.controller.ingredients import CollisionDamperConfig
from remosplat_drake.reconstruction.report.quality_report import (
    MAP_ERROR_MARGIN,
)
from remosplat_drake.task.suggestion import NEAR, Suggestion

FRANKIE = "frankie"
"""The default robot of suggested tasks."""


def scenario_path(splat: Path) -> Path:
    """Returns the path of the scenario file that belongs to a splat file."""
    return splat.with_suffix(".yaml")


def suggested_entry(
    splat: str, task: Suggestion, robot: str, map_error: float | None
) -> dict:
    """Makes a scenario's entry from a suggested task.

    Args:
        splat: Name of the splat's file, as written in the scenario.
        task: The task.
        robot: The robot's name or file, as written in the scenario.
        map_error: Largest amount by which a distance to the splat exceeds the
            true distance [m]; None if it is unknown.
    """
    scene: dict = {"splat": splat}
    if not task.X_WG.IsExactlyIdentity():
        scene["X_WG"] = _placement(task.X_WG)
    controller = {}
    if map_error is not None:
        scene["map_error"], safe = rounded_error(map_error)
        if CollisionDamperConfig().stopping < safe < NEAR:
            controller = {"collision": {"stopping": safe}}
    entry_of_robot = {} if robot == FRANKIE else {"model": robot}
    if task.base_pose is not None:
        entry_of_robot["base_pose"] = task.base_pose.round(3).tolist()
    return {
        "scene": scene,
        **({"controller": controller} if controller else {}),
        **({"robot": entry_of_robot} if entry_of_robot else {}),
        "targets": [
            {
                "translation": task.X_WT.translation().round(3).tolist(),
                "rpy_deg": [180.0, 0.0, 0.0],
            }
        ],
    }


def _placement(X_WG: RigidTransform) -> dict:
    """Returns the scenario's fields of a map's pose: position and yaw in W."""
    yaw = RollPitchYaw(X_WG.rotation()).yaw_angle()
    return {
        "translation": X_WG.translation().round(4).tolist(),
        "rpy_deg": [0.0, 0.0, round(math.degrees(yaw), 2)],
    }


def as_yaml(splat: Path, entry: dict) -> str:
    """Formats an entry as a YAML file; the entry is named after the splat."""
    name = "".join(word.capitalize() for word in splat.stem.split("_"))
    return yaml.safe_dump(
        {name: entry}, sort_keys=False, default_flow_style=None
    )


def rounded_error(map_error: float) -> tuple[float, float]:
    """Returns a map's error and its safe stopping distance, rounded up [m].

    The error is rounded up to 0.1 mm, the stopping distance to 1 mm.
    """
    error = math.ceil(round(1e6 * map_error) / 100) / 1e4
    safe = math.ceil(round(1e6 * (error + MAP_ERROR_MARGIN)) / 1000) / 1e3
    return error, safe
