"""The `remosplat` console script: finds the command and reports errors."""

import argparse
import importlib
import logging
import sys
from collections.abc import Callable, Sequence

from remosplat_drake.base.errors import RemoSplatError
from remosplat_drake.base.kernel_cache import drop_stale_kernels
from remosplat_drake.base.reading import UnreadableError
from remosplat_drake.base.system_libraries import libraries_named
from remosplat_drake.base.version import __version__
from remosplat_drake.commands.interrupts import interrupts_deferred
from remosplat_drake.commands.unexpected import one_line, report

COMMANDS = {
    "run": "drive the robot of a scenario to its targets",
    "replay": "play a recorded session again",
    "teleop": "move the target by hand while the map grows",
    "scenarios": "list the shipped scenarios",
    "doctor": "check robot, wire and computer before the robot moves",
    "hardware-sim": "stand in for the real robot, behind the same wire",
    "camera-sim": "stand in for the real robot's wrist camera",
    "camera-driver": "send the images of a RealSense camera",
    "calibrate-hand-eye": "find where the camera sits on the robot",
    "base-driver": "drive a mobile base that speaks ROS",
    "panda-driver": "drive a Panda through panda-python",
    "arm": "let a real robot go that waits for an operator",
    "identify": "measure how the axes of the real robot follow commands",
    "inspect": "show what a sphere's depth views see",
    "benchmark": "compare controllers in many scenes, as the paper does",
    "bench": "time the oracle and the control tick on this machine",
    "fit-spheres": "cover a robot's links with spheres",
    "fit-hulls": "cut a robot's meshes into convex collision shapes",
    "render-capture": "render RGB-D views of a scene, a model or a mesh",
    "capture-info": "describe an RGB-D capture and check it",
    "reconstruct": "make a splat from an RGB-D capture",
    "quality": "measure how far a splat can be trusted",
    "convert": "turn a splat from one format of file into another",
}
"""Commands by name; each one's module is loaded only when it is called."""

USER_ERROR = 2


def main(argv: Sequence[str] | None = None) -> int:
    """Runs one command and returns its exit code, as `exit_code` has it."""
    argv = list(sys.argv[1:] if argv is None else argv)

    def run() -> int:
        parser = _make_parser(argv[0] if argv else None)
        arguments = parser.parse_args(argv)
        return arguments.run(arguments)

    return exit_code(run)


def exit_code(run: Callable[[], int]) -> int:
    """Calls what reads and runs a command line, and returns its exit code.

    Returns:
        0: done. 1: the robot did not get there. 2: the user can correct it, and
        one line on stderr says how; or a reader failed at a file unexpectedly,
        and the line names the log of its traceback. 130: interrupted. Any other
        exception is a defect and leaves its traceback.
    """
    # Drake announces its server; the commands say so in their own words.
    logging.getLogger("drake").setLevel(logging.WARNING)
    try:
        drop_stale_kernels()
        return run()
    except RemoSplatError as error:
        print(f"remosplat: {one_line(error)}", file=sys.stderr)
        return USER_ERROR
    except UnreadableError as error:
        report(error)
        return USER_ERROR
    except MemoryError as error:
        what = f": {one_line(error)}" if str(error) else ""
        print(f"remosplat: not enough memory{what}", file=sys.stderr)
        return USER_ERROR
    except KeyboardInterrupt:
        print("remosplat: interrupted", file=sys.stderr)
        return 130


def _make_parser(chosen: str | None) -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog="remosplat",
        description="Reactive mobile manipulation on Gaussian splats.",
    )
    parser.add_argument("--version", action="version", version=__version__)
    commands = parser.add_subparsers(
        title="commands", metavar="COMMAND", required=True
    )
    for name, summary in COMMANDS.items():
        command = commands.add_parser(name, help=summary, description=summary)
        if name == chosen:
            with interrupts_deferred(), libraries_named("Drake"):
                module = importlib.import_module(
                    f"remosplat_drake.commands.{name.replace('-', '_')}"
                )
            module.add_arguments(command)
            command.set_defaults(run=module.run)
    return parser
