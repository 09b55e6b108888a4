"""File formats of robots, and the advice to mend a file of each."""

import dataclasses as dc


@dc.dataclass(frozen=True)
class Dialect:
    """A format of robots, as errors and findings speak of it.

    Attributes:
        title: Its name.
        suffix: Ending by which Drake knows such a file.
        limit: The element by which a joint has limits.
        limits: Element with a joint's limits.
        fixed: Element that fixes a joint.
        weld: Element that fixes one link to another.
        mimic: The element by which a joint follows another.
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
