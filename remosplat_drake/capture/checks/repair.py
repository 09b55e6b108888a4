"""Corrects the problems of a capture that an inspection found."""

import dataclasses as dc

from remosplat_drake.capture.capture import MIN_VIEWS, Capture
from remosplat_drake.capture.checks.findings import Finding
from remosplat_drake.capture.checks.inspection import (
    CaptureInspection,
    inspect_capture,
)


@dc.dataclass(frozen=True, eq=False)
class Repair:
    """A capture after its repair.

    Attributes:
        capture: The capture, corrected as far as possible.
        inspection: Inspection of this capture, after the repair.
        undone: The findings that were corrected, in the order of correction.
    """

    capture: Capture
    inspection: CaptureInspection
    undone: tuple[Finding, ...] = ()


def repair(capture: Capture, inspection: CaptureInspection) -> Repair:
    """Corrects all findings that have a remedy, one after another.

    After each correction, the capture is inspected again, since one mistake may
    cause several findings. For example, if depths have a wrong unit, poses seem
    to be wrong, too. Each remedy is tried once.

    Args:
        capture: A capture.
        inspection: Inspection of the capture.
    """
    undone: list[Finding] = []
    while True:
        tried = {finding.name for finding in undone}
        for finding in inspection.findings:
            if finding.repair is None or finding.name in tried:
                continue
            mended = finding.repair(capture)
            if len(mended) >= MIN_VIEWS:
                break
        else:
            return Repair(capture, inspection, tuple(undone))
        capture, inspection = mended, inspect_capture(mended)
        undone.append(finding)
