"""Undoes what an inspection found to be wrong with a capture."""

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
        capture: The capture, mended as far as that goes.
        inspection: Its inspection after the repair.
        undone: What was found and undone, in that order.
    """

    capture: Capture
    inspection: CaptureInspection
    undone: tuple[Finding, ...] = ()


def repair(capture: Capture, inspection: CaptureInspection) -> Repair:
    """Mends what can be mended, one finding after the other.

    After each the capture is inspected anew, for one mistake may look like
    two: of depths in another unit, poses seem wrong as well. A remedy is tried
    once.

    Args:
        capture: A capture.
        inspection: Its inspection.
    """
    undone: list[Finding] = []
    while True:
        tried = {finding.name for finding in undone}
        for finding in inspection.findings:
            if finding.mend is None or finding.name in tried:
                continue
            mended = finding.mend(capture)
            if len(mended) >= MIN_VIEWS:
                break
        else:
            return Repair(capture, inspection, tuple(undone))
        capture, inspection = mended, inspect_capture(mended)
        undone.append(finding)
