"""The robots and launch files of the guide to ROS 2."""

import dataclasses as dc
import re
import shlex
import xml.etree.ElementTree as ElementTree
from pathlib import Path

GUIDE = Path(__file__).parents[1] / "docs/guides/ros2_launch.md"


@dc.dataclass(frozen=True)
class Section:
    """A robot of the guide.

    Attributes:
        name: First word of its heading.
        hardware: The scenario's `hardware`, as YAML.
        launch: The launch file, as XML.
    """

    name: str
    hardware: str
    launch: str

    @property
    def commands(self) -> list[list[str]]:
        """Command lines of the programs that the launch file starts."""
        root = ElementTree.fromstring(self.launch)
        return [
            shlex.split(element.attrib["cmd"])
            for element in root.iter("executable")
        ]


SECTIONS = {
    name: Section(name, hardware, launch)
    for name, hardware, launch in re.findall(
        r"^## (\w+).*?```yaml\n(.*?)```.*?```xml\n(.*?)```",
        GUIDE.read_text(),
        re.M | re.S,
    )
}
"""Its sections, by their names."""
