"""Copies a robot's files into a form that Drake's parser reads.

Drake's parser does not search ROS workspaces, and reads only .obj, .vtk and
.gltf meshes. In a copy, files have absolute paths, and meshes are converted.
Loops, and joints that follow other joints, are removed from the copies and
recorded, since Drake's plants represent them differently from URDF.
"""

import dataclasses as dc
from collections.abc import Iterable
from pathlib import Path
from xml.etree import ElementTree
from xml.etree.ElementTree import Element

import numpy as np
import yaml

from remosplat_drake.base.errors import (
    FieldError,
    FileError,
    RemoSplatError,
    unknown_name,
)
from remosplat_drake.base.system_libraries import import_optional
from remosplat_drake.base.yaml_nodes import compose, fields
from remosplat_drake.robot.importing.dialects import (
    DIRECTIVES,
    MJCF,
    SDFORMAT,
    URDF,
    Dialect,
)
from remosplat_drake.robot.importing.mesh_files import load_mesh
from remosplat_drake.robot.importing.missing_meshes import (
    COLLISION,
    VISUAL,
    replace_by_others,
)
from remosplat_drake.robot.importing.mjcf import prepare_mjcf
from remosplat_drake.robot.importing.packages import Packages
from remosplat_drake.robot.importing.urdf import Loop, Mimic, parse_xml

_ROOTS = {"robot": URDF, "sdf": SDFORMAT, "mujoco": MJCF}

_DIRECTIVES = (
    "add_collision_filter_group",
    "add_directives",
    "add_frame",
    "add_model",
    "add_model_instance",
    "add_weld",
)

_READ_BY_DRAKE = (".obj", ".vtk", ".gltf")


def dialect_of(path: Path, text: str) -> Dialect:
    """Recognises the robot format of a file by its content.

    Args:
        path: The file, for errors.
        text: Text of the file.

    Raises:
        FileError: The file has none of the supported formats.
    """
    if text.lstrip().startswith("<"):
        root = parse_xml(path, text)
        if root.tag in _ROOTS:
            return _ROOTS[root.tag]
        known = ", ".join(f"<{tag}>" for tag in _ROOTS)
        raise FileError(path, f"expected {known}, got <{root.tag}>")
    if path.suffix.lower() in (".yaml", ".yml"):
        if "directives" in fields(compose(text, str(path)), ""):
            return DIRECTIVES
        raise FileError(path, "expected Drake's `directives:`")
    raise FileError(
        path, "expected URDF, xacro, SDFormat, MJCF or Drake model directives"
    )


def read_robot_text(path: Path) -> str:
    """Reads a robot's file (UTF-8).

    Raises:
        FileError: The file is missing or is not text.
    """
    if not path.is_file():
        raise FileError(path, "no such file")
    try:
        return path.read_text(encoding="utf-8-sig")
    except (OSError, UnicodeDecodeError) as error:
        raise FileError(path, f"cannot be read: {error}") from error


class Staging:
    """Makes copies of a robot's files and of all files that they name.

    Attributes:
        originals: The file that each copy was made from.
        mimics: Joints that follow other joints, keyed by their names in the
            original files.
        loops: Elements that close loops of links.
        states: Positions of joints by name, for each named state [rad, m].
        replaced: Names of the links with missing meshes, by the kind of mesh.
        floating: Names of the floating links, which have been fixed.
    """

    def __init__(self, packages: Packages, folder: Path):
        """Prepares the folder; does not copy files yet.

        Args:
            packages: Resolves references to ROS packages.
            folder: An empty folder for the copies.
        """
        self._packages = packages
        self._folder = folder
        self._copies: dict[Path, Path | None] = {}
        self.originals: dict[Path, Path] = {}
        self.mimics: dict[str, Mimic] = {}
        self.loops: list[Loop] = []
        self.states: dict[str, dict[str, float]] = {}
        self.replaced: dict[str, list[str]] = {VISUAL: [], COLLISION: []}
        self.floating: list[str] = []

    def stage(self, path: Path) -> Path:
        """Copies a robot's file of any format except xacro; returns the copy.

        Args:
            path: The file.

        Raises:
            RemoSplatError: The file, or a file that it names, is missing or
                unusable.
        """
        path = path.absolute()
        if path not in self._copies:
            self._copies[path] = None  # The copy is in progress.
            text = read_robot_text(path)
            dialect = dialect_of(path, text)
            if dialect is DIRECTIVES:
                text = self._directives(path, text)
            else:
                root = parse_xml(path, text)
                if dialect is SDFORMAT:
                    self._sdf(path, root)
                elif dialect is MJCF:
                    self._mjcf(path, root)
                else:
                    self._urdf(path, root)
                text = ElementTree.tostring(root, encoding="unicode")
            copy = self._new(path, dialect.suffix)
            copy.write_text(text, encoding="utf-8")
            self._copies[path] = copy
        copy = self._copies[path]
        if copy is None:
            raise FileError(path, "includes itself")
        return copy

    def in_originals(self, text: str) -> str:
        """Replaces names of copies in a text by names of the originals."""
        for copy, original in self.originals.items():
            text = text.replace(str(copy), str(original))
        return text

    def drop_elements(self, parent: str, tag: str) -> bool:
        """Removes elements from all copies of SDFormat files.

        Args:
            parent: Tag of the parent elements.
            tag: Tag of the elements.

        Returns:
            Whether any element was removed.
        """
        count = 0
        for copy in self.originals:
            if copy.suffix != SDFORMAT.suffix:
                continue
            tree = ElementTree.parse(copy)
            for holder in tree.iter(parent):
                for element in holder.findall(tag):
                    holder.remove(element)
                    count += 1
            tree.write(copy, encoding="unicode")
        return count > 0

    def _new(self, path: Path, suffix: str) -> Path:
        folder = self._folder / str(len(self.originals))
        folder.mkdir()
        # Drake names models after their files.
        copy = folder / (path.name.partition(".")[0] + suffix)
        self.originals[copy] = path
        return copy

    def _find(self, path: Path, uri: str, where: str) -> Path:
        packages = dc.replace(self._packages, file=path)
        return packages.resolve(uri, where).absolute()

    def _mesh(self, path: Path, uri: str, where: str) -> str:
        """Returns the name of a converted mesh that Drake reads."""
        source = self._find(path, uri, where)
        if source.suffix.lower() in _READ_BY_DRAKE:
            return str(source)
        if source not in self._copies:
            import_optional("trimesh", "converting meshes", "robots")
            try:
                mesh = load_mesh(source, np.ones(3)).to_geometry()
            except RemoSplatError as error:
                raise FieldError(str(path), where, str(error)) from error
            copy = self._new(source, ".obj")
            mesh.export(copy, include_normals=False, include_texture=False)
            self._copies[source] = copy
        return str(self._copies[source])

    def _replace_missing(self, path: Path, links: Iterable[Element]) -> None:
        """Removes missing meshes from links."""

        def is_there(element: Element) -> bool:
            for mesh in element.iter("mesh"):
                uri = mesh.get("filename") or mesh.findtext("uri", "")
                try:
                    self._find(path, uri.strip(), "<mesh>")
                except FieldError:
                    return False
            return True

        for tag, names in replace_by_others(links, is_there).items():
            self.replaced[tag] += names

    def _urdf(self, path: Path, root: Element) -> None:
        self._replace_missing(path, root.iter("link"))
        for mesh in root.iter("mesh"):
            uri = mesh.get("filename", "")
            mesh.set("filename", self._mesh(path, uri, "<mesh> filename"))
        for joint in root.iter("joint"):
            for mimic in joint.findall("mimic"):
                self.mimics[joint.get("name", "")] = Mimic(
                    mimic.get("joint", ""),
                    mimic.get("multiplier", "1"),
                    mimic.get("offset", "0"),
                )
                joint.remove(mimic)

    def _sdf(self, path: Path, root: Element) -> None:
        for include in root.iter("include"):
            for uri in include.findall("uri"):
                model = self._sdf_model(path, (uri.text or "").strip())
                uri.text = f"file://{self.stage(model)}"
        self._replace_missing(path, root.iter("link"))
        for mesh in root.iter("mesh"):
            for uri in mesh.findall("uri"):
                name = (uri.text or "").strip()
                uri.text = self._mesh(path, name, "<mesh> <uri>")
        for joint in root.iter("joint"):
            for axis in joint.findall("axis"):
                for mimic in axis.findall("mimic"):
                    self.mimics[joint.get("name", "")] = _sdf_mimic(mimic)
                    axis.remove(mimic)

    def _sdf_model(self, path: Path, uri: str) -> Path:
        """Returns the file of an <include>, which often names a folder."""
        where = f"<include> <uri> {uri}"
        packages = dc.replace(self._packages, file=path)
        folder = packages.place(uri, where)
        if not folder.is_dir():
            return self._find(path, uri, where)
        try:
            config = ElementTree.parse(folder / "model.config").getroot()
        except (OSError, ElementTree.ParseError) as error:
            problem = f"{folder} has no usable model.config: {error}"
            raise FieldError(str(path), where, problem) from error
        names = [(sdf.text or "").strip() for sdf in config.findall("sdf")]
        if not names:
            problem = f"{folder}/model.config names no <sdf>"
            raise FieldError(str(path), where, problem)
        # The last entry is for the newest version of the format.
        return folder / names[-1]

    def _mjcf(self, path: Path, root: Element) -> None:
        said = prepare_mjcf(
            path, root, lambda uri: self._mesh(path, uri, "<asset> <mesh> file")
        )
        self.loops += said.loops
        self.states |= said.states
        self.mimics |= said.mimics
        self.floating += said.floating

    def _directives(self, path: Path, text: str) -> str:
        root = compose(text, str(path))
        _, listed = fields(root, "")["directives"]
        for i, directive in enumerate(_items(listed)):
            where = f"directives[{i}]"
            for kind, (_, node) in fields(directive, where).items():
                if kind not in _DIRECTIVES:
                    problem = unknown_name("directive", kind, _DIRECTIVES)
                    raise FieldError(str(path), where, problem)
                if kind not in ("add_model", "add_directives"):
                    continue
                _, file = fields(node, f"{where}.{kind}").get(
                    "file", (None, None)
                )
                if isinstance(file, yaml.ScalarNode):
                    where = f"{where}.{kind}.file"
                    model = self._find(path, file.value, where)
                    file.value = f"file://{self.stage(model)}"
        return yaml.serialize(root)


def _sdf_mimic(mimic: Element) -> Mimic:
    return Mimic(
        mimic.get("joint", ""),
        mimic.findtext("multiplier", "1").strip(),
        mimic.findtext("offset", "0").strip(),
    )


def _items(node: yaml.Node) -> list[yaml.Node]:
    return node.value if isinstance(node, yaml.SequenceNode) else []
