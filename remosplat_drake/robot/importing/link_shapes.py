"""Converts the meshes of a URDF for drawing and collisions in Drake.

Visual meshes become .gltf files, which contain their colours. Collision meshes
become convex pieces, initially one for each mesh.
"""

import hashlib
import re
import shutil
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING
from xml.etree.ElementTree import Element, SubElement

import numpy as np

from remosplat_drake.base.atomic_file import write_atomically
from remosplat_drake.base.errors import FieldError, RemoSplatError
from remosplat_drake.base.system_libraries import import_optional
from remosplat_drake.robot.fitting.convex_pieces import ConvexPiece
from remosplat_drake.robot.fitting.enclosing_piece import Enclosed
from remosplat_drake.robot.importing.findings import Findings, listed
from remosplat_drake.robot.importing.mesh_files import load_mesh
from remosplat_drake.robot.importing.packages import Packages
from remosplat_drake.robot.importing.urdf import Urdf
from remosplat_drake.robot.importing.urdf_elements import origin_pose
from remosplat_drake.robot.meshes import drawable

if TYPE_CHECKING:
    import trimesh

_PIECES = "meshes/collision"
"""Folder of the files with convex pieces, relative to the model's folder."""

_LARGEST = 20.0
"""A mesh that is larger than this is assumed to be in another unit [m]."""

_GREY = (0.7, 0.71, 0.73, 1.0)


def convert_shapes(
    urdf: Urdf,
    packages: Packages,
    folder: Path,
    findings: Findings,
    on_mesh: Callable[[], None] = lambda: None,
) -> dict[str, list[Enclosed]]:
    """Converts all meshes of a URDF, and names the new files in its elements.

    Links without collision meshes get the convex hulls of their visual meshes.
    They keep their collision primitives, which are often smaller than the link.

    Args:
        urdf: The robot; its links' elements are changed.
        packages: Resolves references to ROS packages.
        folder: Folder in which a folder `meshes` is made.
        findings: Receives the guesses.
        on_mesh: Function that is called after each mesh.

    Returns:
        The collision meshes by link name, in the link's frame; links without
        collision meshes are omitted.

    Raises:
        FieldError: A mesh is missing, flat, unreadable or has an unusable
            scale.
        MissingExtraError: The packages that convert meshes are not installed.
    """
    if next(urdf.root.iter("mesh"), None) is not None:
        import_optional("trimesh", "converting meshes", "robots")
    converter = _Converter(urdf, packages, folder, on_mesh)
    _resolve_materials(urdf.root)
    covered = []
    for name, link in urdf.links.items():
        # Primitives are often smaller than the link, and a controller must not
        # ignore the uncovered part of the link.
        if link.find("collision/geometry/mesh") is None:
            bare = link.find("collision") is None
            seen = link.findall("visual")
            if not bare:
                meshes = (
                    v for v in seen if v.find("geometry/mesh") is not None
                )
                seen = list(meshes)
            link.extend([_as_collision(visual) for visual in seen])
            covered += [name] * bool(seen)
        for kind in ("visual", "collision"):
            for i, element in enumerate(link.findall(kind)):
                converter.convert(name, element, i)
    meshes = {
        name: [Enclosed.make(surface) for surface in surfaces]
        for name, surfaces in converter.surfaces.items()
    }
    hulls = {name: [x.piece for x in own] for name, own in meshes.items()}
    write_pieces(urdf, folder, hulls)
    if converter.count:
        findings.find("meshes", f"{converter.count} converted")
    if covered:
        findings.guess(
            "collision shapes",
            "convex hulls of visual meshes, in addition to primitives, for "
            f"{listed(covered)}",
        )
    return meshes


def write_pieces(
    urdf: Urdf, folder: Path, pieces: dict[str, list[ConvexPiece]]
) -> None:
    """Writes convex pieces as collision shapes of links; keeps primitives.

    Args:
        urdf: The robot; its links' elements are changed.
        folder: Folder for the pieces' files; earlier files of pieces are
            deleted.
        pieces: The pieces of links by name, in their frames.
    """
    for link in urdf.links.values():
        for collision in link.findall("collision"):
            mesh = collision.find("geometry/mesh")
            if mesh is not None and _PIECES in mesh.get("filename", ""):
                link.remove(collision)
    shutil.rmtree(folder / _PIECES, ignore_errors=True)
    for name, own in pieces.items():
        for i, piece in enumerate(own):
            file = f"{_PIECES}/{_plain(name)}_{i}.obj"
            text = piece.to_obj("A convex part of a link.")
            write_atomically(folder / file, text)
            collision = SubElement(urdf.links[name], "collision")
            geometry = SubElement(collision, "geometry")
            mesh = SubElement(geometry, "mesh", filename=file)
            SubElement(mesh, "{http://drake.mit.edu}declare_convex")


def _as_collision(visual: Element) -> Element:
    collision = Element("collision")
    collision.extend(
        _copy(child) for child in visual if child.tag in ("origin", "geometry")
    )
    return collision


def _copy(element: Element) -> Element:
    twin = Element(element.tag, element.attrib)
    twin.extend(_copy(child) for child in element)
    return twin


class _Converter:
    """Converts meshes, each file once.

    Attributes:
        surfaces: Triangles of the collision meshes by link name, in the link's
            frame, shape (t, 3, 3) each [m].
    """

    def __init__(
        self,
        urdf: Urdf,
        packages: Packages,
        folder: Path,
        on_mesh: Callable[[], None],
    ):
        self.surfaces: dict[str, list[np.ndarray]] = {}
        self._urdf = urdf
        self._packages = packages
        self._folder = folder
        self._on_mesh = on_mesh
        self._drawn: dict[tuple, str] = {}
        self._triangles: dict[tuple, np.ndarray] = {}
        self._loaded: dict[tuple, trimesh.Scene] = {}

    @property
    def count(self) -> int:
        return len(self._drawn) + len(self._triangles)

    def convert(self, link: str, element: Element, i: int) -> None:
        """Converts the mesh of one <visual> or <collision>, if it has one."""
        geometry = element.find("geometry")
        mesh = None if geometry is None else geometry.find("mesh")
        if mesh is None:
            return
        where = f"link {link!r} <{element.tag}> <mesh>"
        uri = mesh.get("filename")
        if not uri:
            raise self._urdf.fail(where, "has no filename=...")
        source = self._packages.resolve(uri, where)
        scale = self._scale(mesh, where)
        parent = self._urdf.links[link]
        parent.remove(element)
        try:
            if element.tag == "visual":
                name = f"meshes/visual/{_plain(f'{link}_{i}')}.gltf"
                file = self._draw(source, scale, element, name, where)
                parent.append(_naming(element, file))
            else:
                surface = self._surface(source, scale, where)
                X_LG = origin_pose(element).GetAsMatrix4()
                surface = surface @ X_LG[:3, :3].T + X_LG[:3, 3]
                self.surfaces.setdefault(link, []).append(surface)
        except FieldError:
            raise
        except RemoSplatError as error:
            raise self._urdf.fail(where, str(error)) from error

    def _draw(
        self,
        source: Path,
        scale: np.ndarray,
        visual: Element,
        name: str,
        where: str,
    ) -> str:
        """Returns the file for drawing, and writes it if it is new."""
        colour = _rgba(visual.find("material"))
        key = source, scale.tobytes(), colour
        if key not in self._drawn:
            scene = self._load(source, scale, where)
            if colour is None and source.suffix.lower() == ".stl":
                colour = _GREY
            write_atomically(self._folder / name, drawable(scene, colour))
            self._drawn[key] = name
            self._on_mesh()
        return self._drawn[key]

    def _surface(
        self, source: Path, scale: np.ndarray, where: str
    ) -> np.ndarray:
        """Returns the triangles of a mesh file in its own frame."""
        key = source, scale.tobytes()
        if key not in self._triangles:
            parts = self._load(source, scale, where).dump()
            self._triangles[key] = np.concatenate(
                [np.array(part.triangles) for part in parts]
            )
            self._on_mesh()
        return self._triangles[key]

    def _load(
        self, source: Path, scale: np.ndarray, where: str
    ) -> "trimesh.Scene":
        key = source, scale.tobytes()
        if key not in self._loaded:
            scene = load_mesh(source, scale)
            self._check_size(scene, source, scale, where)
            # Most links are drawn with the mesh with which they collide.
            self._loaded = {key: scene}
        return self._loaded[key]

    def _scale(self, mesh: Element, where: str) -> np.ndarray:
        text = mesh.get("scale", "1 1 1")
        try:
            scale = np.array([float(x) for x in text.split()])
        except ValueError:
            scale = np.zeros(0)
        if scale.shape != (3,) or not (np.isfinite(scale) & (scale != 0)).all():
            problem = f"expected three numbers that are not 0, got {text!r}"
            raise self._urdf.fail(f"{where} scale", problem)
        return scale

    def _check_size(
        self,
        scene: "trimesh.Scene",
        source: Path,
        scale: np.ndarray,
        where: str,
    ) -> None:
        size = scene.extents.max()
        if size > _LARGEST:
            raise self._urdf.fail(
                f"{where} scale",
                f"{source.name} is {size:.3g} m large with the scale"
                f" {' '.join(f'{x:g}' for x in scale)}; 0.001 0.001 0.001"
                " converts mm to m",
            )


def _naming(element: Element, file: str) -> Element:
    """Returns a copy of a <visual> with another mesh file."""
    twin = _copy(element)
    twin.attrib.clear()
    mesh = twin.find("geometry/mesh")
    assert mesh is not None
    mesh.attrib.clear()
    mesh.set("filename", file)
    return twin


def _resolve_materials(root: Element) -> None:
    """Writes each material's colour into its <visual>, without a name.

    Some files define a material's name several times, which Drake rejects, or
    use a name that another link defines.
    """
    colours: dict[str, tuple[float, ...]] = {}
    for material in [*root.findall("material"), *root.iter("material")]:
        rgba = _rgba(material)
        if rgba is not None:
            colours.setdefault(material.get("name", ""), rgba)
    for visual in root.iter("visual"):
        material = visual.find("material")
        if material is None:
            continue
        rgba = _rgba(material) or colours.get(material.get("name", ""))
        visual.remove(material)
        if rgba is not None:
            own = SubElement(visual, "material", name="")
            SubElement(own, "color", rgba=" ".join(f"{x:g}" for x in rgba))
    for material in root.findall("material"):
        root.remove(material)


def _rgba(material: Element | None) -> tuple[float, ...] | None:
    color = None if material is None else material.find("color")
    try:
        text = "" if color is None else color.get("rgba", "")
        rgba = tuple(min(max(float(x), 0.0), 1.0) for x in text.split())
    except ValueError:
        return None
    return rgba if len(rgba) == 4 else None


def _plain(name: str) -> str:
    """Returns a valid file name, different for different names."""
    plain = re.sub(r"[^\w.-]", "_", name)
    if plain != name:
        plain += "_" + hashlib.sha256(name.encode()).hexdigest()[:6]
    return plain
