"""Numbers of a URDF that cannot be, told with link or joint and element."""

from pathlib import Path

import pytest

from remosplat_drake.base.errors import FieldError
from remosplat_drake.robot.importing.urdf import Urdf
from remosplat_drake.robot.importing.urdf_numbers import check_numbers


def arm(shape: str = "", origin: str = "", axis: str = "") -> Urdf:
    return Urdf(
        Path("arm.urdf"),
        f'<robot name="arm"><link name="a"><collision>{origin}'
        f'<geometry>{shape}</geometry></collision></link><link name="b"/>'
        f'<joint name="j" type="revolute"><parent link="a"/><child link="b"/>'
        f"{origin}{axis}</joint></robot>",
    )


def test_what_can_be_is_taken():
    check_numbers(arm())
    origin = '<origin xyz="0 1e-3 -2"/>'
    for shape in (
        '<box size="1 2 3"/>',
        '<sphere radius="1"/>',
        '<cylinder radius=".1" length="2"/>',
        '<mesh filename="a.stl"/>',
    ):
        check_numbers(arm(shape, origin, '<axis xyz="0 0 1"/>'))


@pytest.mark.parametrize(
    ("parts", "message"),
    [
        ({"shape": '<box size="1 2"/>'}, "<box> size: expected 3 numbers"),
        ({"shape": '<sphere radius="-1"/>'}, "radius: must be positive, got"),
        ({"shape": '<cylinder radius="1"/>'}, "<cylinder>: has no length"),
        ({"shape": '<sphere radius="nan"/>'}, "expected a number, got 'nan'"),
        ({"origin": '<origin xyz="0 a 0"/>'}, "'j' <origin> xyz: expected 3"),
        ({"origin": '<origin rpy="0"/>'}, "<origin> rpy: expected 3 numbers"),
        ({"axis": '<axis xyz="0 0 0"/>'}, "joint 'j' <axis> xyz: is zero"),
    ],
)
def test_what_cannot_be_is_one_line(parts, message):
    with pytest.raises(FieldError, match=message) as caught:
        check_numbers(arm(**parts))
    assert str(caught.value).startswith("arm.urdf: ")
    assert "\n" not in str(caught.value)
