"""Reads disabled collisions of pairs of links from an SRDF file."""

import xml.etree.ElementTree as ET
from pathlib import Path

from remosplat_drake.base.errors import FileError
from remosplat_drake.base.reading import reads_file


@reads_file
def read_disabled_collisions(path: Path) -> list[tuple[str, str]]:
    """Reads the pairs of links whose collisions an SRDF file disables.

    Args:
        path: The file, which contains elements such as `<disable_collisions
            link1="a" link2="b" reason="Never"/>`.

    Raises:
        FileError: The file cannot be read, is not an SRDF, or an element
            lacks a link.
    """
    try:
        root = ET.fromstring(Path(path).read_bytes())
    except (OSError, ET.ParseError, ValueError) as error:
        raise FileError(path, f"is not an SRDF file: {error}") from error
    if root.tag != "robot":
        problem = f"is not an SRDF file: its root is <{root.tag}>, not <robot>"
        raise FileError(path, problem)
    pairs = []
    for i, element in enumerate(root.iter("disable_collisions"), start=1):
        links = element.get("link1", ""), element.get("link2", "")
        if not all(links):
            missing = "link2" if links[0] else "link1"
            problem = f"<disable_collisions> number {i} has no {missing}"
            raise FileError(path, problem)
        pairs.append(links)
    return pairs
