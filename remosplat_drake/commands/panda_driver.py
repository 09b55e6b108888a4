"""`remosplat panda-driver`: between the station's wire and a real Panda."""

import argparse
import gc
import signal

from rich.console import Console

from remosplat_drake.drivers.clock import Pacer, wall_utime
from remosplat_drake.drivers.panda_driver import PandaDriver
from remosplat_drake.drivers.panda_limits import TICK
from remosplat_drake.drivers.panda_python_arm import PandaPythonArm
from remosplat_drake.drivers.wire import add_wire_argument, open_wire
from remosplat_drake.errors import RemoSplatError


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declares the command line."""
    parser.add_argument("host", help="name or address of the arm's controller")
    add_wire_argument(parser)


def run(arguments: argparse.Namespace) -> int:
    """Drives the arm until Ctrl-C, which ramps it down first."""
    lcm = open_wire(arguments.lcm_url)
    arm = PandaPythonArm(arguments.host)
    driver = PandaDriver(lcm, arm)
    pacer = Pacer(TICK)
    signal.signal(signal.SIGTERM, signal.default_int_handler)
    Console(stderr=True).print(
        f"{arguments.lcm_url} <-> {arguments.host}; Ctrl-C ends"
    )
    gc.collect()
    gc.freeze()
    try:
        while True:
            pacer.wait()
            driver.step(wall_utime())
            problem = arm.problem()
            if problem:
                raise RemoSplatError(f"the arm has stopped: {problem}")
    except KeyboardInterrupt:
        return 0
    finally:
        while not driver.brake():
            pacer.wait()
        arm.close()
