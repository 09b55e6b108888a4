"""What engines run: jobs, and where they come from."""

import dataclasses as dc
import traceback
from collections import deque
from collections.abc import Callable, Generator, Iterable
from typing import Any, Protocol

DIED = "its process died"
"""The error of a job whose worker was lost."""

Results = Generator[Any, None, None]
"""Results of jobs, in whatever order they come."""


@dc.dataclass(frozen=True, eq=False)
class Job:
    """A call that gives a result even where it fails.

    Attributes:
        subject: The argument; small, since it is sent to workers.
        function: What is called; importable by workers.
        failed: Makes a result of the subject and an error's text.
    """

    subject: Any
    function: Callable[[Any], Any]
    failed: Callable[[Any, str], Any]

    def run(self) -> Any:
        """The result; an error becomes one, too."""
        try:
            return self.function(self.subject)
        except Exception:
            error = traceback.format_exc(limit=-3).strip()
            return self.failed(self.subject, error)

    def died(self) -> Any:
        """The result when no worker survives the job."""
        return self.failed(self.subject, DIED)


class JobSource(Protocol):
    """Hands out jobs; results may bring new ones."""

    def take(self) -> Job | None:
        """The next job; None if there is none, or none before a result."""

    def done(self, job: Job, result: Any) -> None:
        """Tells the result of a job that was taken."""


class JobList:
    """A source of jobs that are known from the start."""

    def __init__(self, jobs: Iterable[Job] = ()):
        self._jobs = deque(jobs)

    def __len__(self) -> int:
        return len(self._jobs)

    def add(self, job: Job) -> None:
        """Puts one at the end."""
        self._jobs.append(job)

    def take(self) -> Job | None:
        """The next job, or None."""
        return self._jobs.popleft() if self._jobs else None

    def done(self, job: Job, result: Any) -> None:
        """Nothing follows from a result."""
