"""`PreparedCapture`: a capture after inspection, refinement and placement."""

import argparse
import dataclasses as dc

import numpy as np
from rich.console import Console

from remosplat_drake.base.errors import FieldError
from remosplat_drake.base.kept_stages import KeptStages
from remosplat_drake.base.progress import Progress
from remosplat_drake.capture.capture import Capture, check_reconstructible
from remosplat_drake.commands.alignment import aligned
from remosplat_drake.commands.capture_admission import (
    admitted,
    after_alignment,
)
from remosplat_drake.commands.capture_flags import captured
from remosplat_drake.commands.map_placement import find_placement
from remosplat_drake.reconstruction.alignment.alignment import Alignment
from remosplat_drake.reconstruction.alignment.alignment_summary import (
    AlignmentSummary,
)
from remosplat_drake.reconstruction.alignment.pose_errors import PoseErrors
from remosplat_drake.reconstruction.placement import Placement
from remosplat_drake.reconstruction.workspace import Workspace


@dc.dataclass(frozen=True, eq=False)
class PreparedCapture:
    """A capture that is ready for reconstruction, and results of preparing it.

    Attributes:
        capture: The capture after inspection, refinement of its camera poses,
            and placement.
        warnings: Warnings of the capture's inspection.
        alignment: Result of the refinement of camera poses; None if `--align
            off` disables it.
        summary: Summary of the refinement for the report.
        placement: Pose of the capture's frame in the map's frame.
        workspace: Box in which the robot works.
    """

    capture: Capture
    warnings: list[str]
    alignment: Alignment | None
    summary: AlignmentSummary | None
    placement: Placement
    workspace: Workspace

    @property
    def errors(self) -> PoseErrors | None:
        """Random samples of the remaining camera errors, in the map's frame."""
        if self.alignment is None:
            return None
        errors = PoseErrors.of_draws(self.alignment.draws())
        return errors.rotated(self.placement.X_FW.rotation().matrix())


def prepare_capture(
    arguments: argparse.Namespace, console: Console, stages: KeptStages
) -> PreparedCapture:
    """Reads, inspects, refines and places the capture of a command line.

    Args:
        arguments: The command's flags.
        console: Console for progress and results.
        stages: Storage of finished stages: the selected frames and the
            refinement. An interrupted job resumes from it.

    Raises:
        RemoSplatError: The capture or a flag is unusable.
    """
    with Progress(console, "reading the capture") as progress:
        counting = "--length" if arguments.length else None
        capture = captured(
            arguments, console, progress.report, stages, counting
        )
        check_reconstructible(capture)
        progress.report("inspecting the capture")
        capture, warnings = admitted(capture, arguments, console)
    alignment, summary = aligned(capture, arguments, console, stages)
    if alignment is not None:
        capture = alignment.capture
        warnings = after_alignment(warnings, capture, alignment.undone)
    with Progress(console, "looking for the floor"):
        placement = find_placement(capture, arguments)
        capture = placement.placed(capture)
    workspace = _workspace(capture, arguments)
    console.print(placement.words, soft_wrap=True, highlight=False)
    return PreparedCapture(
        capture, warnings, alignment, summary, placement, workspace
    )


def _workspace(capture: Capture, arguments: argparse.Namespace) -> Workspace:
    if arguments.focus is None:
        return Workspace.of_capture(capture)
    workspace = Workspace.around(np.array(arguments.focus))
    if not workspace.is_seen(capture):
        raise FieldError(
            "reconstruct",
            "--focus",
            ("is far from all captured surfaces; choose a point near them"),
        )
    return workspace
