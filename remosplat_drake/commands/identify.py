"""`remosplat identify`: measures the response of a real robot's axes."""

import argparse
import dataclasses as dc
import time
from pathlib import Path

import numpy as np
from rich.console import Console

from remosplat_drake.app.compiling import compiling_shown
from remosplat_drake.app.diagram import Application
from remosplat_drake.app.identification.excitation import (
    CRAWLS,
    commands,
    find_stroke,
)
from remosplat_drake.app.identification.fit import Fit, fit_axis
from remosplat_drake.app.identification.reading import (
    await_robot,
    recording_of,
)
from remosplat_drake.app.identification.record import write_actuators
from remosplat_drake.app.identification.room import NoRoomError, Room
from remosplat_drake.app.map_knowledge import examine_map
from remosplat_drake.app.scenario import load_scenario
from remosplat_drake.app.velocity_run import (
    HeldBackError,
    LateError,
    Played,
    build_velocity_run,
    play,
)
from remosplat_drake.app.warm_up import compile_kernels
from remosplat_drake.app.world import load_world
from remosplat_drake.base.atomic_file import check_writable
from remosplat_drake.base.errors import FieldError, RemoSplatError
from remosplat_drake.base.progress import Progress
from remosplat_drake.base.table import Table
from remosplat_drake.commands.gate_keeping import (
    add_accept_argument,
    admit,
    check_accepted,
)
from remosplat_drake.commands.number_flags import positive
from remosplat_drake.commands.tables import open_console, print_table
from remosplat_drake.commands.wire import add_robot_choice, prepare_robot
from remosplat_drake.controller.verification.self_sweep import SelfClearance
from remosplat_drake.hardware.client.hardware_station import HardwareStation
from remosplat_drake.hardware.wire.base import base_axes
from remosplat_drake.robot.actuators import Actuator

_INCOMPLETE = 1

_TRIES = 5
"""Each axis is measured in at most this many attempts. An attempt fails if a
message is late."""

EXAMPLES = """
remosplat identify kitchen.yaml
remosplat identify kitchen.yaml --axes 0,1 --fraction 0.5
remosplat identify TableReach --rehearsal
"""
"""Examples at the end of `--help`."""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declares the command's flags."""
    parser.add_argument(
        "scenario",
        nargs="?",
        help=(
            "NAME, FILE or FILE:NAME (see `remosplat scenarios`): scenario "
            "that contains the robot and the map of its surroundings"
        ),
    )
    parser.add_argument(
        "--scenario-text",
        default="",
        metavar="YAML",
        help=(
            "YAML of fields that override the scenario's, as in `remosplat run`"
        ),
    )
    add_robot_choice(parser)
    parser.set_defaults(hardware=True, shadow=False)
    add_accept_argument(parser)
    parser.add_argument(
        "--clearance",
        type=positive,
        default=0.1,
        metavar="M",
        help="distance that the robot keeps from the scene (default:"
        " %(default)s)",
    )
    parser.add_argument(
        "--fraction",
        type=positive,
        default=1.0,
        metavar="F",
        help=(
            "speed of the motions, as a fraction of the robot's speed "
            "limits, at most 1 (default: %(default)s)"
        ),
    )
    parser.add_argument(
        "--axes",
        metavar="I,J",
        help="indices of the axes to measure, in the order of the command u "
        "(default: all)",
    )
    parser.add_argument(
        "--output",
        type=Path,
        metavar="FILE",
        help=(
            "robot description file to which the result is written (default: "
            "the scenario's)"
        ),
    )
    parser.add_argument(
        "--yes", action="store_true", help="move without confirmation"
    )


def run(arguments: argparse.Namespace) -> int:
    """Moves the axes one by one, fits a model of each, and writes them."""
    if arguments.fraction > 1.0:
        raise FieldError("identify", "--fraction", "must be at most 1")
    console = open_console(stderr=True)
    check_accepted(arguments)
    scenario = load_scenario(arguments.scenario, arguments.scenario_text)
    prepare_robot(arguments, scenario, console)
    with (
        Progress(console) as progress,
        compiling_shown(progress, scenario),
    ):
        world = load_world(scenario)
        knowledge = examine_map(scenario, world, {})
        admission = admit(knowledge, arguments, scenario.source)
        compile_kernels(scenario, world, plans=False)
    admission.announce(console)
    robot = world.robot
    known = robot.assumed_actuators
    own = SelfClearance.make(robot, scenario.controller.self_collision.stopping)
    room = Room(world.field, own, arguments.clearance, scenario.control_period)
    path = arguments.output or Path(robot.description.source)
    check_writable(path)
    axes = _axes(arguments.axes, robot.n_u)
    limit = arguments.fraction * robot.velocity_limit
    if robot.n_base:
        hardware = scenario.hardware
        axes_B = base_axes(robot.n_base)
        slowest = np.minimum(*np.abs(hardware.base_bounds))[axes_B]
        limit[: robot.n_base] = np.minimum(limit[: robot.n_base], slowest)
    if not (arguments.yes or _agrees(console, len(axes))):
        raise RemoSplatError(
            "identify: no person confirmed the motion, so nothing has moved; "
            "type 'move' at the terminal, or use --yes"
        )
    application = build_velocity_run(scenario, world)
    fits: dict[int, Fit] = {}
    for axis in axes:
        try:
            fits[axis] = _identified(axis, limit, application, room)
        except NoRoomError as error:
            console.print(
                f"axis {axis}: not measured, since there is not enough free "
                f"space ({error})"
            )
    print_table(console, fit_table(fits))
    for axis, fit in fits.items():
        known[axis] = fit.actuator
    base = [("forward", "left", "yaw")[i] for i in base_axes(robot.n_base)]
    names = [*base, *robot.description.arm.joints]
    kept = write_actuators(path, known, names, time.strftime("%Y-%m-%d"))
    console.print(f"wrote {path}; the previous file is kept as {kept}")
    return _INCOMPLETE if len(fits) < len(axes) else 0


def _axes(text: str | None, n: int) -> list[int]:
    if text is None:
        return list(range(n))
    try:
        axes = [int(part) for part in text.split(",")]
    except ValueError:
        axes = []
    if not axes or not all(0 <= axis < n for axis in axes):
        raise RemoSplatError(
            f"--axes: {text}: expected numbers from 0 to {n - 1}, as 0,3"
        )
    return axes


def _agrees(console: Console, n: int) -> bool:
    console.print(
        f"{n} axes will move, one after the other, forth and back, at up to "
        "full speed. A person must stay at the emergency stop."
    )
    try:
        return console.input("Type 'move' to begin: ").strip() == "move"
    except EOFError:
        return False


def _identified(
    axis: int, limit: np.ndarray, application: Application, room: Room
) -> Fit:
    """Moves one axis, and fits the model of its response.

    Raises:
        NoRoomError: There is not enough free space for the motion.
        RemoSplatError: The robot stopped, or messages were late too often.
    """
    robot = room.own.robot
    ticks = _strokes(axis, limit, application, room)
    crawls = [share * limit[axis] for share in CRAWLS]
    return fit_axis(
        recording_of(ticks, robot),
        axis,
        float(robot.acceleration_limit[axis]),
        crawls,
    )


def _strokes(
    axis: int, limit: np.ndarray, application: Application, room: Room
) -> list[Played]:
    """Moves one axis; repeats it more slowly if verification slowed it."""
    robot, hardware = room.own.robot, application.scenario.hardware
    assert isinstance(application.station, HardwareStation)
    late, fastest = 0, 1.0
    while True:
        # After a failed attempt, the motion starts from the position at which
        # the axis stopped.
        reading = await_robot(application.station.link, robot, hardware)
        about = room.about(reading)
        stroke = find_stroke(about, reading.q_W, axis, limit, fastest)
        try:
            return play(application, commands(stroke, robot, limit, room.dt))
        except HeldBackError:
            fastest = float(0.5 * abs(stroke.speed) / limit[axis])
        except LateError as error:
            late += 1
            if late == _TRIES:
                raise RemoSplatError(
                    f"identify: axis {axis}: {error}, in {_TRIES} attempts; "
                    "end other programs on this computer, and repeat"
                ) from error
        except RemoSplatError as error:
            raise RemoSplatError(f"identify: axis {axis}: {error}") from error


def fit_table(fits: dict[int, Fit]) -> Table:
    """Makes a table with one row per axis."""
    header = ("axis", "delay [ms]", "lag [ms]", "ramp", "dead band")
    return Table(
        "",
        (*header, "tube [ms]", "largest residual"),
        tuple(
            (str(axis), *_cells(fit.actuator), f"{fit.residual:.4f}")
            for axis, fit in fits.items()
        ),
    )


def _cells(actuator: Actuator) -> list[str]:
    values = dc.asdict(actuator)
    ramp = values["acceleration"]
    return [
        f"{1e3 * values['delay']:.0f}",
        f"{1e3 * values['time_constant']:.0f}",
        "–" if ramp is None else f"{ramp:.2f}",
        f"{values['dead_band']:.4f}",
        f"{1e3 * values['tube']:.1f}",
    ]
