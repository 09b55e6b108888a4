"""Converts robots in formats that Drake's parser reads to URDF."""

import contextlib
import logging
import re
import tempfile
from collections.abc import Iterator
from pathlib import Path
from xml.etree import ElementTree

from pydrake.geometry import SceneGraph
from pydrake.multibody.parsing import Parser
from pydrake.multibody.plant import MultibodyPlant
from pydrake.multibody.tree import ModelInstanceIndex

from remosplat_drake.base.errors import FieldError, FileError
from remosplat_drake.robot.importing.dialects import DIRECTIVES, MJCF, Dialect
from remosplat_drake.robot.importing.findings import Findings, listed
from remosplat_drake.robot.importing.missing_meshes import note_replaced
from remosplat_drake.robot.importing.packages import Packages
from remosplat_drake.robot.importing.plant_urdf import PlantUrdf
from remosplat_drake.robot.importing.srdf import Srdf
from remosplat_drake.robot.importing.staging import Staging
from remosplat_drake.robot.importing.urdf import Urdf
from remosplat_drake.robot.model_file import in_one_line

_UNKNOWN_TAG = re.compile(r"The (?:tag|attribute) '([^']+)'")

_STRANGE_ELEMENT = re.compile(
    r"XML Element\[(\w+)\], child of element\[(\w+)\], not defined in SDF"
)
"""Drake's error about an element that SDFormat does not have at this place."""

_PLACE = re.compile(r"^\S+:(\d+): (?:error|warning): ")


def read_by_drake(
    path: Path, dialect: Dialect, packages: Packages, findings: Findings
) -> tuple[Urdf, Srdf]:
    """Reads SDFormat, MJCF or model directives as a URDF and an SRDF.

    Args:
        path: The file.
        dialect: Format of the file.
        packages: Resolves references to ROS packages.
        findings: Receives the ignored elements.

    Returns:
        The robot, and an `Srdf` with further content of its files: named
        states, and links that may touch.

    Raises:
        RemoSplatError: A file is missing or unusable, or the robot has parts
            that cannot be driven.
    """
    with tempfile.TemporaryDirectory(prefix="import-") as folder:
        staging = Staging(packages, Path(folder).resolve())
        copy = staging.stage(path)
        dropped: list[str] = []
        parsed = None
        while parsed is None:
            parsed = _parsed(path, copy, staging, dropped)
        plant, scene_graph, models, warnings = parsed
        if plant.num_bodies() == 1:
            raise FileError(path, "has no links")
        writer = PlantUrdf(
            plant,
            scene_graph.model_inspector(),
            staging,
            path,
            dialect,
        )
        if dialect is MJCF and writer.roots:
            raise FieldError(
                str(path),
                f"body {writer.roots[0]!r} <freejoint>",
                "floats, and so do other bodies; remove all floating bodies but"
                " the robot, and choose its mobile base with --base",
            )
        name = _name(path, dialect, plant, models)
        root = writer.document(name, findings)
        said = Srdf(states=staging.states, allowed_collisions=writer.may_touch)
    findings.find("format", f"{dialect.title}, as Drake reads it")
    note_replaced(staging.replaced, findings)
    if staging.floating:
        findings.guess(
            "floating base",
            f"{staging.floating[0]} is fixed to the world; --base gives the"
            " robot a mobile base",
        )
    if dropped:
        findings.guess("removed, not in SDFormat", listed(dropped))
    if warnings:
        findings.guess("ignored by Drake", _summary(warnings))
    text = ElementTree.tostring(root, encoding="unicode")
    return Urdf(path, text, dialect, tuple(staging.loops)), said


def _parsed(
    path: Path, copy: Path, staging: Staging, dropped: list[str]
) -> (
    tuple[MultibodyPlant, SceneGraph, list[ModelInstanceIndex], list[str]]
    | None
):
    """Returns the plant of a copy, and Drake's warnings.

    Drake rejects elements that SDFormat does not have. If that happens, they
    are removed from the copy and None is returned; the caller tries again.
    """
    scene_graph = SceneGraph()
    plant = MultibodyPlant(time_step=0.0)
    plant.RegisterAsSourceForSceneGraph(scene_graph)
    with _warnings() as warnings:
        try:
            models = Parser(plant).AddModels(str(copy))
        # Drake aborts in C++; from Python, this raises SystemExit.
        except (RuntimeError, ValueError, SystemExit) as error:
            strange = _STRANGE_ELEMENT.search(str(error))
            if strange and staging.drop_elements(strange[2], strange[1]):
                dropped.append(f"<{strange[1]}> in <{strange[2]}>")
                return None
            problem = _with_line(staging.in_originals(in_one_line(error)))
            raise FileError(path, problem) from error
    return plant, scene_graph, models, warnings


def _name(
    path: Path,
    dialect: Dialect,
    plant: MultibodyPlant,
    models: list[ModelInstanceIndex],
) -> str:
    if dialect is DIRECTIVES or len(models) != 1:
        return path.name.partition(".")[0]
    return plant.GetModelInstanceName(models[0])


def _with_line(text: str) -> str:
    """Returns Drake's error about a file, without the file's name."""
    return _PLACE.sub(r"line \1: ", text).split(" See https")[0]


def _summary(warnings: list[str]) -> str:
    """Summarises warnings: the elements' names, and the first other remark."""
    tags, others = {}, {}
    for text in warnings:
        tag = _UNKNOWN_TAG.search(text)
        if tag:
            tags[f"<{tag[1]}>"] = None
        else:
            others[_PLACE.sub("", text)] = None
    return listed([listed([*tags]), *others] if tags else [*others], 2)


@contextlib.contextmanager
def _warnings() -> Iterator[list[str]]:
    """Collects Drake's warnings instead of printing them."""
    texts: list[str] = []
    logger = logging.getLogger("drake")
    handler = logging.Handler(logging.WARNING)
    handler.emit = lambda record: texts.append(
        " ".join(record.getMessage().split())
    )
    propagated, logger.propagate = logger.propagate, False
    logger.addHandler(handler)
    try:
        yield texts
    finally:
        logger.removeHandler(handler)
        logger.propagate = propagated
