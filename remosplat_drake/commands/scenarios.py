"""`remosplat scenarios`: what can be run."""

import argparse

from rich.console import Console
from rich.table import Table

from remosplat_drake.app.scenario import (
    DEFAULT_SCENARIO,
    load_scenario,
    shipped_scenarios,
)

EXAMPLES = """
remosplat scenarios
"""
"""What `--help` ends with."""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declares no flags: the command takes none."""
    del parser  # Unused.


def run(arguments: argparse.Namespace) -> int:
    """Prints a table with one row a shipped scenario."""
    del arguments  # Unused.
    table = Table("scenario", "oracle", "station", "spheres", "gains", "scene")
    for name in shipped_scenarios():
        scenario = load_scenario(name)
        table.add_row(
            name + (" (default)" if name == DEFAULT_SCENARIO else ""),
            type(scenario.oracle).__name__,
            type(scenario.station).__name__,
            scenario.robot.spheres,
            scenario.controller.gains,
            scenario.scene.splat.rpartition("models/scenes/")[2]
            or scenario.scene.truth,
        )
    Console().print(table)
    return 0
