"""Completes a URDF with the limits and inertias that a controller needs."""

import dataclasses as dc
import math
from xml.etree.ElementTree import Element, SubElement

import numpy as np

from remosplat_drake.robot.importing.findings import Findings, listed
from remosplat_drake.robot.importing.urdf import (
    CONTINUOUS,
    FIXED,
    PRISMATIC,
    Urdf,
    UrdfJoint,
)

SPEEDS = {True: 1.0, False: 0.1}
"""Assumed speed limits of revolute [rad/s] and prismatic joints [m/s]."""

EFFORTS = {True: 100.0, False: 1000.0}
"""Assumed effort limits of revolute [N m] and prismatic joints [N]."""

TO_FULL_SPEED = 0.25
"""Assumed time in which a joint accelerates to its full speed [s]."""

FASTEST = 100.0
"""Largest speed limit that a description may contain [rad/s, m/s]."""

_BALL_MASS, _BALL_INERTIA = 1.0, 0.001
"""Assumed mass and moment of inertia of a link without them [kg, kg m^2]."""


@dc.dataclass(frozen=True)
class JointLimits:
    """Limits of one commanded joint.

    Attributes:
        lower: Lower limit [rad, m].
        upper: Upper limit [rad, m].
        velocity: Largest speed [rad/s, m/s].
        acceleration: Largest acceleration [rad/s^2, m/s^2].
        effort: Largest torque or force of its motor [N m, N].
    """

    lower: float
    upper: float
    velocity: float
    acceleration: float
    effort: float


def complete_limits(
    urdf: Urdf, joints: tuple[UrdfJoint, ...], findings: Findings
) -> list[JointLimits]:
    """Reads the limits of joints, and guesses missing limits.

    Revolute joints without limits get one turn in each direction. The function
    changes the joints' elements in the document accordingly.

    Args:
        urdf: The robot.
        joints: The commanded joints.
        findings: Receives the guesses.

    Returns:
        The limits of each of the joints.

    Raises:
        FieldError: A prismatic joint has no limits, the lower limit is not
            below the upper limit, or a speed or an effort is negative.
    """
    limits, turning, slow, weak = [], [], [], []
    for joint in joints:
        where = f"joint {joint.name!r} {urdf.dialect.limit}"
        lower, upper = joint.lower, joint.upper
        if joint.kind == CONTINUOUS or (
            math.isnan(lower) and math.isnan(upper)
        ):
            if joint.kind == PRISMATIC:
                problem = f"is missing; {urdf.dialect.limits} in m"
                raise urdf.fail(where, problem)
            lower, upper = -2 * math.pi, 2 * math.pi
            turning.append(joint.name)
        # The default of the URDF specification for a missing limit.
        lower, upper = (0.0 if math.isnan(x) else x for x in (lower, upper))
        if not lower < upper:
            problem = f"lower {lower:g} must be less than upper {upper:g}"
            raise urdf.fail(where, f"{problem}; or {urdf.dialect.fixed}")
        velocity = joint.velocity
        if velocity < 0:
            problem = f"must not be negative, got {velocity:g}"
            raise urdf.fail(f"{where} velocity", problem)
        if not 0 < velocity <= FASTEST:
            velocity = SPEEDS[joint.kind != PRISMATIC]
            slow.append(joint.name)
        effort = joint.effort
        if effort < 0:
            problem = f"must not be negative, got {effort:g}"
            raise urdf.fail(f"{where} effort", problem)
        if not effort > 0:
            effort = EFFORTS[joint.kind != PRISMATIC]
            weak.append(joint.name)
        limits.append(
            JointLimits(
                lower,
                upper,
                round(velocity, 4),
                float(f"{velocity / TO_FULL_SPEED:.3g}"),
                effort,
            )
        )
        _write_limits(joint, limits[-1])
    if turning:
        findings.guess("position limits", f"+-2 pi of {listed(turning)}")
    if slow:
        findings.guess("velocity limits", f"1 rad/s, 0.1 m/s of {listed(slow)}")
    if len(slow) < len(limits):
        findings.find(
            "velocity limits",
            ", ".join(f"{limit.velocity:g}" for limit in limits),
        )
    if weak:
        findings.guess(
            "effort limits",
            f"{EFFORTS[True]:g} N m, {EFFORTS[False]:g} N of {listed(weak)};"
            " only simulated motors use it",
        )
    findings.guess(
        "acceleration limits",
        ", ".join(f"{limit.acceleration:g}" for limit in limits)
        + f": full speed in {TO_FULL_SPEED:g} s; no model contains them",
    )
    return limits


def _write_limits(joint: UrdfJoint, limits: JointLimits) -> None:
    element = joint.element
    if joint.kind == CONTINUOUS:
        element.set("type", "revolute")
    limit = element.find("limit")
    if limit is None:
        limit = SubElement(element, "limit")
    limit.set("lower", f"{limits.lower:.10g}")
    limit.set("upper", f"{limits.upper:.10g}")
    limit.set("velocity", f"{limits.velocity:.10g}")
    limit.set("effort", f"{limits.effort:.10g}")


def complete_inertias(urdf: Urdf, findings: Findings) -> None:
    """Gives a mass to links without a valid mass.

    Links that are fixed to each other are one body, which needs only one mass.
    Frames, and links that are fixed to a link with a mass, therefore get no
    mass.

    Args:
        urdf: The robot; its links' elements are changed.
        findings: Receives the guesses.
    """
    bodies: dict[str, list[str]] = {}
    for name, link in urdf.links.items():
        inertial = link.find("inertial")
        if inertial is not None and not _is_physical(inertial):
            link.remove(inertial)
        bodies.setdefault(urdf.rigid_root(name), []).append(name)
    missing = []
    for root, links in bodies.items():
        shown = [
            x for x in links if urdf.links[x].find("collision") is not None
        ]
        heavy = any(urdf.links[x].find("inertial") is not None for x in links)
        if heavy or not (shown or _is_last(urdf, links)):
            continue
        missing.append(shown[0] if shown else root)
        urdf.links[missing[-1]].append(_ball())
    if missing:
        findings.guess(
            "mass",
            f"1 kg, as a small ball, for {listed(missing)}, which have no "
            "valid mass in the model",
        )


def _is_last(urdf: Urdf, links: list[str]) -> bool:
    """Whether links form a moving body that carries no other body."""
    outboard = [joint for link in links for joint in urdf.outboard(link)]
    is_moved = any(link in urdf.inboard for link in links)
    return is_moved and all(joint.kind == FIXED for joint in outboard)


def _ball() -> Element:
    inertial = Element("inertial")
    SubElement(inertial, "mass", value=f"{_BALL_MASS:g}")
    moment = f"{_BALL_INERTIA:g}"
    SubElement(
        inertial,
        "inertia",
        ixx=moment,
        iyy=moment,
        izz=moment,
        ixy="0",
        ixz="0",
        iyz="0",
    )
    return inertial


def _is_physical(inertial: Element) -> bool:
    """Returns whether mass and moments are those of a possible body."""
    mass, inertia = inertial.find("mass"), inertial.find("inertia")
    if mass is None or inertia is None:
        return False
    try:
        m = float(mass.get("value", ""))
        xx, yy, zz, xy, xz, yz = (
            float(inertia.get(key, "0"))
            for key in ("ixx", "iyy", "izz", "ixy", "ixz", "iyz")
        )
    except ValueError:
        return False
    matrix = np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
    if not (np.isfinite(matrix).all() and 0 < m < math.inf):
        return False
    moments = np.linalg.eigvalsh(matrix)
    return bool(moments[0] > 0 and moments[2] <= 1.001 * moments[:2].sum())
