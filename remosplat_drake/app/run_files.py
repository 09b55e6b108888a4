"""Writes the files of a run: its measurements, and all its ticks."""

import dataclasses as dc
import json
from pathlib import Path

from remosplat_drake.app.diagram import Application
from remosplat_drake.app.run_result import RunResult
from remosplat_drake.base.atomic_file import atomic_write
from remosplat_drake.base.real_time import LoopQuality
from remosplat_drake.recording.trajectory import save_trajectory

METRICS, TRAJECTORY = "metrics.json", "trajectory.npz"
"""Names of a run's files in its output folder."""


def run_document(
    result: RunResult,
    application: Application,
    loop: LoopQuality | None,
    known: dict,
) -> dict:
    """Returns all measurements of a run, except its ticks.

    Args:
        result: Result of the run.
        application: The diagram that was run.
        loop: Timing of a real robot's loop; None in a simulation.
        known: Content, error and problems of the map, from
            `Admission.document`.
    """
    document = {
        "scenario": application.scenario.source,
        "outcome": result.outcome,
        "targets_reached": result.targets_reached,
        "targets": result.targets,
        "position_error": result.position_error,
        "angle_error": result.angle_error,
        "effector_errors": result.effector_errors,
        "motion_status": result.motion_status.document(),
        "motion_history": [
            {"time": time, **motion_status.document()}
            for time, motion_status in result.motion_history
        ],
        "search_effort": dc.asdict(result.search_effort),
        "map": application.world.field.revision,
        **known,
        **dc.asdict(result.metrics),
    }
    if loop is not None:
        document["loop"] = dc.asdict(loop)
    return document


def save_result(result: RunResult, document: dict, folder: Path) -> None:
    """Writes metrics.json and trajectory.npz, each atomically.

    If the disk is full, earlier files of these names are kept.

    Args:
        result: Result of the run.
        document: The measurements, from `run_document`.
        folder: Folder that receives both files.

    Raises:
        FileError: A file cannot be written.
    """
    with atomic_write(folder / METRICS) as file:
        json.dump(document, file, indent=2)
        file.write("\n")
        # These bytes are computed before either file is written, so that both
        # files in a folder belong to one run.
        file.flush()
        save_trajectory(result.trajectory, folder / TRAJECTORY)
