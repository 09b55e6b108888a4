"""Reactive mobile manipulation on Gaussian splats, as a Drake diagram.

The names below are the library; each is loaded when it is first used, so that
importing the package costs next to nothing.

    import remosplat_drake as rs

    robot = rs.load_robot("frankie")
    field = rs.SphereToEllipsoid().make(rs.read_splat("kitchen.ply"))
    print(field.clearances(robot.spheres_at(q)).minimum())

Lengths are metres, angles radians, times seconds. Poses and points carry their
frames in Drake's monogram notation: `X_WT` is the pose of T in W.
"""

import importlib
from typing import TYPE_CHECKING, Any

from remosplat_drake.base.version import __version__ as __version__

if TYPE_CHECKING:
    from remosplat_drake.app.diagram import Application as Application
    from remosplat_drake.app.diagram import build as build
    from remosplat_drake.app.scenario import Scenario as Scenario
    from remosplat_drake.app.scenario import load_scenario as load_scenario
    from remosplat_drake.app.simulation import run as run
    from remosplat_drake.base.errors import RemoSplatError as RemoSplatError
    from remosplat_drake.base.ranges import Config as Config
    from remosplat_drake.controller.controller_config import (
        default_ingredients as default_ingredients,
    )
    from remosplat_drake.controller.guidance.guidance_selector import (
        GuidanceSelector as GuidanceSelector,
    )
    from remosplat_drake.controller.program.compiled_ingredient import (
        CompiledIngredient as CompiledIngredient,
    )
    from remosplat_drake.controller.program.ingredient import (
        Ingredient as Ingredient,
    )
    from remosplat_drake.controller.program.kernels.tick_arrays import (
        new_row as new_row,
    )
    from remosplat_drake.controller.program.reactive_program import (
        ReactiveProgram as ReactiveProgram,
    )
    from remosplat_drake.controller.program.tick import Tick as Tick
    from remosplat_drake.controller.reactive_controller import (
        ReactiveController as ReactiveController,
    )
    from remosplat_drake.controller.tick.reactive_law import (
        ReactiveLaw as ReactiveLaw,
    )
    from remosplat_drake.oracle.distance_oracle import (
        DistanceOracle as DistanceOracle,
    )
    from remosplat_drake.oracle.oracle_config import (
        DepthRasterization as DepthRasterization,
    )
    from remosplat_drake.oracle.oracle_config import GroundTruth as GroundTruth
    from remosplat_drake.oracle.oracle_config import (
        SphereToEllipsoid as SphereToEllipsoid,
    )
    from remosplat_drake.robot.robot_arrays import add_rate as add_rate
    from remosplat_drake.robot.robot_model import RobotModel as RobotModel
    from remosplat_drake.robot.robot_model import load_robot as load_robot
    from remosplat_drake.safety.supervisor_system import (
        SafetySupervisor as SafetySupervisor,
    )
    from remosplat_drake.scene.rmmi import read_scene as read_scene
    from remosplat_drake.signals.distance_field import Clearances as Clearances
    from remosplat_drake.signals.distance_field import (
        DistanceField as DistanceField,
    )
    from remosplat_drake.signals.target import Target as Target
    from remosplat_drake.splat.formats import read_splat as read_splat
    from remosplat_drake.splat.gaussian_splat import (
        GaussianSplat as GaussianSplat,
    )
    from remosplat_drake.task.target_sequence import (
        TargetSequence as TargetSequence,
    )
    from remosplat_drake.visualization.page import MeshcatPage as MeshcatPage
    from remosplat_drake.visualization.views import AddViews as AddViews

_MODULES = {
    # The robot, the map and the distance between them.
    "load_robot": "robot.robot_model",
    "RobotModel": "robot.robot_model",
    "read_splat": "splat.formats",
    "GaussianSplat": "splat.gaussian_splat",
    "read_scene": "scene.rmmi",
    "DistanceField": "signals.distance_field",
    "Clearances": "signals.distance_field",
    "SphereToEllipsoid": "oracle.oracle_config",
    "DepthRasterization": "oracle.oracle_config",
    "GroundTruth": "oracle.oracle_config",
    # The control law and what it is made of.
    "ReactiveLaw": "controller.tick.reactive_law",
    "default_ingredients": "controller.controller_config",
    "Ingredient": "controller.program.ingredient",
    "CompiledIngredient": "controller.program.compiled_ingredient",
    "new_row": "controller.program.kernels.tick_arrays",
    "add_rate": "robot.robot_arrays",
    "Tick": "controller.program.tick",
    "ReactiveProgram": "controller.program.reactive_program",
    # Systems for diagrams of one's own.
    "DistanceOracle": "oracle.distance_oracle",
    "ReactiveController": "controller.reactive_controller",
    "GuidanceSelector": "controller.guidance.guidance_selector",
    "SafetySupervisor": "safety.supervisor_system",
    "TargetSequence": "task.target_sequence",
    "Target": "signals.target",
    "MeshcatPage": "visualization.page",
    "AddViews": "visualization.views",
    # The application.
    "Scenario": "app.scenario",
    "load_scenario": "app.scenario",
    "Application": "app.diagram",
    "build": "app.diagram",
    "run": "app.simulation",
    # What every extension needs.
    "Config": "base.ranges",
    "RemoSplatError": "base.errors",
}
"""The module that defines each public name."""

__all__ = [*_MODULES, "__version__"]  # pyright: ignore


def __getattr__(name: str) -> Any:
    if name not in _MODULES:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    module = importlib.import_module(f"{__name__}.{_MODULES[name]}")
    value = globals()[name] = getattr(module, name)
    return value


def __dir__() -> list[str]:
    return sorted({*globals(), *_MODULES})
