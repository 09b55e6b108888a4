"""`Finding`: the result of one check."""

import dataclasses as dc

PASSED, ADVICE, FAILED, SKIPPED = "passed", "advice", "failed", "skipped"
"""Results of checks. A run is refused if any check has the result FAILED, or if
a needed check was SKIPPED; see `doctor_report.needed_checks`.
"""


@dc.dataclass(frozen=True)
class Finding:
    """The result of a check.

    Attributes:
        check: Name of the check.
        result: One of PASSED, ADVICE, FAILED and SKIPPED.
        found: The found value.
        wanted: The expected value.
        source: Source of the found value.
        remedy: Advice to correct the fault; empty if there is none.
    """

    check: str
    result: str
    found: str
    wanted: str
    source: str
    remedy: str = ""

    @property
    def line(self) -> str:
        """The finding in one line."""
        return f"{self.check}: {self.found}; wanted: {self.wanted}"


def judged(
    check: str,
    good: bool,
    *,
    found: str,
    wanted: str,
    source: str,
    remedy: str,
    otherwise: str = FAILED,
) -> Finding:
    """Makes a finding, which contains advice only if the check did not pass.

    Args:
        check: Name of the check.
        good: Whether the check has passed.
        found: The found value.
        wanted: The expected value.
        source: Source of the found value.
        remedy: Advice to correct the fault.
        otherwise: The result if the check has not passed, FAILED or ADVICE.
    """
    if good:
        return Finding(check, PASSED, found, wanted, source)
    return Finding(check, otherwise, found, wanted, source, remedy)
