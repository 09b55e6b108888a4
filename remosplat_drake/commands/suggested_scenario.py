"""The scenario that `remosplat reconstruct` writes beside a splat."""

from pathlib import Path

import yaml

from remosplat_drake.atomic_file import write_atomically
from remosplat_drake.capture.capture import Capture
from remosplat_drake.oracle.sphere_to_ellipsoid import SphereToEllipsoidField
from remosplat_drake.reconstruction.measured_space import times_looked_through
from remosplat_drake.reconstruction.workspace import Workspace
from remosplat_drake.robot.robot_model import load_robot_model
from remosplat_drake.splat.gaussian_splat import GaussianSplat
from remosplat_drake.task.suggestion import suggest_task

_FREE_MARGIN = 0.05
"""Space is free if views saw at least so far beyond it [m]."""


def scenario_path(splat: Path) -> Path:
    """Where the scenario of a splat file is."""
    return splat.with_suffix(".yaml")


def write_scenario(
    splat: Path, splat_W: GaussianSplat, capture: Capture, workspace: Workspace
) -> str:
    """Writes a scenario with a free start and a target, and returns its text.

    Args:
        splat: The splat's file, which the scenario lies beside.
        splat_W: What it holds, the floor at z = 0.
        capture: What it is from, in the same frame.
        workspace: Where the target is sought.

    Raises:
        RemoSplatError: There is no room, or the file cannot be written.
    """
    task = suggest_task(
        load_robot_model("frankie", floor_height=0.03),
        SphereToEllipsoidField(splat_W),
        workspace.lower,
        workspace.upper,
        lambda p_W: times_looked_through(capture, p_W, _FREE_MARGIN) > 1,
    )
    entry = {
        "scene": {"splat": splat.name},
        "robot": {"base_pose": task.base_pose.round(3).tolist()},
        "targets": [
            {
                "translation": task.X_WT.translation().round(3).tolist(),
                "rpy_deg": [180.0, 0.0, 0.0],
            }
        ],
    }
    name = "".join(word.capitalize() for word in splat.stem.split("_"))
    text = yaml.safe_dump(
        {name: entry}, sort_keys=False, default_flow_style=None
    )
    write_atomically(scenario_path(splat), text)
    return text
