"""Flags that several commands share, and their checks."""

import argparse
import time
from pathlib import Path

import numpy as np

from remosplat_drake.app.scenario import Scenario
from remosplat_drake.app.scenario_robot import robot_file
from remosplat_drake.base.errors import FieldError
from remosplat_drake.hardware.doctor.doctor_report import (
    check_doctor,
    default_path,
    needed_checks,
)
from remosplat_drake.recording.mcap.mcap_recorder import McapRecorder
from remosplat_drake.robot.robot_description import load_robot_description
from remosplat_drake.robot.robot_model import RobotModel

_LAST_PORT = 65535


def add_record_argument(parser: argparse.ArgumentParser) -> None:
    """Declares the flags `--record`, `--live` and `--rviz`."""
    parser.add_argument(
        "--record",
        type=Path,
        metavar="FILE.mcap",
        help=(
            "write every tick, and the images of a real camera, to an MCAP "
            "file for Foxglove"
        ),
    )
    parser.add_argument(
        "--live",
        type=int,
        metavar="PORT",
        help=(
            "with --record: also serve the recording live, so that Foxglove "
            "can connect to ws://127.0.0.1:PORT (default port 8765; extra "
            "`live`)"
        ),
    )
    parser.add_argument(
        "--rviz",
        action="store_true",
        help="with --record: publish target, clearances and state on ROS 2, as"
        " markers and a transform (extra `ros2`)",
    )


def opened_recorder(
    arguments: argparse.Namespace, scenario: Scenario, robot: RobotModel
) -> McapRecorder | None:
    """Starts the requested recording; returns None without `--record`.

    Args:
        arguments: The command line with the flags of
            `add_record_argument`, and `--hardware`.
        scenario: The scenario.
        robot: The robot that is recorded.

    Raises:
        RemoSplatError: The file cannot be created.
    """
    if arguments.live is not None:
        if arguments.record is None:
            raise FieldError("--live", str(arguments.live), "needs --record")
        if not 1 <= arguments.live <= _LAST_PORT:
            problem = f"must be a port, 1 to {_LAST_PORT}"
            raise FieldError("--live", str(arguments.live), problem)
    if arguments.rviz and arguments.record is None:
        raise FieldError("run", "--rviz", "needs --record")
    if arguments.record is None:
        return None
    has_camera = arguments.hardware and scenario.camera is not None
    return McapRecorder(
        arguments.record,
        robot,
        camera=scenario.hardware if has_camera else None,
        may_wait=not arguments.hardware,
        live=arguments.live,
        rviz=arguments.rviz,
    )


def add_doctor_arguments(parser: argparse.ArgumentParser) -> None:
    """Declares the flags about the report of `remosplat doctor`."""
    parser.add_argument(
        "--doctor",
        type=Path,
        metavar="FILE",
        help=(
            "report of `remosplat doctor` (default: the file that the "
            "doctor writes by default)"
        ),
    )
    parser.add_argument(
        "--without-doctor",
        action="store_true",
        help="drive a robot without a report of `remosplat doctor`",
    )


def check_report(arguments: argparse.Namespace, scenario: Scenario) -> None:
    """Refuses to drive a real robot without a valid report of the doctor.

    No report is needed for a rehearsal (the robot is simulated), for a shadow
    run (no robot moves), or with `--without-doctor`.

    Args:
        arguments: The command line with `--doctor`, `--without-doctor`,
            `--rehearsal` and `--shadow`.
        scenario: The scenario, with the LCM URL of the robot.

    Raises:
        RemoSplatError: There is no report, or it is invalid for this robot.
    """
    told = arguments.without_doctor or arguments.rehearsal or arguments.shadow
    if told:
        return
    description = load_robot_description(robot_file(scenario))
    check_doctor(
        arguments.doctor or default_path(),
        scenario.hardware.url,
        time.time(),
        needed_checks(description.base is not None),
    )


def check_positive(command: str, arguments: argparse.Namespace, *names: str):
    """Checks that the values of some flags, if given, are positive and finite.

    Raises:
        FieldError: A value is not positive or not finite; the error names the
            flag.
    """
    for name in names:
        value = getattr(arguments, name)
        if value is not None and not value > 0:
            raise FieldError(command, flag_name(name), "must be positive")
    check_finite(command, arguments, *names)


def check_finite(command: str, arguments: argparse.Namespace, *names: str):
    """Checks that the values of some flags, if given, are finite.

    Raises:
        FieldError: A flag contains NaN or infinity; the error names the flag.
    """
    for name in names:
        value = getattr(arguments, name)
        if value is not None and not np.isfinite(value).all():
            raise FieldError(command, flag_name(name), "must be finite")


def check_seed(command: str, arguments: argparse.Namespace):
    """Checks that the seed is valid for random generators.

    Raises:
        FieldError: The seed is negative.
    """
    if arguments.seed < 0:
        raise FieldError(command, "--seed", "must not be negative")


def flag_name(name: str) -> str:
    """Returns the flag that an attribute of the parsed arguments came from."""
    return "--" + name.replace("_", "-")
