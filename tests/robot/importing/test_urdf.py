"""Parts of a URDF that cannot be driven, reported in one line."""

from pathlib import Path

import pytest

from remosplat_drake.base.errors import RemoSplatError
from remosplat_drake.robot.importing.urdf import Urdf

LINKS = '<link name="a"/><link name="b"/><link name="c"/>'


def joint(
    name: str, parent: str, child: str, kind: str = "revolute", inner: str = ""
) -> str:
    return (
        f'<joint name="{name}" type="{kind}"><parent link="{parent}"/>'
        f'<child link="{child}"/>{inner}</joint>'
    )


def urdf(*elements: str) -> Urdf:
    return Urdf(Path("arm.urdf"), f"<robot>{''.join(elements)}</robot>")


def test_a_chain_is_read():
    robot = urdf(
        LINKS,
        joint(
            "j", "a", "b", inner='<limit lower="-1" upper="2" velocity="3"/>'
        ),
        joint("k", "b", "c", "fixed"),
    )
    assert (robot.name, robot.base) == ("arm", "a")
    j, k = robot.chain("c")
    assert (j.lower, j.upper, j.velocity) == (-1, 2, 3)
    assert (j.moves, k.moves) == (True, False)


BAD = {
    "broken XML": ("<link", "arm.urdf: is broken XML: .*line 1, column"),
    "no links": ("", "<robot> has no <link>"),
    "a link without a name": ("<link/>", "link 1: has no name"),
    "two links of a name": (
        '<link name="a"/><link name="a"/>',
        "link 'a': occurs twice",
    ),
    "two roots": (LINKS, "link 'b': has no parent joint, and neither has 'a'"),
    "two parents": (
        LINKS
        + joint("j", "a", "b")
        + joint("k", "b", "c")
        + joint("l", "a", "c"),
        "link 'c': is the child of 'k' and of 'l': a loop",
    ),
    "a circle": (
        LINKS + joint("j", "b", "c") + joint("k", "c", "b"),
        "link 'b': is part of a loop of joints",
    ),
    "nothing but a circle": (
        '<link name="b"/><link name="c"/>'
        + joint("j", "b", "c")
        + joint("k", "c", "b"),
        "link 'b': is part of a loop of joints",
    ),
    "a floating joint": (
        LINKS + joint("j", "a", "b", "floating"),
        "joint 'j': is floating, .*write type='fixed'.*--base",
    ),
    "a planar joint": (
        LINKS + joint("j", "a", "b", "planar"),
        "joint 'j': is planar",
    ),
    "an unknown type": (
        LINKS + joint("j", "a", "b", "revolut"),
        "joint 'j': unknown type 'revolut' .did you mean 'revolute'",
    ),
    "an unknown link": (
        LINKS + joint("j", "a", "bb"),
        "joint 'j' <child>: unknown link 'bb'",
    ),
    "a limit that is not a number": (
        LINKS + joint("j", "a", "b", inner='<limit lower="low"/>'),
        "joint 'j' <limit> lower: expected a finite number, got 'low'",
    ),
    "an endless limit": (
        LINKS + joint("j", "a", "b", inner='<limit upper="inf"/>'),
        "joint 'j' <limit> upper: expected a finite number",
    ),
    "a mimic of nothing": (
        LINKS + joint("j", "a", "b", inner='<mimic joint="x"/>'),
        "joint 'j' <mimic>: unknown joint 'x'",
    ),
}


@pytest.mark.parametrize(("elements", "message"), BAD.values(), ids=BAD)
def test_what_cannot_be_driven_is_told(elements, message):
    with pytest.raises(RemoSplatError, match=message) as caught:
        urdf(elements)
    assert str(caught.value).startswith("arm.urdf: ")
    assert "\n" not in str(caught.value)


def test_xacro_in_a_urdf_is_recognised():
    with pytest.raises(RemoSplatError, match="is it xacro"):
        urdf("<xacro:macro/>")


def test_another_kind_of_document_is_refused():
    with pytest.raises(RemoSplatError, match="expected <robot>, got <sdf>"):
        Urdf(Path("arm.sdf"), "<sdf/>")
