"""`Finding`: the outcome of one check."""

import dataclasses as dc

PASSED, ADVICE, FAILED, SKIPPED = "passed", "advice", "failed", "skipped"
"""Results of checks. FAILED keeps a robot from being driven, and so does
SKIPPED where a check is needed; see `doctor_report.needed_checks`."""


@dc.dataclass(frozen=True)
class Finding:
    """The result of a check.

    Attributes:
        check: Name of the check.
        result: One of PASSED, ADVICE, FAILED and SKIPPED.
        found: The found value.
        wanted: The expected value.
        source: Where it was looked up.
        mend: How to mend it; empty where nothing is to be mended.
    """

    check: str
    result: str
    found: str
    wanted: str
    source: str
    mend: str = ""

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
    mend: str,
    otherwise: str = FAILED,
) -> Finding:
    """Makes a finding, with its remedy only where it is needed.

    Args:
        check: Name of the check.
        good: Whether it holds.
        found: The found value.
        wanted: The expected value.
        source: Where it was looked up.
        mend: How to mend it.
        otherwise: The result where it does not hold, FAILED or ADVICE.
    """
    if good:
        return Finding(check, PASSED, found, wanted, source)
    return Finding(check, otherwise, found, wanted, source, mend)
