"""Runs cases in a process of their own, and keeps those that fail."""

import collections
import dataclasses as dc
import json
import os
import select
import shutil
import subprocess
import sys
import time
from collections.abc import Callable, Iterable
from pathlib import Path
from tempfile import TemporaryDirectory

HANG = 120.0
"""A case that has not answered after so long hangs [s]."""

_START = 300.0
"""A worker imports much, and makes good files of every format [s]."""

FAILURES = ("traceback", "memory", "crash", "hang")
"""Kinds of answers that no file may cause."""

_TESTS = Path(__file__).resolve().parents[1]


@dc.dataclass(frozen=True)
class Outcome:
    """What came of a case.

    Attributes:
        format: Of its files.
        seed: That it is made of.
        kind: One of `FAILURES`; or `read`, `refused` or `missing`, where an
            optional package is.
        text: The error's, if there was one.
        trace: A defect's traceback.
    """

    format: str
    seed: int
    kind: str
    text: str = ""
    trace: str = ""

    @property
    def failed(self) -> bool:
        """Whether a file has done what none may."""
        return self.kind in FAILURES


class Worker:
    """A process that answers cases; another takes its place if it dies."""

    def __init__(self, folder: Path, module: str = "fuzz.worker"):
        """Starts none yet.

        Args:
            folder: For its files.
            module: What it runs.
        """
        self._folder = folder
        self._module = module
        self._process: subprocess.Popen | None = None
        self._begun = 0

    def answer(self, name: str, seed: int) -> Outcome:
        """Runs a case."""
        process = self._process or self._start()
        assert process.stdin is not None
        process.stdin.write(f"{name} {seed}\n".encode())
        process.stdin.flush()
        line = self._line(process, HANG)
        if line:
            return Outcome(name, seed, **json.loads(line))
        hangs = process.poll() is None
        self.close()
        code = process.returncode
        kind = "hang" if hangs else "crash"
        error = (self._place / "stderr").read_text(errors="replace")
        return Outcome(name, seed, kind, f"exit code {code}", error[-6000:])

    def close(self) -> None:
        """Ends the process."""
        if self._process is not None:
            self._process.kill()
            self._process.communicate()
            self._process = None

    @property
    def case(self) -> Path:
        """Where the files of the latest case are."""
        return self._place / "case"

    @property
    def _place(self) -> Path:
        return self._folder / f"worker{self._begun}"

    def _start(self) -> subprocess.Popen:
        self._begun += 1
        self._place.mkdir(parents=True)
        path = [str(_TESTS), str(_TESTS.parent), os.environ.get("PYTHONPATH")]
        environment = os.environ | {
            "PYTHONPATH": os.pathsep.join(filter(None, path)),
            # Their threads' stacks would count.
            "OMP_NUM_THREADS": "1",
            "OPENBLAS_NUM_THREADS": "1",
        }
        with (self._place / "stderr").open("wb") as error:
            process = subprocess.Popen(
                [sys.executable, "-m", self._module, str(self._place)],
                stdin=subprocess.PIPE,
                stdout=subprocess.PIPE,
                stderr=error,
                env=environment,
            )
        self._process = process
        if not self._line(process, _START):
            error = (self._place / "stderr").read_text(errors="replace")
            raise RuntimeError(f"the worker does not start: {error[-3000:]}")
        return process

    def _line(self, process: subprocess.Popen, patience: float) -> bytes:
        """A line of its answers; empty if it has died or hangs."""
        assert process.stdout is not None
        ready, _, _ = select.select([process.stdout], [], [], patience)
        line = process.stdout.readline() if ready else b""
        if ready and not line:
            process.wait()
        return line


def run(
    cases: Iterable[tuple[str, int]],
    *,
    keep: Path | None = None,
    tell: Callable[[Outcome], None] = lambda outcome: None,
    seconds: float = float("inf"),
    module: str = "fuzz.worker",
) -> list[Outcome]:
    """Runs cases until there are no more, or time is up.

    Args:
        cases: Formats and seeds.
        keep: Failing files are kept there, each beside its traceback.
        tell: Told every outcome.
        seconds: For all of them.
        module: What the worker runs.
    """
    end = time.monotonic() + seconds
    outcomes = []
    with TemporaryDirectory(prefix="remosplat-fuzz-") as folder:
        worker = Worker(Path(folder), module)
        try:
            for name, seed in cases:
                outcome = worker.answer(name, seed)
                outcomes.append(outcome)
                tell(outcome)
                if outcome.failed and keep is not None:
                    _keep(outcome, worker.case, keep)
                if time.monotonic() > end:
                    break
        finally:
            worker.close()
    return outcomes


def _keep(outcome: Outcome, files: Path, folder: Path) -> None:
    """Copies a failing case's files, beside what came of them."""
    case = folder / f"{outcome.format}-{outcome.seed}"
    shutil.copytree(files, case / "files", dirs_exist_ok=True)
    text = f"{outcome.kind}: {outcome.text}\n\n{outcome.trace}"
    (case / "outcome.txt").write_text(text, errors="replace")


def counts(outcomes: Iterable[Outcome]) -> dict[str, collections.Counter]:
    """How often each kind of answer came, by format."""
    table: dict[str, collections.Counter] = {}
    for outcome in outcomes:
        table.setdefault(outcome.format, collections.Counter())[
            outcome.kind
        ] += 1
    return table
