"""The scenario that is suggested for a splat."""

import math
import textwrap
from collections.abc import Sequence
from pathlib import Path

import yaml
from pydrake.math import RigidTransform, RollPitchYaw

from remosplat_drake.app.scenario_robot import robot_beside
from remosplat_drake.base.atomic_file import write_atomically
from remosplat_drake.capture.capture import Capture
from remosplat_drake.controller.ingredients import CollisionDamperConfig
from remosplat_drake.oracle.sphere_to_ellipsoid import SphereToEllipsoidField
from remosplat_drake.reconstruction.measured_space import times_looked_through
from remosplat_drake.reconstruction.report.quality_report import (
    MAP_ERROR_MARGIN,
    rounded_up,
)
from remosplat_drake.reconstruction.workspace import Workspace
from remosplat_drake.robot.robot_model import load_robot
from remosplat_drake.splat.gaussian_splat import GaussianSplat
from remosplat_drake.task.suggestion import NEAR, Suggestion, suggest_task

FRANKIE = "frankie"
"""The robot that tasks are suggested for unless told otherwise."""

_FREE_MARGIN = 0.05
"""Depth beyond a point to which views must have seen for it to be free [m]."""


def scenario_path(splat: Path) -> Path:
    """Returns the path of the scenario of a splat file."""
    return splat.with_suffix(".yaml")


def write_scenario(
    splat: Path,
    splat_W: GaussianSplat,
    capture: Capture,
    workspace: Workspace,
    map_error: float,
    warnings: Sequence[str] = (),
    robot: str = FRANKIE,
) -> str:
    """Writes a scenario with a free start and a target, and returns its text.

    It carries the verdict on the splat: its error, and a stopping distance
    that this allows, if the task can be done with one.

    Args:
        splat: Path of the splat's file; the scenario is written beside it.
        splat_W: The splat, expressed in W, with the floor at z = 0.
        capture: The capture that the splat was made of, in the same frame.
        workspace: Space in which the target is sought.
        map_error: Largest over-estimate of a distance by the splat [m].
        warnings: What is wrong with the capture, in words.
        robot: Name of the robot, or a file that describes one.

    Raises:
        RemoSplatError: There is no free space, or the file cannot be written.
    """
    task = suggest_task(
        load_robot(robot, floor_height=0.03),
        SphereToEllipsoidField(splat_W),
        workspace.lower,
        workspace.upper,
        lambda p_W: times_looked_through(capture, p_W, _FREE_MARGIN) > 1,
        may_move_map=True,
    )
    error, safe = _rounded(map_error)
    named = robot_beside(robot, splat.parent)
    entry = suggested_entry(splat.name, task, named, map_error)
    text = _verdict(error, safe) + _doubts(warnings) + as_yaml(splat, entry)
    write_atomically(scenario_path(splat), text)
    return text


def suggested_entry(
    splat: str, task: Suggestion, robot: str, map_error: float | None
) -> dict:
    """Makes a scenario's entry from a suggested task.

    Args:
        splat: Name of the splat's file, as the scenario is to give it.
        task: The task.
        robot: The robot, as the scenario is to give it.
        map_error: Largest over-estimate of a distance by the splat [m]; None
            if nobody knows it.
    """
    scene: dict = {"splat": splat}
    if not task.X_WG.IsExactlyIdentity():
        scene["X_WG"] = _placement(task.X_WG)
    controller = {}
    if map_error is not None:
        scene["map_error"], safe = _rounded(map_error)
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
    """Writes a map's pose in W, which turns about z alone."""
    yaw = RollPitchYaw(X_WG.rotation()).yaw_angle()
    return {
        "translation": X_WG.translation().round(4).tolist(),
        "rpy_deg": [0.0, 0.0, round(math.degrees(yaw), 2)],
    }


def as_yaml(splat: Path, entry: dict) -> str:
    """Writes an entry as the YAML of a file, named after the splat."""
    name = "".join(word.capitalize() for word in splat.stem.split("_"))
    return yaml.safe_dump(
        {name: entry}, sort_keys=False, default_flow_style=None
    )


def _rounded(map_error: float) -> tuple[float, float]:
    """A map's error and the stopping distance that is safe, rounded up.

    To tenths of a millimetre, and to millimetres.
    """
    error = math.ceil(round(1e6 * map_error) / 100) / 1e4
    safe = math.ceil(round(1e6 * (error + MAP_ERROR_MARGIN)) / 1000) / 1e3
    return error, safe


def _verdict(error: float, safe: float) -> str:
    """Writes the verdict on a splat as comments in YAML."""
    text = (
        f"# Distances may be too large by {rounded_up(error)}; stopping"
        f" distances are safe\n# from {rounded_up(safe)} on.\n"
    )
    if safe >= NEAR:
        text += (
            "# The target is nearer to the scene than that, so `remosplat run`"
            " refuses it.\n"
        )
    return text


def _doubts(warnings: Sequence[str]) -> str:
    """Writes what is wrong with the capture as comments in YAML."""
    return "".join(
        textwrap.fill(
            f"The capture: {warning}",
            80,
            initial_indent="# ",
            subsequent_indent="#   ",
            break_long_words=False,
        )
        + "\n"
        for warning in warnings
    )
