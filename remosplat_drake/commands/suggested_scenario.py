"""Writes the scenario that is suggested for a splat."""

import textwrap
from collections.abc import Sequence
from pathlib import Path

from remosplat_drake.app.scenario_robot import robot_beside
from remosplat_drake.base.atomic_file import write_atomically
from remosplat_drake.capture.capture import Capture
from remosplat_drake.commands.suggested_entry import (
    FRANKIE,
    as_yaml,
    rounded_error,
    scenario_path,
    suggested_entry,
)
from remosplat_drake.oracle.sphere_to_ellipsoid import SphereToEllipsoidField
from remosplat_drake.reconstruction.measured_space import times_looked_through
from remosplat_drake.reconstruction.report.quality_report import (
    rounded_up,
)
from remosplat_drake.reconstruction.workspace import Workspace
from remosplat_drake.robot.robot_model import load_robot
from remosplat_drake.splat.gaussian_splat import GaussianSplat
from remosplat_drake.task.suggestion import NEAR, suggest_task

_FREE_MARGIN = 0.05
"""A point counts as free if a camera has measured a surface at least this far
behind it [m]."""


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

    Comments in the scenario state the error of the splat and a safe stopping
    distance. The scenario uses this stopping distance if the target can be
    reached with it.

    Args:
        splat: Path of the splat's file; the scenario is written beside it.
        splat_W: The splat, expressed in W, with the floor at z = 0.
        capture: The capture that the splat was made of, in the same frame.
        workspace: Space in which the target must be.
        map_error: Largest amount by which a distance to the splat exceeds the
            true distance [m].
        warnings: Descriptions of the capture's defects.
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
    error, safe = rounded_error(map_error)
    named = robot_beside(robot, splat.parent)
    entry = suggested_entry(splat.name, task, named, map_error)
    text = _verdict(error, safe) + _doubts(warnings) + as_yaml(splat, entry)
    write_atomically(scenario_path(splat), text)
    return text


def _verdict(error: float, safe: float) -> str:
    """Returns a splat's error and safe stopping distance as YAML comments."""
    text = (
        f"# Distances may be too large by {rounded_up(error)}; stopping"
        f" distances are safe\n# from {rounded_up(safe)} on.\n"
    )
    if safe >= NEAR:
        text += (
            "# The target is nearer to the scene than a safe stopping distance,"
            " so\n# `remosplat run` refuses it.\n"
        )
    return text


def _doubts(warnings: Sequence[str]) -> str:
    """Returns the descriptions of the capture's defects as YAML comments."""
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
