"""Reads objects from Drake's model directives as solid primitives.

Drake's scenario files have the same directives: `add_model`, `add_weld` and so
on. They are parsed in a separate plant; only the collision shapes and their
poses in W are kept.
"""

import copy
from collections.abc import Sequence
from pathlib import Path

from pydrake.geometry import Box as DrakeBox
from pydrake.geometry import Cylinder as DrakeCylinder
from pydrake.geometry import SceneGraphInspector, Shape
from pydrake.math import RigidTransform
from pydrake.multibody.parsing import (
    ModelDirective,
    ModelDirectives,
    Parser,
    ProcessModelDirectives,
)
from pydrake.multibody.plant import AddMultibodyPlantSceneGraph, MultibodyPlant
from pydrake.multibody.tree import BodyIndex, RigidBody
from pydrake.systems.framework import DiagramBuilder

from remosplat_drake.base.errors import RemoSplatError
from remosplat_drake.base.resources import models_dir, resolve
from remosplat_drake.scene.primitive_scene import Box, Cylinder, PrimitiveScene


def read_directives(
    directives: Sequence[ModelDirective], folder: Path
) -> PrimitiveScene:
    """Returns the boxes and cylinders of the models that directives add.

    Args:
        directives: The directives, in order.
        folder: Base folder of relative file names.

    Raises:
        RemoSplatError: Drake rejects a directive or a file, or a model has
            shapes other than boxes and cylinders, has none, or is not fixed to
            the world.
    """
    if not directives:
        return PrimitiveScene()
    builder = DiagramBuilder()
    plant, scene_graph = AddMultibodyPlantSceneGraph(builder, 0.0)
    parser = Parser(plant)
    parser.package_map().Add("remosplat_drake", str(models_dir().parent))
    found = ModelDirectives()
    found.directives = with_absolute_files(directives, folder)
    try:
        ProcessModelDirectives(found, parser)
        plant.Finalize()
    # Drake's assertions, for example about an invalid weld, raise SystemExit.
    except (RuntimeError, ValueError, SystemExit) as error:
        raise RemoSplatError(" ".join(str(error).split())) from error
    inspector = scene_graph.model_inspector()
    primitives = [
        primitive
        for i in range(plant.num_bodies())
        for primitive in _primitives(
            plant, inspector, plant.get_body(BodyIndex(i))
        )
    ]
    return PrimitiveScene(
        boxes=tuple(p for p in primitives if isinstance(p, Box)),
        cylinders=tuple(p for p in primitives if isinstance(p, Cylinder)),
        name="directives",
    )


def with_absolute_files(
    directives: Sequence[ModelDirective], folder: Path
) -> list[ModelDirective]:
    """Copies directives with absolute file names.

    Args:
        directives: The directives, whose files are URIs (`package://`,
            `file://`) or paths.
        folder: Base folder of relative paths.

    Raises:
        FileError: A path does not name a file.
    """
    copies = copy.deepcopy(list(directives))
    for directive in copies:
        for name in ("add_model", "add_directives"):
            added = getattr(directive, name)
            if added is not None and "://" not in added.file:
                path = resolve(added.file, folder).resolve()
                added.file = f"file://{path}"
                # Drake's attribute is a copy, which must be assigned back.
                setattr(directive, name, added)
    return copies


def _primitives(
    plant: MultibodyPlant, inspector: SceneGraphInspector, body: RigidBody
) -> list[Box | Cylinder]:
    name = f"model {body.scoped_name().get_full()!r}"
    shapes = plant.GetCollisionGeometriesForBody(body)
    if not shapes and plant.GetVisualGeometriesForBody(body):
        raise RemoSplatError(f"{name}: has only a visual shape")
    if shapes and not plant.IsAnchored(body):
        raise RemoSplatError(f"{name}: is not welded to the world")
    X_WB = plant.EvalBodyPoseInWorld(plant.CreateDefaultContext(), body)
    return [
        _primitive(
            inspector.GetShape(shape),
            X_WB @ inspector.GetPoseInFrame(shape),
            f"{name}: shape {inspector.GetName(shape)!r}",
            plant.GetModelInstanceName(body.model_instance()),
        )
        for shape in shapes
    ]


def _primitive(
    shape: Shape, X_WP: RigidTransform, name: str, model: str
) -> Box | Cylinder:
    called = model.replace("_", " ")
    if isinstance(shape, DrakeBox):
        return Box(X_WP, shape.size() / 2, called)
    if isinstance(shape, DrakeCylinder):
        return Cylinder(X_WP, shape.radius(), shape.length() / 2, called)
    kind = type(shape).__name__
    raise RemoSplatError(
        f"{name} is a {kind}: only boxes and cylinders can be part of a scene"
    )
