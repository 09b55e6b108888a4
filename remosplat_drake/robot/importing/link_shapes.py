"""The meshes of a URDF's links, converted to what Drake draws and collides.

Visual meshes become .gltf files, which carry their colours. Collision meshes
are cut into slabs and become their hulls: Drake would take the hull of the
whole, in which there is much air.
"""

import hashlib
import re
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING
from xml.etree.ElementTree import Element, SubElement

import numpy as np

from remosplat_drake.base.atomic_file import write_atomically
from remosplat_drake.base.errors import RemoSplatError
from remosplat_drake.base.system_libraries import import_optional
from remosplat_drake.robot.fitting.slabs import convex_slabs
from remosplat_drake.robot.importing.findings import Findings, listed
from remosplat_drake.robot.importing.mesh_files import load_mesh
from remosplat_drake.robot.importing.packages import Packages
from remosplat_drake.robot.importing.urdf import Urdf
from remosplat_drake.robot.meshes import drawable

if TYPE_CHECKING:
    import trimesh

_HULL_TOLERANCE = 2e-4
"""How far a mesh may stand out of its hull, which saves corners [m]."""

_LARGEST = 20.0
"""Size from which on a mesh is taken to be in another unit [m]."""

_GREY = (0.7, 0.71, 0.73, 1.0)


def convert_shapes(
    urdf: Urdf,
    packages: Packages,
    folder: Path,
    findings: Findings,
    on_mesh: Callable[[], None] = lambda: None,
) -> None:
    """Converts all meshes of a URDF, and names the new files in its elements.

    Links without collision meshes get the hulls of what is seen of them,
    besides the primitives that they have: these are often less than the link.

    Args:
        urdf: The robot; its links' elements are changed.
        packages: Finds the files that it names.
        folder: Folder that gets a folder `meshes`.
        findings: Where it is noted what was made up.
        on_mesh: Called after each mesh.

    Raises:
        FieldError: A mesh is missing, unreadable or has an unusable scale.
        MissingExtraError: The packages that convert meshes are not installed.
    """
    if next(urdf.root.iter("mesh"), None) is not None:
        import_optional("trimesh", "converting meshes", "robots")
    converter = _Converter(urdf, packages, folder, on_mesh)
    _resolve_materials(urdf.root)
    covered = []
    for name, link in urdf.links.items():
        # Primitives often stand for less than the link: no controller may
        # overlook the rest.
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
                where = f"link {name!r} <{kind}>"
                converter.convert(link, element, where, f"{name}_{i}")
    if converter.count:
        findings.find("meshes", f"{converter.count} converted")
    if covered:
        findings.guess(
            "collision shapes",
            "hulls of what is seen, besides primitives if any, of"
            f" {listed(covered)}",
        )


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
    """Converts meshes, each file once."""

    def __init__(
        self,
        urdf: Urdf,
        packages: Packages,
        folder: Path,
        on_mesh: Callable[[], None],
    ):
        self._urdf = urdf
        self._packages = packages
        self._folder = folder
        self._on_mesh = on_mesh
        self._written: dict[tuple, list[str]] = {}

    @property
    def count(self) -> int:
        return len(self._written)

    def convert(
        self,
        link: Element,
        element: Element,
        where: str,
        name: str,
    ) -> None:
        """Converts the mesh of one <visual> or <collision>, if it has one."""
        geometry = element.find("geometry")
        mesh = None if geometry is None else geometry.find("mesh")
        if mesh is None:
            return
        uri = mesh.get("filename")
        if not uri:
            raise self._urdf.fail(f"{where} <mesh>", "has no filename=...")
        source = self._packages.resolve(uri, f"{where} <mesh>")
        scale, visual = self._scale(mesh, where), element.tag == "visual"
        colour = _rgba(element.find("material")) if visual else None
        key = (element.tag, source, scale.tobytes(), colour)
        if key not in self._written:
            try:
                scene = load_mesh(source, scale)
            except RemoSplatError as error:
                raise self._urdf.fail(f"{where} <mesh>", str(error)) from error
            self._check_size(scene, source, scale, where)
            files = _drawn(scene, source, colour) if visual else _cut(scene)
            self._written[key] = []
            for ending, data in files.items():
                file = f"meshes/{element.tag}/{_plain(name)}{ending}"
                write_atomically(self._folder / file, data)
                self._written[key].append(file)
            self._on_mesh()
        link.remove(element)
        for file in self._written[key]:
            link.append(_naming(element, file))

    def _scale(self, mesh: Element, where: str) -> np.ndarray:
        text = mesh.get("scale", "1 1 1")
        try:
            scale = np.array([float(x) for x in text.split()])
        except ValueError:
            scale = np.zeros(0)
        if scale.shape != (3,) or not (np.isfinite(scale) & (scale != 0)).all():
            problem = f"expected three numbers that are not 0, got {text!r}"
            raise self._urdf.fail(f"{where} <mesh> scale", problem)
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
                f"{where} <mesh> scale",
                f"{source.name} is {size:.3g} m large with"
                f" {' '.join(f'{x:g}' for x in scale)}; 0.001 0.001 0.001"
                " turns mm into m",
            )


def _drawn(
    scene: "trimesh.Scene", source: Path, colour: tuple[float, ...] | None
) -> dict[str, bytes | str]:
    """The file that is drawn, by its ending."""
    if colour is None and source.suffix.lower() == ".stl":
        colour = _GREY
    return {".gltf": drawable(scene, colour)}


def _cut(scene: "trimesh.Scene") -> dict[str, bytes | str]:
    """The files of the convex parts, by their endings."""
    import trimesh

    surface = np.concatenate(
        [
            part.triangles
            for part in scene.dump()
            if isinstance(part, trimesh.Trimesh)
        ]
    )
    return {
        f"_{i}.obj": piece.to_obj("A convex part of a link.")
        for i, piece in enumerate(convex_slabs(surface, _HULL_TOLERANCE))
    }


def _naming(element: Element, file: str) -> Element:
    """A twin of a <visual> or <collision> whose mesh is another file."""
    twin = _copy(element)
    twin.attrib.clear()
    mesh = twin.find("geometry/mesh")
    assert mesh is not None
    mesh.attrib.clear()
    mesh.set("filename", file)
    if twin.tag == "collision":
        SubElement(mesh, "{http://drake.mit.edu}declare_convex")
    return twin


def _resolve_materials(root: Element) -> None:
    """Has each <visual> say its colour itself, without a name.

    Files define one name in several ways, which Drake refuses, or name what
    another link defines.
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
    """A name that any file system takes, different for different names."""
    plain = re.sub(r"[^\w.-]", "_", name)
    if plain != name:
        plain += "_" + hashlib.sha256(name.encode()).hexdigest()[:6]
    return plain
