"""Runs trials of a study, and stores each result as a line of a file."""

import dataclasses as dc
import json
from collections.abc import Callable, Sequence
from contextlib import closing
from pathlib import Path
from typing import Any

from rich.console import Console
from rich.progress import Progress

from remosplat_drake.base.errors import FileError
from remosplat_drake.base.pool import Job, run_jobs
from remosplat_drake.benchmark.line_file import LineFile

Restore = Callable[[dict[str, Any]], Any]
"""Function that restores a result from the fields of a line."""


def run_missing(
    jobs: Sequence[Job],
    path: Path,
    restore: Restore,
    workers: int,
    doing: str = "reconstructing",
) -> list[Any]:
    """Runs the jobs without a result in a file, and adds their results.

    Args:
        jobs: All jobs; subjects and results have a `key`; results are data
            classes with an `error`, which is empty without one.
        path: The file; it need not exist.
        restore: Makes a result of a line's fields.
        workers: Number of worker processes; 0 runs everything in this one.
        doing: Description for the progress bar.

    Returns:
        The results of all jobs, in their order.

    Raises:
        FileError: The file contains other data, or cannot be written.
    """
    known = read_results(path, restore)
    missing = [job for job in jobs if job.subject.key not in known]
    running = run_jobs(missing, workers)
    progress = Progress(console=Console(stderr=True), transient=True)
    with LineFile(path) as file, closing(running), progress:
        task = progress.add_task(doing, total=len(missing))
        for result in running:
            file.append(json.dumps(dc.asdict(result)))
            known[result.key] = result
            progress.advance(task)
    return [known[job.subject.key] for job in jobs]


def read_results(path: Path, restore: Restore) -> dict[str, Any]:
    """Reads the results of earlier runs by key, without those with an error.

    An incomplete line is ignored.

    Args:
        path: A file of results, one a line; it need not exist.
        restore: Makes a result of a line's fields.

    Raises:
        FileError: The file contains other data.
    """
    results = {}
    text = path.read_text() if path.is_file() else ""
    for number, line in enumerate(text.split("\n")[:-1], start=1):
        try:
            fields = json.loads(line)
            if not fields["error"]:
                results[fields["key"]] = restore(fields)
        except (ValueError, TypeError, KeyError, AttributeError) as error:
            problem = f"line {number} is no result of this study"
            raise FileError(path, problem) from error
    return results
