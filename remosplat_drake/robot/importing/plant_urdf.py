"""Converts a plant, as parsed by Drake, to a URDF.

All formats can therefore be processed in the same way. Frames of links are
preserved. If a joint's axis does not pass through the origin of its child link,
an additional link is inserted there, as URDF requires.
"""

from collections import Counter
from collections.abc import Collection, Iterator
from itertools import combinations
from pathlib import Path
from xml.etree.ElementTree import Element, SubElement

import numpy as np
from pydrake.geometry import Role, SceneGraphInspector, Shape
from pydrake.math import RigidTransform
from pydrake.multibody.plant import MultibodyPlant
from pydrake.multibody.tree import (
    BodyIndex,
    Frame,
    FrameIndex,
    Joint,
    RigidBody,
)

from remosplat_drake.base.errors import FieldError
from remosplat_drake.robot.importing.dialects import Dialect
from remosplat_drake.robot.importing.findings import Findings
from remosplat_drake.robot.importing.staging import Staging
from remosplat_drake.robot.importing.urdf_elements import (
    geometry_element,
    inertial_element,
    joint_element,
    origin_element,
    text,
)

_KINDS = {"revolute": "revolute", "prismatic": "prismatic", "weld": "fixed"}
"""URDF's types of joints, by Drake's types."""

_ENDLESS = 1e6
"""Position limits beyond this count as missing: SDFormat's default is 1e16."""

_ON_AXIS = 1e-9
"""A link's origin counts as on an axis if it is at most this far from it [m].
"""


class PlantUrdf:
    """Writes a plant's bodies, joints, shapes and frames as a URDF document.

    Names that are unique in the plant are preserved. Other names get the name
    of their model as a prefix.
    """

    def __init__(
        self,
        plant: MultibodyPlant,
        inspector: SceneGraphInspector,
        staging: Staging,
        path: Path,
        dialect: Dialect,
    ):
        """Chooses all names.

        Args:
            plant: The plant, which is not finalized, since Drake would add
                joints to free bodies.
            inspector: Inspector of the plant's geometry.
            staging: The copies that Drake has parsed, and their originals.
            path: The robot's file, for errors.
            dialect: Format of the robot's file, for errors.
        """
        self._plant = plant
        self._inspector = inspector
        self._staging = staging
        self._path = path
        self._dialect = dialect
        self._bodies = [
            plant.get_body(BodyIndex(i)) for i in range(plant.num_bodies())
        ]
        self._joints = [plant.get_joint(i) for i in plant.GetJointIndices()]
        actuators = [
            plant.get_joint_actuator(i) for i in plant.GetJointActuatorIndices()
        ]
        self._effort = {x.joint().index(): x.effort_limit() for x in actuators}
        self._link = self._named(self._bodies)
        self._joint = self._named(self._joints)

    @property
    def roots(self) -> list[str]:
        """Names of the links that no joint moves, except for the world."""
        carried = {joint.child_body().index() for joint in self._joints}
        return [
            self._link[body.index()]
            for body in self._bodies[1:]
            if body.index() not in carried
        ]

    @property
    def may_touch(self) -> tuple[tuple[str, str], ...]:
        """Pairs of links whose collisions the files disable, each sorted."""
        shapes = {}
        for body in self._bodies[1:]:
            frame = self._plant.GetBodyFrameIdIfExists(body.index())
            if frame is not None:
                found = self._inspector.GetGeometries(frame, Role.kProximity)
                if found:
                    shapes[self._link[body.index()]] = found[0]
        # Drake disables collisions of neighbours, too, but only on
        # finalization.
        return tuple(
            sorted(
                (min(a, b), max(a, b))
                for a, b in combinations(shapes, 2)
                if self._inspector.CollisionFiltered(shapes[a], shapes[b])
            )
        )

    def document(self, name: str, findings: Findings) -> Element:
        """Makes the document.

        Args:
            name: Name of the robot.
            findings: Receives the omitted elements.

        Raises:
            FieldError: A joint is of a type that cannot be driven.
        """
        root = Element("robot", name=name)
        world, *bodies = self._bodies
        if any(j.parent_body().index() == world.index() for j in self._joints):
            SubElement(root, "link", name="world")
        for body in bodies:
            root.append(self._link_element(body))
        for joint in self._joints:
            root.extend(self._joint_elements(joint))
        for frame_name, frame in self._frames():
            root.extend(
                self._frame_elements(frame_name, frame, self._joint.values())
            )
        if any(True for _ in self._shapes(world)):
            findings.guess(
                "left out",
                "shapes of the world itself; add them to a scenario's scene",
            )
        return root

    def _named(self, elements: list) -> dict:
        """Returns unique names by index."""
        count = Counter(element.name() for element in elements)
        names = {}
        for element in elements:
            name = element.name()
            if count[name] > 1:
                instance = self._plant.GetModelInstanceName(
                    element.model_instance()
                )
                name = f"{instance}_{name}".replace("::", "_")
            names[element.index()] = name
        return names

    def _link_element(self, body: RigidBody) -> Element:
        link = Element("link", name=self._link[body.index()])
        mass = body.default_mass()
        if np.isfinite(mass) and mass > 0:
            link.append(inertial_element(body.default_spatial_inertia()))
        for role, shape, X_LG, colour in self._shapes(body):
            geometry = geometry_element(shape, self._staging.originals)
            if geometry is None:
                continue
            element = SubElement(link, role)
            element.append(origin_element(X_LG))
            element.append(geometry)
            if colour is not None:
                material = SubElement(element, "material", name="")
                SubElement(material, "color", rgba=text(colour))
        return link

    def _shapes(
        self, body: RigidBody
    ) -> Iterator[tuple[str, Shape, RigidTransform, tuple[float, ...] | None]]:
        """Returns a body's shapes: role, shape, pose in it, and colour."""
        frame = self._plant.GetBodyFrameIdIfExists(body.index())
        if frame is None:
            return
        roles = {"visual": Role.kIllustration, "collision": Role.kProximity}
        for name, role in roles.items():
            for geometry in self._inspector.GetGeometries(frame, role):
                properties = self._inspector.GetProperties(geometry, role)
                rgba = None
                if properties.HasProperty("phong", "diffuse"):
                    colour = properties.GetProperty("phong", "diffuse")
                    rgba = colour.r(), colour.g(), colour.b(), colour.a()
                yield (
                    name,
                    self._inspector.GetShape(geometry),
                    self._inspector.GetPoseInFrame(geometry),
                    rgba,
                )

    def _joint_elements(self, joint: Joint) -> list[Element]:
        name, kind = self._joint[joint.index()], joint.type_name()
        if kind not in _KINDS:
            raise FieldError(
                str(self._path),
                f"joint {name!r}",
                f"is {kind.removesuffix('_rpy')}, which cannot be driven;"
                f" {self._dialect.fixed}",
            )
        parent = self._link[joint.parent_body().index()]
        child = self._link[joint.child_body().index()]
        X_PF = _pose(joint.frame_on_parent())
        X_CM = _pose(joint.frame_on_child())
        if kind == "weld":
            X_PC = X_PF @ joint.X_FM() @ X_CM.inverse()
            return [joint_element(name, "fixed", parent, child, X_PC)]
        is_hinge = kind == "revolute"
        axis_M = joint.revolute_axis() if is_hinge else joint.translation_axis()
        axis_C = X_CM.rotation() @ axis_M
        off = np.linalg.norm(np.cross(X_CM.translation(), axis_C))
        elements = []
        if is_hinge and off > _ON_AXIS:
            between = f"{name}_axis"
            elements = [
                Element("link", name=between),
                joint_element(
                    f"{name}_arm", "fixed", between, child, X_CM.inverse()
                ),
            ]
            element = joint_element(name, _KINDS[kind], parent, between, X_PF)
            axis_C = axis_M
        else:
            X_PC = X_PF @ X_CM.inverse()
            element = joint_element(name, _KINDS[kind], parent, child, X_PC)
        SubElement(element, "axis", xyz=text(axis_C))
        self._add_limits(element, joint)
        self._add_mimic(element, joint)
        return [*elements, element]

    def _add_limits(self, element: Element, joint: Joint) -> None:
        lower = joint.position_lower_limits()[0]
        upper = joint.position_upper_limits()[0]
        velocity = joint.velocity_upper_limits()[0]
        ends = {"lower": lower, "upper": upper}
        ends = {key: x for key, x in ends.items() if abs(x) < _ENDLESS}
        if joint.type_name() == "revolute":
            # If the file states only one limit, the other limit is one turn
            # away.
            if len(ends) == 1:
                ends = {"lower": -2 * np.pi, "upper": 2 * np.pi} | ends
            elif not ends:
                element.set("type", "continuous")
        elif len(ends) == 1:
            ends = {}
        limits = {key: text([x]) for key, x in ends.items()}
        if np.isfinite(velocity):
            limits["velocity"] = text([velocity])
        effort = self._effort.get(joint.index(), np.inf)
        if np.isfinite(effort):
            limits["effort"] = text([effort])
        if limits:
            SubElement(element, "limit", limits)

    def _add_mimic(self, element: Element, joint: Joint) -> None:
        mimic = self._staging.mimics.get(joint.name())
        if mimic is None:
            return
        leaders = [
            self._joint[other.index()]
            for other in self._joints
            if other.name() == mimic.leader
            and other.model_instance() == joint.model_instance()
        ]
        SubElement(
            element,
            "mimic",
            joint=leaders[0] if leaders else mimic.leader,
            multiplier=mimic.multiplier,
            offset=mimic.offset,
        )

    def _frames(self) -> Iterator[tuple[str, Frame]]:
        """Returns the named frames that are not frames of links or joints."""
        of_joints = {
            frame.index()
            for joint in self._joints
            for frame in (joint.frame_on_parent(), joint.frame_on_child())
        }
        plant = self._plant
        frames = [
            plant.get_frame(FrameIndex(i)) for i in range(plant.num_frames())
        ]
        frames = [
            frame
            for frame in frames
            if not frame.is_body_frame()
            and frame.name()
            and not frame.name().startswith("__")
            and frame.index() not in of_joints
            and frame.body().index() != self._bodies[0].index()
        ]
        names = self._named(frames)
        links = set(self._link.values())
        for frame in frames:
            if names[frame.index()] not in links:
                yield names[frame.index()], frame

    def _frame_elements(
        self, name: str, frame: Frame, joints: Collection[str]
    ) -> list[Element]:
        joint = f"{name}_mount"
        while joint in joints:
            joint += "_"
        body = self._link[frame.body().index()]
        return [
            Element("link", name=name),
            joint_element(joint, "fixed", body, name, _pose(frame)),
        ]


def _pose(frame: Frame) -> RigidTransform:
    return frame.GetFixedPoseInBodyFrame()
