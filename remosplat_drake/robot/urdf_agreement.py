"""Compares a URDF that a robot publishes with this package's model of it.

Two correct models may have different link frames, but not different joint axes.
The axes are therefore compared as lines in space: the angle between two lines,
and their moment about each other, do not depend on frames.
"""

import xml.etree.ElementTree as ElementTree

import numpy as np
from pydrake.multibody.parsing import Parser
from pydrake.multibody.plant import MultibodyPlant
from pydrake.multibody.tree import Joint, PrismaticJoint, RevoluteJoint
from pydrake.systems.framework import Context

from remosplat_drake.robot.model_file import add_robot_model, in_one_line
from remosplat_drake.robot.robot_description import RobotDescription

_COSINE = 0.02
"""The cosine of the angle between two axes may differ by this value. A factory
calibration causes smaller differences."""

_DISTANCE = 0.005
"""Two descriptions agree if the moment of an axis about another axis differs by
at most this value between them [m]."""

_LIMIT = 0.01
"""Position limits may differ by this value [rad, m], and speed limits by this
fraction."""

_BEND = 0.4
"""Axes are compared at home, and with the joints alternately this far above and
below their home positions [rad, m]."""

_LEFT_OUT = ("visual", "collision", "transmission", "ros2_control", "gazebo")


def urdf_problem(text: str, description: RobotDescription) -> str:
    """Describes the first disagreement of a URDF with a robot's description.

    Joints, limits and the geometry of the arm's axes are compared. The robot's
    position, its tool and its shapes are not compared.

    Args:
        text: The URDF.
        description: Our description of the robot.

    Returns:
        The disagreement; empty if there is none.
    """
    try:
        theirs = _plant(text)
    except (RuntimeError, ValueError, SystemExit) as error:
        return f"is not a URDF: {in_one_line(error)}"
    ours, names = MultibodyPlant(0.0), description.arm.joints
    add_robot_model(description, ours)
    ours.Finalize()
    for name in names:
        if not theirs.HasJointNamed(name):
            return f"has no joint {name}"
    speeds = description.velocity_limits[description.n_base :]
    for name, speed in zip(names, speeds, strict=True):
        joints = ours.GetJointByName(name), theirs.GetJointByName(name)
        problem = _joint_problem(*joints, speed)
        if problem:
            return f"{name}: {problem}"
    home = np.array(description.home)
    bent = home + _BEND * np.where(np.arange(len(home)) % 2, -1.0, 1.0)
    for q in (home, bent):
        problem = _axes_problem(
            names, *(_screws(plant, names, q) for plant in (ours, theirs))
        )
        if problem:
            return problem
    return ""


def _plant(text: str) -> MultibodyPlant:
    """Parses a URDF without its shapes, whose files may be elsewhere.

    Raises:
        ValueError: It is not XML.
        RuntimeError: It is not a URDF.
    """
    try:
        root = ElementTree.fromstring(text)
    except ElementTree.ParseError as error:
        raise ValueError(str(error)) from error
    for element in list(root.iter()):
        for child in list(element):
            if child.tag in _LEFT_OUT:
                element.remove(child)
    plant = MultibodyPlant(0.0)
    bare = ElementTree.tostring(root, encoding="unicode")
    Parser(plant).AddModelsFromString(bare, "urdf")
    plant.Finalize()
    return plant


def _joint_problem(ours: Joint, theirs: Joint, speed: float) -> str:
    """Describes the disagreement of a joint's kind or limits.

    Args:
        ours: The joint of our model.
        theirs: The joint of the URDF.
        speed: Our bound on its velocity [rad/s, m/s].
    """
    if type(ours) is not type(theirs):
        kinds = theirs.type_name(), ours.type_name()
        return f"is {kinds[0]}, but {kinds[1]} in our model"
    (low,), (high,) = (
        theirs.position_lower_limits(),
        theirs.position_upper_limits(),
    )
    (our_low,), (our_high,) = (
        ours.position_lower_limits(),
        ours.position_upper_limits(),
    )
    if our_low < low - _LIMIT or our_high > high + _LIMIT:
        return (
            f"goes from {low:.2f} to {high:.2f}, but in our model from"
            f" {our_low:.2f} to {our_high:.2f}: narrow the limits in `model`"
        )
    (bound,) = theirs.velocity_upper_limits()
    if speed > bound * (1.0 + _LIMIT):
        return (
            f"is limited to a speed of {bound:.2f}, but in our description to"
            f" {speed:.2f}: lower `velocity_limits`"
        )
    return ""


def _screws(
    plant: MultibodyPlant, names: list[str], q: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Directions of the axes, and their moments about the world's origin.

    Args:
        plant: A plant with joints of these names.
        names: The joints.
        q: Positions of the joints, shape (n,) [rad, m].

    Returns:
        The directions and the moments, shape (n, 3) each. For a prismatic
        joint, the direction is zero, and the moment is the direction of its
        axis.
    """
    context = plant.CreateDefaultContext()
    joints = [plant.GetJointByName(name) for name in names]
    positions = plant.GetPositions(context)
    positions[[joint.position_start() for joint in joints]] = q
    plant.SetPositions(context, positions)
    screws = [_screw(plant, context, joint) for joint in joints]
    directions, moments = zip(*screws, strict=True)
    return np.array(directions), np.array(moments)


def _screw(
    plant: MultibodyPlant, context: Context, joint: Joint
) -> tuple[np.ndarray, np.ndarray]:
    X_WF = joint.frame_on_parent().CalcPoseInWorld(context)
    if isinstance(joint, RevoluteJoint):
        direction = X_WF.rotation() @ joint.revolute_axis()
        return direction, np.cross(X_WF.translation(), direction)
    assert isinstance(joint, PrismaticJoint)
    return np.zeros(3), X_WF.rotation() @ joint.translation_axis()


def _axes_problem(
    names: list[str],
    ours: tuple[np.ndarray, np.ndarray],
    theirs: tuple[np.ndarray, np.ndarray],
) -> str:
    """Describes the two axes that differ most from the model; "" if none."""
    (d, m), (their_d, their_m) = ours, theirs
    turned = np.abs(d @ d.T - their_d @ their_d.T)
    # The moment of two lines: their distance times the sine of their angle.
    moved = np.abs(
        d @ m.T + m @ d.T - their_d @ their_m.T - their_m @ their_d.T
    )
    if turned.max() <= _COSINE and moved.max() <= _DISTANCE:
        return ""
    by = turned / _COSINE + moved / _DISTANCE
    i, j = sorted(np.unravel_index(int(by.argmax()), by.shape))
    return (
        f"the axes of {names[i]} and {names[j]} differ from our model: by"
        f" {1e3 * moved[i, j]:.0f} mm, and by {turned[i, j]:.2f} in the cosine"
        " of the angle between them; correct `model`"
    )
