"""`DoctorReport`: the findings of `remosplat doctor`, in a file."""

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
"""A report older than this is invalid [s]: a working day of 12 hours."""


@dc.dataclass(frozen=True)
class DoctorReport:
    """The findings of `remosplat doctor`.

    Attributes:
        host: Name of the computer.
        url: LCM URL of the robot.
        time: Time of the checks, by the wall clock [s].
        findings: One finding for each check, in the order of the checks.
    """

    host: str
    url: str
    time: float
    findings: tuple[Finding, ...]

    @property
    def failed(self) -> list[Finding]:
        """The failed checks. If there are any, the report permits no run."""
        return [f for f in self.findings if f.result == FAILED]

    def lacking(self, needed: Collection[str]) -> list[str]:
        """Lists needed checks that are missing, with reasons.

        A skipped check counts as missing. A check with the result ADVICE does
        not count as missing.

        Args:
            needed: Names of the needed checks.
        """
        found = {f.check: f for f in self.findings}
        return [
            f"{name} ({found[name].found if name in found else 'not done'})"
            for name in needed
            if name not in found or found[name].result in (SKIPPED, FAILED)
        ]

    def save(self, path: Path) -> None:
        """Writes the report as JSON, by `write_atomically`."""
        write_atomically(path, json.dumps(dc.asdict(self), indent=2) + "\n")


def needed_checks(has_base: bool) -> tuple[str, ...]:
    """Returns the checks that must not be skipped before a run.

    They do not include the check of collision thresholds, since it is only
    possible on the computer of the arm's driver.

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
    """Returns the default path of the report."""
    return state_dir() / "doctor.json"


def this_host() -> str:
    """Returns the name of this computer."""
    return socket.gethostname()


def read_report(path: Path) -> DoctorReport:
    """Reads a report.

    Args:
        path: The file.

    Raises:
        FileError: The file does not exist, or is not a report.
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
    """Returns the reason why a report does not permit a run, or "".

    Args:
        report: The report.
        host: Name of this computer.
        url: LCM URL of the run.
        now: Wall clock [s].
        needed: Names of the checks that must neither have failed nor have been
            skipped.
    """
    if report.host != host:
        return f"was made on another computer, {report.host}"
    if report.url != url:
        return f"is about another LCM URL, {report.url}"
    age = now - report.time
    if not 0 <= age <= LONGEST_AGE:
        return (
            f"is {age / 3600:.1f} hours old; at most {LONGEST_AGE / 3600:.0f} "
            "hours are valid"
        )
    if report.failed:
        return f"contains a failure: {report.failed[0].line}"
    lacking = ", ".join(report.lacking(needed))
    return f"lacks checks: {lacking}" if lacking else ""


def check_doctor(
    path: Path, url: str, now: float, needed: Collection[str]
) -> None:
    """Raises an error unless a valid report permits to move a robot.

    Args:
        path: File of the report.
        url: LCM URL of the run.
        now: Wall clock [s].
        needed: Names of the checks that the run needs, see `objection`.

    Raises:
        RemoSplatError: There is no report, or it is not valid for this run.
    """
    advice = "run `remosplat doctor`, or add --without-doctor"
    if not path.exists():
        raise RemoSplatError(f"{path}: no report about the robot; {advice}")
    problem = objection(
        read_report(path), host=this_host(), url=url, now=now, needed=needed
    )
    if problem:
        raise RemoSplatError(f"{path}: the report {problem}; {advice}")
