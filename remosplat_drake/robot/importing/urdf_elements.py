"""Writes Drake's shapes, inertias and joints as URDF elements."""

from collections.abc import Iterable, Mapping
from pathlib import Path
from xml.etree.ElementTree import Element, SubElement

from pydrake.geometry import (
    Box,
    Capsule,
    Convex,
    Cylinder,
    Ellipsoid,
    Mesh,
    Shape,
    Sphere,
)
from pydrake.math import RigidTransform, RollPitchYaw
from pydrake.multibody.tree import SpatialInertia

_DRAKE = "{http://drake.mit.edu}"


def text(values: Iterable[float]) -> str:
    """Formats numbers as an attribute, with all significant digits."""
    # Adding zero turns -0 into 0.
    return " ".join(f"{x + 0.0:.15g}" for x in values)


def origin_element(X: RigidTransform) -> Element:
    """Returns the <origin> of a pose."""
    rpy = RollPitchYaw(X.rotation()).vector()
    return Element("origin", xyz=text(X.translation()), rpy=text(rpy))


def origin_pose(element: Element) -> RigidTransform:
    """Returns the pose that the <origin> of an element states.

    Args:
        element: A shape or a joint, whose numbers have been checked.
    """
    origin = element.find("origin")
    if origin is None:
        return RigidTransform()
    xyz, rpy = (
        [float(x) for x in origin.get(key, "0 0 0").split()]
        for key in ("xyz", "rpy")
    )
    return RigidTransform(RollPitchYaw(rpy), xyz)


def joint_element(
    name: str, kind: str, parent: str, child: str, X_PC: RigidTransform
) -> Element:
    """Returns a <joint>.

    Args:
        name: Name of the joint.
        kind: Type of the joint.
        parent: Name of the link P that carries it.
        child: Name of the link C that it moves.
        X_PC: Pose of C in P at position zero.
    """
    element = Element("joint", name=name, type=kind)
    SubElement(element, "parent", link=parent)
    SubElement(element, "child", link=child)
    element.append(origin_element(X_PC))
    return element


def transmission_element(joint: str) -> Element:
    """Returns the <transmission> of a motor that drives a joint directly.

    From it, Drake makes the joint's actuator, with the joint's effort limit.

    Args:
        joint: Name of the joint.
    """
    element = Element("transmission", name=f"{joint}_motor")
    kind = SubElement(element, "type")
    kind.text = "transmission_interface/SimpleTransmission"
    SubElement(element, "joint", name=joint)
    SubElement(element, "actuator", name=joint)
    return element


def inertial_element(M_BBo_B: SpatialInertia) -> Element:
    """Returns the <inertial> of a body's spatial inertia about its origin."""
    p_BoBcm = M_BBo_B.get_com()
    M_BBcm_B = M_BBo_B.Shift(p_BoBcm)
    moments = M_BBcm_B.CalcRotationalInertia().CopyToFullMatrix3()
    inertial = Element("inertial")
    SubElement(inertial, "origin", xyz=text(p_BoBcm))
    SubElement(inertial, "mass", value=text([M_BBo_B.get_mass()]))
    terms = {
        f"i{a}{b}": text([moments["xyz".index(a), "xyz".index(b)]])
        for a, b in ("xx", "yy", "zz", "xy", "xz", "yz")
    }
    SubElement(inertial, "inertia", terms)
    return inertial


def geometry_element(
    shape: Shape, originals: Mapping[Path, Path]
) -> Element | None:
    """Returns the <geometry> of a shape; None for an infinite shape.

    Args:
        shape: The shape.
        originals: The original mesh files, keyed by the converted files.
    """
    geometry = Element("geometry")
    if isinstance(shape, Box):
        SubElement(geometry, "box", size=text(shape.size()))
    elif isinstance(shape, Sphere):
        SubElement(geometry, "sphere", radius=text([shape.radius()]))
    elif isinstance(shape, (Cylinder, Capsule)):
        is_capsule = isinstance(shape, Capsule)
        SubElement(
            geometry,
            f"{_DRAKE}capsule" if is_capsule else "cylinder",
            radius=text([shape.radius()]),
            length=text([shape.length()]),
        )
    elif isinstance(shape, Ellipsoid):
        axes = {"a": shape.a(), "b": shape.b(), "c": shape.c()}
        sizes = {name: text([axis]) for name, axis in axes.items()}
        SubElement(geometry, f"{_DRAKE}ellipsoid", sizes)
    elif isinstance(shape, (Mesh, Convex)):
        file = shape.source().path()
        SubElement(
            geometry,
            "mesh",
            filename=str(originals.get(file, file)),
            scale=text(shape.scale3()),
        )
    else:
        return None
    return geometry
