"""Resolves `package://NAME/...` to the folders of ROS packages.

Packages are searched in the folders that the command line names, in the folders
above the robot's file, and on the paths of ROS 1 and ROS 2 workspaces.
"""

import dataclasses as dc
import os
from collections.abc import Iterator
from pathlib import Path
from xml.etree import ElementTree

from remosplat_drake.base.errors import FieldError, FileError

SCHEMES = ("package://", "model://")
"""Beginnings of the URIs that name a package."""

PATH_VARIABLES = (
    "ROS_PACKAGE_PATH",
    "AMENT_PREFIX_PATH",
    "COLCON_PREFIX_PATH",
    "GZ_SIM_RESOURCE_PATH",
    "GAZEBO_MODEL_PATH",
)
"""Environment variables that name folders with packages."""

_DEEPEST = 3
"""Packages are searched down to this depth below an entry of ROS_PACKAGE_PATH.
"""


@dc.dataclass(frozen=True)
class Packages:
    """Resolves the URIs in a robot's files to paths.

    Attributes:
        file: The robot's file.
        given: Folders of packages by name, which have precedence.
        variables: The environment, of which `PATH_VARIABLES` are used.
        guessed: Packages and files that were not at their stated places, and
            the places where they were found.
    """

    file: Path
    given: dict[str, Path] = dc.field(default_factory=dict)
    variables: dict[str, str] = dc.field(
        default_factory=lambda: dict(os.environ)
    )
    guessed: dict[str, Path] = dc.field(default_factory=dict)

    def resolve(self, uri: str, element: str) -> Path:
        """Returns the file that a URI stands for.

        Args:
            uri: A URI of a package, a `file://` URI, or a path relative to
                the robot's file.
            element: The element that names it, for errors.

        Raises:
            FieldError: There is no such package or file.
        """
        path = self.place(uri, element)
        if not path.is_file():
            problem = f"{uri}: no such file ({path})"
            raise FieldError(str(self.file), element, problem)
        return path

    def place(self, uri: str, element: str) -> Path:
        """Returns the file or folder of a URI; it need not exist.

        Args:
            uri: As for `resolve`.
            element: The element that names it, for errors.

        Raises:
            FieldError: There is no such package.
        """
        for scheme in SCHEMES:
            if uri.startswith(scheme):
                # Some files have three slashes.
                named = uri.removeprefix(scheme).lstrip("/")
                name, _, rest = named.partition("/")
                return self.folder(name, element, (rest,)) / rest
        path = Path(uri.removeprefix("file://"))
        place = self.file.parent / path
        if not place.exists():
            # The path may belong to another machine; its last parts often exist
            # on this machine.
            for i in range(1, len(path.parts)):
                near = self.file.parent.joinpath(*path.parts[i:])
                if near.is_file():
                    self.guessed[uri] = near
                    return near
        return place

    def folder(
        self, name: str, element: str, wanted: tuple[str, ...] = ()
    ) -> Path:
        """Returns the folder of a package.

        A package that is not found by its name is assumed to be the nearest
        folder above the file that contains the needed files, since
        manufacturers rename folders.

        Args:
            name: Name of the package.
            element: The element that names it, for errors.
            wanted: Files that the package must contain.

        Raises:
            FieldError: There is no such package.
        """
        for folder in self._candidates(name):
            if folder.is_dir():
                return folder
        for folder in self.file.absolute().parents:
            if any((folder / file).is_file() for file in wanted):
                self.guessed[name] = folder
                return folder
        raise FieldError(
            str(self.file),
            element,
            f"no package {name!r} above the file or in"
            f" {', '.join(PATH_VARIABLES)}; give --package {name}=DIR",
        )

    def _candidates(self, name: str) -> Iterator[Path]:
        if name in self.given:
            yield self.given[name]
            return
        if name in self.guessed:
            yield self.guessed[name]
        above = list(self.file.absolute().parents)
        for folder in above:
            if package_name(folder) == name:
                yield folder
        for folder in above:
            if folder.name == name:
                yield folder
        for folder in above:
            yield folder / name
        for variable in PATH_VARIABLES:
            for entry in self.variables.get(variable, "").split(os.pathsep):
                if entry:
                    yield from _in_entry(Path(entry), name)


def _in_entry(entry: Path, name: str) -> Iterator[Path]:
    """Possible places of a package in an entry of a path variable."""
    yield entry / "share" / name
    yield entry / name / "share" / name
    level = [entry]
    for _ in range(_DEEPEST):
        for folder in level:
            if package_name(folder) == name or folder.name == name:
                yield folder
        level = [
            child
            for folder in level
            if folder.is_dir() and package_name(folder) is None
            for child in sorted(folder.iterdir())
            if child.is_dir()
        ]
    yield from (folder for folder in level if folder.name == name)


def package_name(folder: Path) -> str | None:
    """Returns the name in a folder's package.xml; None without such a file."""
    try:
        root = ElementTree.parse(folder / "package.xml").getroot()
    except (OSError, ElementTree.ParseError):
        return None
    return (root.findtext("name") or "").strip() or None


def given_packages(texts: list[str]) -> dict[str, Path]:
    """Reads flags of the form NAME=DIR.

    Args:
        texts: The flags' values.

    Raises:
        FieldError: A text has another form.
        FileError: A folder does not exist.
    """
    packages = {}
    for text in texts:
        name, _, folder = text.partition("=")
        if not (name and folder):
            raise FieldError("--package", text, "expected NAME=DIR")
        packages[name] = Path(folder).expanduser()
        if not packages[name].is_dir():
            raise FileError(folder, "no such folder (--package)")
    return packages
