"""Inspects a capture before a command uses it: refuses, repairs or warns."""

import argparse
from collections.abc import Iterable

import numpy as np
from rich.console import Console

from remosplat_drake.base.resources import resolve
from remosplat_drake.capture.capture import Capture
from remosplat_drake.capture.checks.exactness import judge_exactness
from remosplat_drake.capture.checks.findings import (
    DEFECT,
    DEFECTS,
    INEXACT,
    Finding,
)
from remosplat_drake.capture.checks.inspection import inspect_capture
from remosplat_drake.capture.checks.repair import Repair, repair
from remosplat_drake.capture.checks.wide_baselines import (
    measure_wide_baselines,
)
from remosplat_drake.reconstruction.alignment.lens_check import judge_lens
from remosplat_drake.safety.gates import (
    REFUSAL,
    WARNING,
    Gate,
    check_names,
    open_gates,
)


def add_inspection_arguments(parser: argparse.ArgumentParser):
    """Declares `--repair` and `--accept`, the flags about defects."""
    parser.add_argument(
        "--repair",
        action="store_true",
        help=(
            "repair defects that the inspection finds: inverted poses; wrong "
            "units, axes, element orders or frames"
        ),
    )
    defects = "; ".join(f"{name}: {what}" for name, what in DEFECTS.items())
    parser.add_argument(
        "--accept",
        action="append",
        default=[],
        metavar="NAME",
        help="use the capture in spite of this defect; repeat the flag for "
        f"further defects ({defects})",
    )


def check_inspection_arguments(arguments: argparse.Namespace):
    """Checks that `--accept` contains only names of defects.

    Raises:
        RemoSplatError: `--accept` contains a name that is not the name of a
            defect.
    """
    check_names(arguments.accept, DEFECTS)


def admitted(
    capture: Capture, arguments: argparse.Namespace, console: Console
) -> tuple[Capture, list[str]]:
    """Inspects a capture, and repairs it if `--repair` is given.

    Args:
        capture: The capture, as read from its files.
        arguments: The command line, with `capture`, `repair` and `accept`.
        console: Console for findings and repairs.

    Returns:
        The capture to use, and the remaining warnings about it.

    Raises:
        RemoSplatError: The capture has a defect that `--accept` does not name;
            one line states the defect and a remedy.
    """
    result = Repair(capture, inspect_capture(capture))
    if arguments.repair:
        result = repair(capture, result.inspection)
    for finding in result.undone:
        _tell(console, "repaired:", "green", f"{finding.remedy}: {finding}")
    findings = result.inspection.findings
    passage = open_gates(
        [_gate(finding) for finding in findings],
        arguments.accept,
        hardware=False,
        where=str(resolve(arguments.capture)),
        otherwise=_otherwise(result, arguments.repair),
    )
    tell_findings(console, findings)
    return result.capture, [
        *(f"accepted although {gate}" for gate in passage.accepted),
        *(str(gate) for gate in passage.warnings),
    ]


def after_alignment(
    warnings: list[str], capture: Capture, undone: np.ndarray
) -> list[str]:
    """Returns the warnings that remain after the refinement of camera poses.

    Args:
        warnings: The warnings before the refinement.
        capture: The capture with refined cameras and depths.
        undone: Names of the camera errors that the refinement corrected, see
            `camera_errors`.
    """
    rest = [warning for warning in warnings if not warning.startswith(INEXACT)]
    if len(rest) == len(warnings):
        return rest
    wide = measure_wide_baselines(capture)
    findings = judge_exactness(capture, wide)
    if findings:
        findings = judge_lens(wide, undone) or findings
    return rest + [str(finding) for finding in findings]


def tell_findings(console: Console, findings: Iterable[Finding]):
    """Prints the defects and warnings of a capture, one line each."""
    for finding in findings:
        if finding.severity == DEFECT:
            _tell(console, "wrong:", "bold red", finding.problem)
        else:
            _tell(console, "doubtful:", "bold yellow", finding.problem)


def _gate(finding: Finding) -> Gate:
    level = REFUSAL if finding.severity == DEFECT else WARNING
    return Gate(finding.name, finding.problem, in_simulation=level)


def _otherwise(result: Repair, tried: bool) -> str:
    """Describes the remedy for defects."""
    anyway = "to use this capture anyway"
    if tried and result.undone:
        done = ", ".join(finding.remedy for finding in result.undone)
        return f"--repair {done}, which does not correct all defects; {anyway}"
    if tried:
        return f"--repair cannot correct it: make another capture; {anyway}"
    if any(
        f.repair and f.severity == DEFECT for f in result.inspection.findings
    ):
        return f"--repair corrects it if possible; {anyway}"
    return f"make another capture; {anyway}"


def _tell(console: Console, label: str, style: str, text: str):
    console.print(f"[{style}]{label}[/{style}] ", end="")
    console.print(text, markup=False, highlight=False, soft_wrap=True)
