"""`DoctorReport`: all findings, on the disk, and whether they still hold."""

import dataclasses as dc
import json
import socket
from collections.abc import Collection
from pathlib import Path

from remosplat_drake.base.atomic_file import write_atomically
from remosplat_drake.base.errors import FieldError, FileError, RemoSplatError
from remosplat_drake.base.resources import state_dir
from remosplat_drake.base.strict_json import as_number, read_json_object
from remosplat_drake.hardware.doctor.drills import needed_drills
from remosplat_drake.hardware.doctor.finding import FAILED, SKIPPED, Finding

LONGEST_AGE = 12 * 3600.0
"""Age from which on a report says nothing any more [s]: a working day."""


@dc.dataclass(frozen=True)
class DoctorReport:
    """The findings of `remosplat doctor`.

    Attributes:
        host: Name of the computer.
        url: LCM URL of the robot's wire.
        time: When it was found, by the wall clock [s].
        findings: One for each check, in their order.
    """

    host: str
    url: str
    time: float
    findings: tuple[Finding, ...]

    @property
    def failed(self) -> list[Finding]:
        """Findings with which no robot may be driven."""
        return [f for f in self.findings if f.result == FAILED]

    def lacking(self, needed: Collection[str]) -> list[str]:
        """Names the checks among those needed that are missing, and why.

        A check that was skipped is missing like one that was never made; one
        that ended in advice is not.

        Args:
            needed: Names of checks.
        """
        found = {f.check: f for f in self.findings}
        return [
            f"{name} ({found[name].found if name in found else 'not done'})"
            for name in needed
            if name not in found or found[name].result in (SKIPPED, FAILED)
        ]

    def save(self, path: Path) -> None:
        """Writes the report as JSON; see `write_atomically` for errors."""
        write_atomically(path, json.dumps(dc.asdict(self), indent=2) + "\n")


def needed_checks(has_base: bool) -> tuple[str, ...]:
    """Returns the checks without which no robot is driven.

    None of them may be skipped. The collision thresholds may: only the
    computer on which the arm's driver runs can look them up.

    Args:
        has_base: Whether the robot has a mobile base.
    """
    parts = ("arm", "base") if has_base else ("arm",)
    on_wire = [
        f"{what} of the {part}"
        for part in parts
        for what in ("statuses", "clock", "mode")
    ]
    return (
        *("clock", "multicast", "reach"),
        *on_wire,
        *needed_drills(has_base),
    )


def default_path() -> Path:
    """Returns where the report lies unless a flag names another file."""
    return state_dir() / "doctor.json"


def this_host() -> str:
    """Returns the name of this computer."""
    return socket.gethostname()


def read_report(path: Path) -> DoctorReport:
    """Reads a report.

    Args:
        path: The file.

    Raises:
        FileError: There is no such file, or it is no report.
        FieldError: A field is unusable.
    """
    document = read_json_object(path)
    names = {field.name for field in dc.fields(Finding)}
    findings = document.get("findings")
    if not isinstance(findings, list):
        raise FileError(path, "is not a report of `remosplat doctor`")
    is_report = all(
        isinstance(finding, dict)
        and finding.keys() == names
        and all(isinstance(text, str) for text in finding.values())
        for finding in findings
    )
    if not is_report or document.keys() != {
        field.name for field in dc.fields(DoctorReport)
    }:
        raise FileError(path, "is not a report of `remosplat doctor`")
    for field in ("host", "url"):
        if not isinstance(document[field], str):
            raise FieldError(str(path), field, "expected a text")
    return DoctorReport(
        host=document["host"],
        url=document["url"],
        time=as_number(path, "time", document["time"]),
        findings=tuple(Finding(**finding) for finding in findings),
    )


def objection(
    report: DoctorReport,
    *,
    host: str,
    url: str,
    now: float,
    needed: Collection[str],
) -> str:
    """Says why a report does not allow a run; empty if it does.

    Args:
        report: The report.
        host: Name of this computer.
        url: LCM URL of the run.
        now: Wall clock [s].
        needed: Names of the checks that must have been made, and not have
            failed: one that was skipped was not made.
    """
    if report.host != host:
        return f"is of another computer, {report.host}"
    if report.url != url:
        return f"is of another wire, {report.url}"
    age = now - report.time
    if not 0 <= age <= LONGEST_AGE:
        return (
            f"is {age / 3600:.1f} hours old; wanted: at most"
            f" {LONGEST_AGE / 3600:.0f}"
        )
    if report.failed:
        return f"says that {report.failed[0].line}"
    lacking = ", ".join(report.lacking(needed))
    return f"lacks checks: {lacking}" if lacking else ""


def check_doctor(
    path: Path, url: str, now: float, needed: Collection[str]
) -> None:
    """Refuses a run of a robot that no doctor has seen, or found well.

    Args:
        path: File of the report.
        url: LCM URL of the run.
        now: Wall clock [s].
        needed: Names of the checks that a run needs, as for `objection`.

    Raises:
        RemoSplatError: There is no such report, or it does not hold.
    """
    advice = "run `remosplat doctor` on this wire, or add --without-doctor"
    if not path.exists():
        raise RemoSplatError(f"{path}: no report on robot and wire; {advice}")
    problem = objection(
        read_report(path), host=this_host(), url=url, now=now, needed=needed
    )
    if problem:
        raise RemoSplatError(f"{path}: the report {problem}; {advice}")
