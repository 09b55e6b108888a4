"""Runs ticks without Numba's compiler, each with one function replaced.

Prints a line for each: how the tick is run, what is replaced, and what the tick
has raised.
"""

import sys
from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np
import pytest
from asked_in_python import AskedInPython
from compiled_ingredients import Ceiling

from remosplat_drake.base import lanes
from remosplat_drake.controller.controller_config import default_ingredients
from remosplat_drake.controller.guidance.rollout import (
    Rollout,
    advance_rollout,
)
from remosplat_drake.controller.ingredients.kernels import assemble
from remosplat_drake.controller.prediction.history import History
from remosplat_drake.controller.prediction.predict import predict
from remosplat_drake.controller.program.guidance import Guidance
from remosplat_drake.controller.tick.kernels import settle
from remosplat_drake.controller.tick.reactive_law import ReactiveLaw
from remosplat_drake.controller.tick.run_tick import run_tick
from remosplat_drake.controller.verification.kernels import verified
from remosplat_drake.oracle.signed_distance import SignedDistanceField
from remosplat_drake.robot.actuators import Actuator, ActuatorModel
from remosplat_drake.robot.robot_model import load_robot
from remosplat_drake.robot.self_collision.kernels import support
from remosplat_drake.scene.primitive_scene import PrimitiveScene

PLAIN = {
    "greatest": np.maximum,
    "in_all": lambda x: np.full(lanes.WIDTH, x),
    "lanes_from": lambda array, at: array.ravel()[at : at + lanes.WIDTH],
    "least": np.minimum,
    "magnitude": np.abs,
    "root": np.sqrt,
    "where": np.where,
}
"""Functions of lanes, which only compiled code has, for arrays of numbers."""


def write_lanes(array, at, values):
    """Writes lanes into an array that is contiguous."""
    array.reshape(-1)[at : at + lanes.WIDTH] = values


def without_lanes() -> None:
    """Replaces the functions of lanes wherever they have been imported."""
    plain = {**PLAIN, "write_lanes": write_lanes}
    for name, module in list(sys.modules.items()):
        if name.startswith("remosplat_drake.") and module is not lanes:
            for function, other in plain.items():
                if hasattr(module, function) and getattr(
                    module, function
                ) is getattr(lanes, function):
                    setattr(module, function, other)


def highest(blocks, span, x, y, z):
    """Does without lanes, which only compiled code has."""
    heights = np.einsum("ick,c->ik", blocks[span[0] : span[1]], [x, y, z])
    block, place = np.unravel_index(heights.argmax(), heights.shape)
    return span[0] + block, place


support._highest = highest
without_lanes()

ROBOT = load_robot(Path(__file__).parents[1] / "data" / "three_link.yaml")
# Only compiled code can ask other maps along a path.
FIELD = AskedInPython(SignedDistanceField(PrimitiveScene().with_floor()))
Q, STILL = ROBOT.q_home, np.zeros(ROBOT.n_u)
X_WT = ROBOT.end_effector_pose(Q)
X_WT[2, 3] += 0.05


class Planted(Exception):
    """What a function raises instead of what it does."""


class Nothing:
    """An ingredient from outside that adds nothing."""

    def AddToProgram(self, program, tick) -> None:
        del program, tick


def tick(law: ReactiveLaw, motion=None) -> None:
    found = FIELD.clearances(ROBOT.spheres_at(Q), 0.5)
    run_tick(law, 0.0, Q, X_WT, found, FIELD, STILL, motion=motion)


def late_tick(law: ReactiveLaw) -> None:
    """As on hardware: what is commanded acts later."""
    model = ActuatorModel.make([Actuator(delay=0.03, tube=0.01)] * ROBOT.n_u)
    history = History.at_rest(ROBOT.n_u)
    tick(law, predict(ROBOT, model, history, Q, STILL, 0.0))


def rollout(law: ReactiveLaw) -> None:
    start = Rollout(Guidance(), Q, STILL)
    advance_rollout(law, start, FIELD, X_WT, lambda error: False, 99.0)


RUNS = {"tick": tick, "late tick": late_tick, "rollout": rollout}


def laws() -> dict[str, ReactiveLaw]:
    parts = default_ingredients(ROBOT)
    return {
        "active set": ReactiveLaw(ROBOT, parts, solver="active_set"),
        "Clarabel": ReactiveLaw(ROBOT, parts),
        "outside": ReactiveLaw(ROBOT, [*parts, Nothing()]),
        "compiled": ReactiveLaw(ROBOT, [*parts, Ceiling(1.2)]),
    }


def plants() -> Iterator[tuple[object, str, Callable]]:
    """Where something is replaced, its name there, and what takes its place."""
    adders = [add for _, add in assemble.KINDS]
    for k, kind in enumerate(assemble.PARTS):
        others = [*adders[:k], raising(kind.__name__), *adders[k + 1 :]]
        yield assemble, "add_all", assemble.in_turn(others)
    yield settle, "decide", raising("decision")
    yield settle, "verified", raising("verification")
    yield verified, "path_objection", raising("objections")


def main() -> None:
    for name, law in laws().items():
        for way, run in RUNS.items():
            print(f"{name}, {way}: {raised(run, law)}")
            for module, function, planted in plants():
                with pytest.MonkeyPatch.context() as patch:
                    patch.setattr(module, function, planted)
                    print(f"{name}, {way}: {raised(run, law)}")


def raising(name: str) -> Callable:
    def planted(*arguments):
        raise Planted(name)

    return planted


def raised(run: Callable, law: ReactiveLaw) -> str:
    """What a run raises: the name that is planted, or nothing."""
    try:
        run(law)
    except Planted as error:
        return str(error)
    return "nothing"


if __name__ == "__main__":
    main()
