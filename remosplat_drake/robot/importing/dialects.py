"""File formats of robots, with texts about each format for errors."""

import dataclasses as dc


@dc.dataclass(frozen=True)
class Dialect:
    """A file format of robots, with texts for errors and findings.

    Attributes:
        title: Name of the format.
        suffix: File name suffix by which Drake recognises the format.
        limit: Name of the element with a joint's limits.
        limits: Advice on how to write a joint's limits.
        fixed: Element that fixes a joint.
        weld: Element that fixes one link to another.
        mimic: Element that makes a joint follow another joint.
    """

    title: str
    suffix: str
    limit: str
    limits: str
    fixed: str
    weld: str
    mimic: str


URDF = Dialect(
    "URDF",
    ".urdf",
    "<limit>",
    "write <limit lower=... upper=.../>",
    "write type='fixed'",
    "a <joint type='fixed'>",
    "<mimic>",
)

SDFORMAT = Dialect(
    "SDFormat",
    ".sdf",
    "<limit>",
    "write <limit><lower>...</lower><upper>...</upper></limit> in its <axis>",
    "write type='fixed'",
    "a <joint type='fixed'>",
    "<mimic>",
)

MJCF = Dialect(
    "MuJoCo MJCF",
    ".xml",
    "range",
    "write range='... ...'",
    "remove the <joint>",
    "a <body> that holds both",
    "<equality> <joint>",
)

DIRECTIVES = Dialect(
    "Drake model directives",
    ".dmd.yaml",
    "limits",
    "give it limits in its model's file",
    "make it fixed in its model's file",
    "an add_weld",
    "mimic",
)
