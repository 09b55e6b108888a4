"""`MakerMeshes`: the meshes of a maker's file, whose distances FCL measures."""

import tempfile
from collections.abc import Collection
from pathlib import Path
from types import ModuleType
from xml.etree.ElementTree import Element

import numpy as np
from pydrake.math import RigidTransform

from remosplat_drake.base.errors import RemoSplatError
from remosplat_drake.robot.fitting.enclosing_piece import Enclosed
from remosplat_drake.robot.fitting.kernels.winding import is_inside
from remosplat_drake.robot.fitting.mesh_truth import NEAR
from remosplat_drake.robot.importing.findings import Findings
from remosplat_drake.robot.importing.link_shapes import convert_shapes
from remosplat_drake.robot.importing.packages import Packages
from remosplat_drake.robot.importing.sources import read_robot
from remosplat_drake.robot.importing.srdf import find_srdf, read_srdf
from remosplat_drake.robot.importing.urdf import FIXED, Urdf
from remosplat_drake.robot.importing.urdf_elements import origin_pose


class MakerMeshes:
    """The surfaces of a robot's links in its maker's file.

    Links of the file that the robot lacks count as parts of the links to which
    they are fixed.

    Attributes:
        triangles: The triangles of each link that has shapes, in its frame,
            shape (t, 3, 3) [m].
        states: Positions of joints by name, for each state that the files name
            [rad, m].
    """

    def __init__(
        self,
        source: Path,
        links: Collection[str],
        left_out: Collection[str] = (),
    ):
        """Reads the collision shapes that a robot's file names.

        Args:
            source: The robot's file.
            links: Names of the links that the robot has.
            left_out: Links of the file that the robot lacks.

        Raises:
            RemoSplatError: The file or a mesh cannot be read, or FCL is
                missing.
        """
        self._fcl = _import_fcl()
        packages = Packages(source, {})
        urdf, said = read_robot(source, packages, {}, Findings())
        for name, link in urdf.links.items():
            if name in left_out:
                for shape in [
                    *link.findall("visual"),
                    *link.findall("collision"),
                ]:
                    link.remove(shape)
            elif link.find("collision/geometry/mesh") is not None:
                for visual in link.findall("visual"):
                    link.remove(visual)
        with tempfile.TemporaryDirectory() as folder:
            meshes = convert_shapes(urdf, packages, Path(folder), Findings())
        self.triangles = _joined(urdf, meshes, links)
        path = find_srdf(source, urdf.name)
        self.states = (said if path is None else read_srdf(path, urdf)).states
        self._models = {
            link: _bvh(self._fcl, own) for link, own in self.triangles.items()
        }

    def distance(
        self, links: tuple[str, str], X_WA: np.ndarray, X_WB: np.ndarray
    ) -> float:
        """Measures the distance of two links [m].

        Args:
            links: Names of the links.
            X_WA: Pose of the first, shape (4, 4).
            X_WB: Pose of the second, shape (4, 4).

        Returns:
            The distance; zero if they intersect, or if one contains the other.
        """
        fcl = self._fcl
        request = fcl.DistanceRequest(enable_nearest_points=True)
        result = fcl.DistanceResult()
        placed = self._placed(links, X_WA, X_WB)
        distance = fcl.distance(*placed, request, result)
        if not 0.0 < distance < NEAR:
            return max(distance, 0.0)
        p_WA, p_WB = result.nearest_points
        p_A = (p_WB - X_WA[:3, 3]) @ X_WA[:3, :3]
        p_B = (p_WA - X_WB[:3, 3]) @ X_WB[:3, :3]
        inside = is_inside(p_A, self.triangles[links[0]])
        inside |= is_inside(p_B, self.triangles[links[1]])
        return 0.0 if inside else distance

    def intersect(
        self, links: tuple[str, str], X_WA: np.ndarray, X_WB: np.ndarray
    ) -> bool:
        """Returns whether the surfaces of two links intersect.

        Args:
            links: Names of the links.
            X_WA: Pose of the first, shape (4, 4).
            X_WB: Pose of the second, shape (4, 4).
        """
        placed = self._placed(links, X_WA, X_WB)
        return bool(self._fcl.collide(*placed))

    def _placed(
        self, links: tuple[str, str], X_WA: np.ndarray, X_WB: np.ndarray
    ) -> list[object]:
        """Returns the meshes of two links as FCL's objects."""
        fcl = self._fcl
        return [
            fcl.CollisionObject(
                self._models[link], fcl.Transform(X[:3, :3], X[:3, 3])
            )
            for link, X in zip(links, (X_WA, X_WB), strict=True)
        ]


def _import_fcl() -> ModuleType:
    try:
        import fcl
    except ModuleNotFoundError as error:
        problem = "true_shapes needs python-fcl: pip install python-fcl"
        raise RemoSplatError(problem) from error
    return fcl


def _bvh(fcl: ModuleType, triangles: np.ndarray) -> object:
    model = fcl.BVHModel()
    model.beginModel(len(triangles), 3 * len(triangles))
    corners = np.arange(3 * len(triangles)).reshape(-1, 3)
    model.addSubModel(triangles.reshape(-1, 3), corners)
    model.endModel()
    return model


def _joined(
    urdf: Urdf, meshes: dict[str, list[Enclosed]], links: Collection[str]
) -> dict[str, np.ndarray]:
    """The triangles of all shapes of the links that a robot has."""
    parts: dict[str, list[np.ndarray]] = {}
    for name, link in urdf.links.items():
        carrier, X_CL = _carrier(urdf, name, links)
        if carrier is None:
            continue
        surfaces = [mesh.surface for mesh in meshes.get(name, [])]
        own = [
            _moved(triangles, X_CL)
            for triangles in (*surfaces, *_primitives(link))
        ]
        if own:
            parts.setdefault(carrier, []).extend(own)
    return {link: np.concatenate(own) for link, own in parts.items()}


def _carrier(
    urdf: Urdf, link: str, links: Collection[str]
) -> tuple[str | None, RigidTransform]:
    """The first of some links to which a link is fixed, and its pose there."""
    X_CL = RigidTransform()
    while link not in links:
        joint = urdf.inboard.get(link)
        if joint is None or joint.kind != FIXED:
            return None, X_CL
        X_CL = origin_pose(joint.element) @ X_CL
        link = joint.parent
    return link, X_CL


def _moved(triangles: np.ndarray, X: RigidTransform) -> np.ndarray:
    return triangles @ X.rotation().matrix().T + X.translation()


def _primitives(link: Element) -> list[np.ndarray]:
    """The triangles of the shapes of a link that are no meshes."""
    found = []
    for collision in link.findall("collision"):
        for shape in collision.iterfind("geometry/*"):
            surface = _primitive(shape)
            if surface is not None:
                found.append(_moved(surface, origin_pose(collision)))
    return found


def _primitive(shape: Element) -> np.ndarray | None:
    from trimesh import creation

    def number(key: str) -> float:
        return float(shape.get(key, "nan"))

    match shape.tag.rpartition("}")[2]:
        case "box":
            size = [float(x) for x in shape.get("size", "").split()]
            solid = creation.box(size)
        case "sphere":
            solid = creation.icosphere(4, number("radius"))
        case "cylinder":
            solid = creation.cylinder(number("radius"), number("length"), 64)
        case "capsule":
            solid = creation.capsule(
                number("length"), number("radius"), (64, 64)
            )
        case "ellipsoid":
            solid = creation.icosphere(4, 1.0)
            solid.apply_scale([number(key) for key in "abc"])
        case _:
            return None
    return np.array(solid.triangles)
