"""`remosplat hardware-sim`: simulates the real robot and its LCM drivers."""

import argparse
import gc
import math
from pathlib import Path

from pydrake.lcm import DrakeLcm

from remosplat_drake.app.scenario import Scenario, load_scenario
from remosplat_drake.app.world import World, load_world
from remosplat_drake.base.atomic_file import check_writable
from remosplat_drake.base.clock import Pacer
from remosplat_drake.base.errors import FieldError
from remosplat_drake.base.real_time import DRIVER_PRIORITY, realtime_priority
from remosplat_drake.base.stop_signals import stop_signals
from remosplat_drake.commands.number_flags import positive
from remosplat_drake.commands.tables import open_console
from remosplat_drake.commands.wire import (
    add_wire_argument,
    leased_inbox,
    open_wire,
)
from remosplat_drake.hardware.drivers.panda_commands import JOINTS
from remosplat_drake.hardware.drivers.panda_limits import TICK
from remosplat_drake.hardware.hardware_config import REHEARSAL_URL
from remosplat_drake.hardware.stand_in.faults import (
    CHANNEL,
    FAULTS,
    parse_fault,
)
from remosplat_drake.hardware.stand_in.fci_arm import FciArm
from remosplat_drake.hardware.stand_in.hardware_sim import (
    HardwareSim,
    commanded,
)
from remosplat_drake.hardware.stand_in.robot_plant import PERIOD, RobotPlant
from remosplat_drake.hardware.stand_in.ros2_robot import Ros2Robot
from remosplat_drake.hardware.stand_in.rtde_arm import RtdeArm
from remosplat_drake.hardware.stand_in.true_motion import TrueMotion
from remosplat_drake.hardware.stand_in.ur_rules import JOINTS as UR_JOINTS
from remosplat_drake.station.station_config import DynamicStation

_PATIENCE = 0.1
"""If the computer stalls for at most this time, the simulated robot catches up
[s], since a real robot would have continued. Otherwise the supervisor would
find that the robot does not move as its actuator model predicts. After a longer
stall, catching up would take so long that statuses would be stale for much
longer than the stall."""

_FCI_PATIENCE = 0.002
"""Value that replaces `_PATIENCE` if a driver must answer each millisecond [s].
It is short, since the driver cannot answer during a stall."""

EXAMPLES = """
remosplat hardware-sim TableReach
remosplat hardware-sim TableReach --fci 20000
"""
"""Examples at the end of `--help`."""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declares the command's flags."""
    parser.add_argument(
        "scenario",
        nargs="?",
        help=(
            "NAME, FILE or FILE:NAME (see `remosplat scenarios`): scenario "
            "with the robot, its start and the obstacles"
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
    add_wire_argument(parser, REHEARSAL_URL)
    parser.add_argument(
        "--realtime-rate",
        type=positive,
        default=1.0,
        metavar="R",
        help="simulated seconds per second of the wall clock (default: 1)",
    )
    parser.add_argument(
        "--time-limit",
        type=float,
        default=math.inf,
        metavar="S",
        help="end after this simulated time [s] (default: at Ctrl-C)",
    )
    parser.add_argument(
        "--fault",
        action="append",
        default=[],
        metavar="NAME[=VALUE]@START[+DURATION]",
        help=(
            "inject a fault START seconds after the first command; may be "
            f"repeated; one of {', '.join(FAULTS)}"
        ),
    )
    parser.add_argument(
        "--fci",
        type=int,
        metavar="PORT",
        help=(
            "receive the arm's commands from `remosplat panda-driver "
            "--simulated PORT` instead of LCM"
        ),
    )
    parser.add_argument(
        "--rtde",
        metavar="ADDRESS",
        help=(
            "receive the commands of a Universal Robots arm from `remosplat "
            "arm-driver ur ADDRESS` instead of LCM; ADDRESS is an address of "
            "this computer, such as 127.0.0.2"
        ),
    )
    parser.add_argument(
        "--ros2",
        action="store_true",
        help=(
            "simulate a robot on ROS 2 instead of one on LCM, with the "
            "topics of the scenario's !Ros2Arm and !Ros2Base, for "
            "`arm-driver` and `base-driver`"
        ),
    )
    parser.add_argument(
        "--localization",
        action="store_true",
        help=(
            "also send the base's pose from a simulated localisation, 10 "
            "times a second. The origin of the odometry then differs from "
            "that of the localisation"
        ),
    )
    parser.add_argument(
        "--record",
        type=Path,
        metavar="FILE",
        help="at the end, write the robot's true motion to this file (.npz)",
    )


def run(
    arguments: argparse.Namespace, plant_type: type[RobotPlant] = RobotPlant
) -> int:
    """Simulates the robot until Ctrl-C or the time limit.

    Args:
        arguments: The command's arguments.
        plant_type: Class of the simulated robot, which integrates its
            rigid-body motion.
    """
    console = open_console(stderr=True)
    schedule = [parse_fault(text) for text in arguments.fault]
    if arguments.record:
        check_writable(arguments.record)
    scenario = load_scenario(arguments.scenario, arguments.scenario_text)
    world = load_world(scenario, blank=True)
    plant = _plant(plant_type, scenario, world)
    driver = _arm_driver(arguments, world)
    description, ros, url = world.robot.description, None, arguments.lcm_url
    if arguments.ros2:
        lcm, inbox, url = DrakeLcm("memq://"), None, "ROS 2"
        ros = Ros2Robot(
            lcm,
            scenario.hardware,
            description,
            lambda news: console.print(f"hardware-sim: {news}", markup=False),
        )
    else:
        lcm = open_wire(url)
        inbox = leased_inbox(
            lcm,
            commanded(description, driver is not None),
            "hardware-sim",
            console,
            open_channels=[CHANNEL],
        )
    robot = HardwareSim(
        plant,
        lcm,
        schedule,
        actuators=description.actuators,
        fci=driver,
        localizes=arguments.localization,
        status_rate=scenario.hardware.arm_status_rate,
        inbox=inbox,
    )
    motion = TrueMotion(plant) if arguments.record else None
    patience = _PATIENCE if arguments.fci is None else _FCI_PATIENCE
    pacer = Pacer(TICK / arguments.realtime_rate, patience)
    console.print(f"the robot is on {url}; Ctrl-C ends")
    # All present objects are excluded from garbage collection, which would
    # otherwise last several ticks.
    gc.collect()
    gc.freeze()
    with realtime_priority(DRIVER_PRIORITY), stop_signals() as request:
        try:
            while not request.made and robot.time < arguments.time_limit:
                pacer.wait()
                robot.step(pacer.late)
                if ros is not None:
                    ros.step()
                if motion is not None:
                    motion.sample(robot.time)
        finally:
            request.has_ended = True
            if motion is not None:
                motion.save(arguments.record)
    console.print(
        f"{robot.time:.1f} s at {pacer.rate:.0f} Hz, {pacer.missed} ticks "
        f"missed, the most delayed tick {1e3 * pacer.worst:.1f} ms late"
    )
    commands = robot.arm.commands
    console.print(
        f"commands to the arm: {commands.received}, timeouts:"
        f" {commands.expired}, unusable commands: {commands.broken}"
        + (f" ({commands.complaint})" if commands.broken else "")
    )
    return 0


def _arm_driver(
    arguments: argparse.Namespace, world: World
) -> FciArm | RtdeArm | None:
    """Returns the interface that receives the arm's commands; None for LCM."""
    joints = len(world.robot.home)
    if arguments.ros2 and (arguments.fci is not None or arguments.rtde):
        problem = (
            "the arm receives its commands by ROS 2; leave out --fci and --rtde"
        )
        raise FieldError("hardware-sim", "--ros2", problem)
    for flag, has, arm in (
        ("--fci", arguments.fci, JOINTS),
        ("--rtde", arguments.rtde, UR_JOINTS),
    ):
        if has is not None and joints != arm:
            name = world.robot.description.name
            problem = f"is for an arm of {arm} joints, {name} has {joints}"
            raise FieldError("hardware-sim", flag, problem)
    if arguments.rtde is not None:
        return RtdeArm(arguments.rtde)
    return None if arguments.fci is None else FciArm(arguments.fci)


def _plant(
    plant_type: type[RobotPlant], scenario: Scenario, world: World
) -> RobotPlant:
    config = scenario.station
    if not isinstance(config, DynamicStation):
        config = DynamicStation(time_step=PERIOD)
    return plant_type(
        config, world.robot, world.fixed_truth, world.q0, world.objects
    )
