"""One import by the command line: its result and its time."""

import dataclasses as dc
import re
import resource
import shutil
import subprocess
import sys
from typing import Any

from apps.studies.imports.case import Case
from remosplat_drake.base.child_process import one_thread_environment
from remosplat_drake.robot.importing.mobile_base import DRIVES, FIXED
from remosplat_drake.robot.robot_description import load_robot_description

_PROGRAM = "import sys; from remosplat_drake.commands.main import main;"
_COMMAND = (sys.executable, "-c", f"{_PROGRAM} sys.exit(main(sys.argv[1:]))")

_TRIED = re.compile(r"trial run: (\d+) targets? reached")


@dc.dataclass(frozen=True)
class Result:
    """Result of an import.

    Attributes:
        key: Name of the robot.
        seconds: Processor time [s].
        tools: The end effectors' frames.
        joints: The arms' joints.
        base: Kind of the robot's base.
        tried: Number of targets that the trial run of the scenario reached.
        home: Source of its home posture.
        problem: Last output line of the command if it failed; empty if not.
        error: Error text of the trial itself; empty without an error.
    """

    key: str
    seconds: float = 0.0
    tools: tuple[str, ...] = ()
    joints: tuple[str, ...] = ()
    base: str = ""
    tried: int = 0
    home: str = ""
    problem: str = ""
    error: str = ""


def restored(fields: dict[str, Any]) -> Result:
    """Restores a result from a line's fields."""
    lists: dict[str, Any] = {x: tuple(fields[x]) for x in ("tools", "joints")}
    return Result(**{**fields, **lists})


def failed(case: Case, error: str) -> Result:
    """Makes the result of a trial that failed with an error."""
    return Result(case.key, error=error)


def run_trial(case: Case) -> Result:
    """Imports a robot by one command in a separate process.

    Args:
        case: The robot.
    """
    out = case.output / case.key
    shutil.rmtree(out, ignore_errors=True)
    before = _children_time()
    with one_thread_environment():
        done = subprocess.run(
            [*_COMMAND, "import-robot", str(case.path), "--out", str(out)],
            capture_output=True,
            text=True,
            check=False,
        )
    seconds = _children_time() - before
    if done.returncode:
        said = done.stderr.strip().splitlines() or [f"{done.returncode}"]
        return Result(case.key, seconds, problem=said[-1])
    (path,) = (
        path for path in out.glob("*.yaml") if path.stem not in _OTHER_FILES
    )
    robot = load_robot_description(path)
    drives = {drive: base for base, drive in DRIVES.items()}
    tried = _TRIED.search(done.stdout)
    home = re.search(r"^home +(.*?) *$", done.stdout, re.MULTILINE)
    return Result(
        key=case.key,
        seconds=seconds,
        tools=tuple(robot.effector_frames.values()),
        joints=tuple(robot.arm.joints),
        base=FIXED if robot.base is None else drives[robot.base.drive],
        tried=int(tried[1]) if tried else 0,
        home=home[1] if home else "",
    )


_OTHER_FILES = ("spheres", "scenario")
"""Stems of the files beside an imported robot's description."""


def _children_time() -> float:
    """Processor time of all processes that have been waited for [s]."""
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime
