"""Runs ticks without Numba's compiler, each with one ingredient replaced.

Prints a line for each: what the tick's law is, and what the tick has raised.
"""

import sys

import numpy as np
import pytest

from remosplat_drake.controller.controller_config import default_ingredients
from remosplat_drake.controller.kernels import assemble
from remosplat_drake.controller.reactive_law import ReactiveLaw
from remosplat_drake.controller.run_tick import run_tick
from remosplat_drake.oracle.signed_distance import SignedDistanceField
from remosplat_drake.robot.robot_model import load_robot
from remosplat_drake.scene.primitive_scene import PrimitiveScene


class Planted(Exception):
    """What an ingredient's function raises instead of adding its terms."""


class Nothing:
    """An ingredient from outside that adds nothing."""

    def AddToProgram(self, program, tick) -> None:
        del program, tick


def main() -> None:
    robot = load_robot("frankie")
    parts = default_ingredients(robot)
    # Only compiled code can ask the map along a path, as verification does.
    laws = {
        "in one call": ReactiveLaw(
            robot, parts, solver="active_set", verify=False
        ),
        "by steps": ReactiveLaw(robot, parts, verify=False),
        "with one from outside": ReactiveLaw(
            robot, [*parts, Nothing()], verify=False
        ),
    }
    for name, law in laws.items():
        print(f"{name}: {raised(law)}")
        for kind in assemble.PARTS:
            function = function_of(kind)
            with pytest.MonkeyPatch.context() as patch:
                patch.setattr(assemble, function.__name__, planted(kind))
                print(f"{name}: {raised(law)}")


def function_of(kind: type):
    """The function that adds the terms of a kind of ingredients."""
    module = sys.modules[kind.__module__]
    (function,) = (
        value
        for name, value in vars(module).items()
        if name[:4] == "add_" and value.__module__ == module.__name__
    )
    return function


def planted(kind: type):
    def add(own, k, tick, program) -> None:
        raise Planted(kind.__name__)

    return add


def raised(law: ReactiveLaw) -> str:
    """What a tick raises: the name that is planted, or nothing."""
    robot = law.robot
    field = SignedDistanceField(PrimitiveScene().with_floor())
    q = np.array([0.0, 0.0, 0.0, *robot.home])
    X_WT = robot.end_effector_pose(q)
    X_WT[0, 3] += 0.2
    clearances = field.clearances(robot.spheres_at(q), 0.5)
    try:
        run_tick(law, 0.0, q, X_WT, clearances, field, np.zeros(robot.n_u))
    except Planted as error:
        return str(error)
    return "nothing"


if __name__ == "__main__":
    main()
