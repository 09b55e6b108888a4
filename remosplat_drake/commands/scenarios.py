"""`remosplat scenarios`: lists the scenarios that can be run."""

import argparse
from pathlib import PurePosixPath

from remosplat_drake.app.scenario import (
    DEFAULT_SCENARIO,
    Scenario,
    load_scenario,
    shipped_scenarios,
)
from remosplat_drake.base.table import Table
from remosplat_drake.commands.json_output import add_json_argument, print_json
from remosplat_drake.commands.tables import open_console, print_table

EXAMPLES = """
remosplat scenarios
remosplat scenarios --json
"""
"""Examples at the end of `--help`."""

_IN_WORDS = {
    "SphereToEllipsoid": "ellipsoids",
    "DepthRasterization": "depth views",
    "GroundTruth": "ground truth",
    "KinematicStation": "kinematic",
    "DynamicStation": "dynamic",
}
"""For each of the package's oracles and stations, its name in the table."""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declares the command's flags."""
    add_json_argument(parser)


def run(arguments: argparse.Namespace) -> int:
    """Prints a table with one row per shipped scenario."""
    found = {name: load_scenario(name) for name in shipped_scenarios()}
    if arguments.json:
        print_json(
            {
                "default": DEFAULT_SCENARIO,
                "scenarios": [
                    _entry(name, scenario) for name, scenario in found.items()
                ],
            }
        )
        return 0
    header = ("scenario", "robot", "scene", "oracle", "station", "spheres")
    rows = [_row(name, scenario) for name, scenario in found.items()]
    table = Table(
        "",
        (*header, "gains"),
        tuple(rows),
        f"Without a name, `remosplat run` drives {DEFAULT_SCENARIO}.",
        texts=len(header) + 1,
    )
    print_table(open_console(), table)
    return 0


def _row(name: str, scenario: Scenario) -> tuple[str, ...]:
    kinds = (type(x).__name__ for x in (scenario.oracle, scenario.station))
    return (
        name,
        scenario.robot.model,
        PurePosixPath(_map_file(scenario)).parent.name,
        *(_IN_WORDS.get(kind, kind) for kind in kinds),
        scenario.robot.spheres,
        scenario.controller.gains,
    )


def _map_file(scenario: Scenario) -> str:
    return scenario.scene.splat or scenario.scene.truth


def _entry(name: str, scenario: Scenario) -> dict:
    """Makes the entry of `--json` about a scenario."""
    scene = scenario.scene
    return {
        "name": name,
        "file": scenario.source.rpartition(":")[0],
        "robot": scenario.robot.model,
        "spheres": scenario.robot.spheres,
        "gains": scenario.controller.gains,
        "splat": scene.splat or None,
        "truth": scene.truth or None,
        "oracle": type(scenario.oracle).__name__,
        "station": type(scenario.station).__name__,
        "control_period": scenario.control_period,
        "time_limit": scenario.time_limit,
    }
