"""Prepares MuJoCo's MJCF for Drake's parser, which supports only a part."""

import dataclasses as dc
import math
from collections.abc import Callable
from pathlib import Path
from xml.etree import ElementTree
from xml.etree.ElementTree import Element, SubElement

import numpy as np

from remosplat_drake.base.errors import FieldError, FileError
from remosplat_drake.robot.importing.mjcf_defaults import write_out_defaults
from remosplat_drake.robot.importing.urdf import Loop, Mimic

_POSES = ("pos", "quat", "axisangle", "xyaxes", "zaxis", "euler")
"""Attributes that define the pose of a site on its body."""

_GENERATED = ("frame", "replicate", "attach", "composite", "flexcomp")
"""Children of bodies that generate or move other bodies; Drake ignores them."""


@dc.dataclass
class SaidOfJoints:
    """Properties of a model's joints that Drake's parser does not keep.

    Attributes:
        mimics: Joints that follow other joints, keyed by name.
        loops: Constraints that close loops of links.
        states: Positions of joints by name, for each keyframe [rad, m].
        floating: Name of the single floating body, which has been fixed.
    """

    mimics: dict[str, Mimic] = dc.field(default_factory=dict)
    loops: list[Loop] = dc.field(default_factory=list)
    states: dict[str, dict[str, float]] = dc.field(default_factory=dict)
    floating: list[str] = dc.field(default_factory=list)


def prepare_mjcf(
    path: Path, root: Element, mesh: Callable[[str], str]
) -> SaidOfJoints:
    """Rewrites an MJCF document so that Drake's parser reads all of it.

    Included files and default classes are written out, mesh files are replaced
    by files that Drake reads, and sites become frames. Joint couplings and
    keyframes are removed.

    Args:
        path: The file, to which the names of other files are relative.
        root: The document, which is changed.
        mesh: Function that converts a mesh, named relative to the file, and
            returns the name of a mesh that Drake reads.

    Returns:
        The removed content, which Drake ignores or interprets differently.

    Raises:
        RemoSplatError: A file is missing or broken, or the model contains
            generating elements that Drake ignores.
    """
    # Drake requires a name, but MuJoCo does not.
    root.set("model", root.get("model") or path.stem)
    _include(path, root, {path})
    for element in root.iter():
        if element.tag in _GENERATED:
            raise FieldError(
                str(path),
                f"<{element.tag}>",
                "Drake ignores it; load the model in MuJoCo and save it"
                " with mj_saveLastXML, which writes such elements out",
            )
    write_out_defaults(path, root)
    _name_meshes(root, mesh)
    states = _states(root)
    floating = _fix_floating(root)
    _sites_as_bodies(root)
    for body in list(root.iter("body")):
        _drop_empty_inertia(body)
        _nest_joints(body)
    return SaidOfJoints(*_couplings(root), states, floating)


def _include(path: Path, element: Element, seen: set[Path]) -> None:
    """Replaces each <include> by the content of its file."""
    children = []
    for child in element:
        if child.tag != "include":
            _include(path, child, seen)
            children.append(child)
            continue
        file = path.parent / child.get("file", "")
        if file in seen:
            raise FieldError(str(path), f"<include> {file}", "occurs twice")
        seen.add(file)
        try:
            included = ElementTree.parse(file).getroot()
        except (OSError, ElementTree.ParseError) as error:
            raise FileError(file, f"cannot be included: {error}") from error
        _include(path, included, seen)
        children.extend(included)
    element[:] = children


def _name_meshes(root: Element, mesh: Callable[[str], str]) -> None:
    folder = ""
    for compiler in root.findall("compiler"):
        for name in ("assetdir", "meshdir"):
            folder = compiler.attrib.pop(name, folder)
    for asset in root.findall("asset"):
        for element in asset.findall("mesh"):
            file = element.get("file")
            if file is not None:
                # A mesh without a name has the name of its file.
                element.set("name", element.get("name", Path(file).stem))
                element.set("file", mesh(str(Path(folder) / file)))


def _sites_as_bodies(root: Element) -> None:
    """Replaces sites by bodies without shapes, since Drake has no sites."""
    taken = {body.get("name") for body in root.iter("body")}
    for body in list(root.iter("body")):
        for site in body.findall("site"):
            name = site.get("name")
            if name and name not in taken and "fromto" not in site.attrib:
                taken.add(name)
                pose = {
                    key: site.attrib[key]
                    for key in _POSES
                    if key in site.attrib
                }
                body.append(Element("body", {"name": name, **pose}))
            body.remove(site)


def _drop_empty_inertia(body: Element) -> None:
    """Removes an inertia without mass, which Drake rejects."""
    inertial = body.find("inertial")
    if inertial is not None and not _floats(inertial.get("mass", "1"))[0]:
        body.remove(inertial)
        for geom in body.findall("geom"):
            geom.set("mass", "0")


def _nest_joints(body: Element) -> None:
    """Gives each of a body's several joints its own, nested body.

    Drake places only the last of these joints at the body; it places all
    earlier joints at the origin of the body's parent.
    """
    name, outer = body.attrib.pop("name", None), body
    joints = body.findall("joint")
    inside = [child for child in body if child not in joints]
    body[:] = joints[:1]
    for i, joint in enumerate(joints[1:]):
        if name is not None:
            outer.set("name", f"{name}_{joints[i].get('name', i)}")
        outer = SubElement(outer, "body")
        outer.append(joint)
    outer.extend(inside)
    if name is not None:
        outer.set("name", name)


def _floats(text: str) -> list[float]:
    try:
        return [float(x) for x in text.split()] or [math.nan]
    except ValueError:
        return [math.nan]


def _couplings(root: Element) -> tuple[dict[str, Mimic], list[Loop]]:
    """Removes elements that couple joints, and mocap bodies."""
    mimics, loops = {}, []
    dragging = {
        body.get("name")
        for body in root.iter("body")
        if body.get("mocap") == "true"
    }
    for equality in root.findall("equality"):
        for element in list(equality):
            leader = element.get("joint2")
            if element.tag == "joint" and leader is not None:
                terms = element.get("polycoef", "0 1").split()
                offset, multiplier = [*terms, "0", "0"][:2]
                follower = element.get("joint1", "")
                mimics[follower] = Mimic(leader, multiplier, offset)
            elif element.tag in ("connect", "weld"):
                first, second = (
                    element.get(f"body{i}") or element.get(f"site{i}", "world")
                    for i in (1, 2)
                )
                where = f"<equality> <{element.tag}> {first}"
                if not dragging & {first, second}:
                    loops.append(Loop(where, first, second))
            else:
                continue
            equality.remove(element)
    return mimics, loops


def _fix_floating(root: Element) -> list[str]:
    """Fixes the single floating body, and returns its name.

    If several bodies float, all but one of them are objects, and the robot
    cannot be identified.
    """
    floating = [
        (body, joint)
        for body in root.iter("body")
        for joint in body
        if _floats_freely(joint)
    ]
    if len(floating) != 1:
        return []
    (body, joint) = floating[0]
    body.remove(joint)
    return [body.get("name", "a body without a name")]


def _floats_freely(joint: Element) -> bool:
    is_joint = joint.tag == "joint" and joint.get("type") == "free"
    return is_joint or joint.tag == "freejoint"


_COORDINATES = {"free": 7, "ball": 4}
"""Types of joints with several position coordinates, and the number of these.
"""


def _states(root: Element) -> dict[str, dict[str, float]]:
    """Returns the keyframes' positions of all joints with one coordinate."""
    joints = [
        joint
        for body in root.iter("body")
        for joint in body
        if joint.tag in ("joint", "freejoint")
    ]
    counts = [
        7 if joint.tag == "freejoint" else _COORDINATES.get(kind, 1)
        for joint in joints
        for kind in [joint.get("type", "")]
    ]
    states = {}
    for keyframe in root.findall("keyframe"):
        for key in keyframe.findall("key"):
            positions = _floats(key.get("qpos", ""))
            if len(positions) == sum(counts) and np.isfinite(positions).all():
                starts = np.cumsum([0, *counts[:-1]])
                states[key.get("name", "")] = {
                    joint.get("name", ""): positions[start]
                    for joint, start, count in zip(
                        joints, starts, counts, strict=True
                    )
                    if count == 1
                }
        root.remove(keyframe)
    return states
