"""The stand-in with MuJoCo's dynamics, and the fault campaign with it.

`sim` takes the arguments of `remosplat hardware-sim`. `faults` runs the cases
of `remosplat bench faults` with it. Both need the package mujoco, version 3.
"""

import argparse
import sys
from collections.abc import Sequence

from apps.studies.command_line import output_file, study_main
from apps.studies.mujoco_robot.mujoco_plant import MujocoPlant
from remosplat_drake.commands import hardware_sim
from remosplat_drake.commands.bench_hardware import run_faults
from remosplat_drake.commands.tables import open_console

STAND_IN = (sys.executable, "-m", "apps.studies.mujoco_robot", "sim")
"""Command line of this stand-in, without arguments."""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declares the study's flags."""
    programs = parser.add_subparsers(dest="program", required=True)
    hardware_sim.add_arguments(
        programs.add_parser("sim", help="simulate the robot")
    )
    faults = programs.add_parser("faults", help="run the fault campaign")
    faults.add_argument(
        "--case",
        metavar="TEXT",
        default="",
        help="only faults whose names contain this text",
    )
    faults.add_argument(
        "--json",
        type=output_file,
        metavar="FILE",
        help="also write the results to FILE, after each fault",
    )


def run(arguments: argparse.Namespace) -> int:
    """Runs one of the two programs."""
    if arguments.program == "sim":
        return hardware_sim.run(arguments, MujocoPlant)
    results = run_faults(
        open_console(), arguments.case, STAND_IN, arguments.json
    )
    return 1 if any(result.problem for result in results) else 0


def main(argv: Sequence[str] | None = None) -> int:
    """Runs the study from its command line; returns the exit code."""
    return study_main("mujoco_robot", __doc__, add_arguments, run, argv)


if __name__ == "__main__":
    sys.exit(main())
