"""Limits and inertias that a URDF leaves out are guessed, and said."""

import math
from pathlib import Path

import pytest

from remosplat_drake.base.errors import FieldError
from remosplat_drake.robot.importing.completion import (
    complete_inertias,
    complete_limits,
)
from remosplat_drake.robot.importing.findings import Findings
from remosplat_drake.robot.importing.urdf import Urdf

INERTIA = '<inertia ixx="{}" iyy="{}" izz="{}" ixy="0" ixz="0" iyz="0"/>'


def one_joint(kind: str, limit: str) -> Urdf:
    return Urdf(
        Path("arm.urdf"),
        f'<robot name="arm"><link name="a"/><link name="b"/>'
        f'<joint name="j" type="{kind}"><parent link="a"/><child link="b"/>'
        f"{limit}</joint></robot>",
    )


def completed(kind: str, limit: str):
    urdf, findings = one_joint(kind, limit), Findings()
    (limits,) = complete_limits(urdf, tuple(urdf.joints.values()), findings)
    return limits, dict(findings.guessed), urdf.joints["j"].element


def test_what_the_file_says_is_taken():
    limits, guessed, _ = completed(
        "revolute", '<limit lower="-1" upper="2" velocity="4" effort="7"/>'
    )
    assert (limits.lower, limits.upper, limits.velocity) == (-1, 2, 4)
    assert limits.effort == 7
    # Full speed in a quarter of a second.
    assert limits.acceleration == 16
    assert list(guessed) == ["acceleration limits"]


@pytest.mark.parametrize(
    ("kind", "limit"),
    [("continuous", '<limit velocity="2"/>'), ("revolute", "")],
)
def test_a_hinge_without_limits_turns_twice(kind, limit):
    limits, guessed, element = completed(kind, limit)
    assert (limits.lower, limits.upper) == (-2 * math.pi, 2 * math.pi)
    assert "j" in guessed["position limits"]
    assert element.get("type") == "revolute"
    written = element.find("limit")
    assert float(written.get("upper")) == pytest.approx(2 * math.pi)


@pytest.mark.parametrize(
    ("kind", "velocity"), [("revolute", 1.0), ("prismatic", 0.1)]
)
@pytest.mark.parametrize("said", ["", 'velocity="0"', 'velocity="1e5"'])
def test_an_unusable_speed_is_guessed(kind, velocity, said):
    limits, guessed, _ = completed(kind, f'<limit lower="0" upper="1" {said}/>')
    assert limits.velocity == velocity
    assert "j" in guessed["velocity limits"]


@pytest.mark.parametrize(
    ("kind", "effort"), [("revolute", 100), ("prismatic", 1000)]
)
def test_a_motor_without_an_effort_gets_one(kind, effort):
    text = '<limit lower="0" upper="1" velocity="1" effort="0"/>'
    limits, guessed, element = completed(kind, text)
    assert limits.effort == effort
    assert "of j;" in guessed["effort limits"]
    assert float(element.find("limit").get("effort")) == effort


@pytest.mark.parametrize(
    ("kind", "limit", "message"),
    [
        ("prismatic", "", r"'j' <limit>: is missing; write <limit lower"),
        (
            "revolute",
            '<limit lower="1" upper="1"/>',
            "lower 1 must be less than upper 1; or write type='fixed'",
        ),
        (
            "revolute",
            '<limit lower="0" upper="1" velocity="-1"/>',
            "<limit> velocity: must not be negative, got -1",
        ),
        (
            "revolute",
            '<limit lower="0" upper="1" velocity="1" effort="-1"/>',
            "<limit> effort: must not be negative, got -1",
        ),
    ],
)
def test_limits_that_cannot_be_are_told(kind, limit, message):
    with pytest.raises(FieldError, match=message):
        completed(kind, limit)


@pytest.mark.parametrize(
    ("inertial", "is_kept"),
    [
        ('<mass value="2"/>' + INERTIA.format(1, 1, 1), True),
        ('<mass value="0"/>' + INERTIA.format(1, 1, 1), False),
        ('<mass value="2"/>' + INERTIA.format(0, 1, 1), False),
        # No body's moments: the third exceeds the sum of the others.
        ('<mass value="2"/>' + INERTIA.format(1, 1, 3), False),
        ('<mass value="two"/>' + INERTIA.format(1, 1, 1), False),
        ('<mass value="2"/>', False),
        ("", False),
    ],
)
def test_masses_that_cannot_be_are_guessed(inertial, is_kept):
    element = f"<inertial>{inertial}</inertial>" if inertial else ""
    urdf = Urdf(
        Path("arm.urdf"),
        f'<robot><link name="a">{element}<collision/></link></robot>',
    )
    findings = Findings()
    complete_inertias(urdf, findings)
    assert bool(findings.guessed) == (not is_kept)
    mass = urdf.links["a"].find("inertial/mass")
    assert mass.get("value") == ("2" if is_kept else "1")


def test_a_frame_without_shapes_needs_no_mass():
    urdf = Urdf(Path("arm.urdf"), '<robot><link name="a"/></robot>')
    findings = Findings()
    complete_inertias(urdf, findings)
    assert not findings.guessed


def test_what_is_fixed_to_something_heavy_needs_no_mass():
    """A tool frame with a mass of zero gets no kilogram of its own."""
    nothing = f"<inertial><mass value='0'/>{INERTIA.format(0, 0, 0)}</inertial>"
    mass = f"<inertial><mass value='2'/>{INERTIA.format(1, 1, 1)}</inertial>"
    joint = (
        '<joint name="{0}" type="{1}"><parent link="{2}"/><child link="{0}"/>'
        "</joint>"
    )
    text = (
        '<robot><link name="base"><collision/></link>'
        f'<link name="arm">{mass}<collision/></link>'
        f'<link name="tool">{nothing}<collision/></link>'
        '<link name="bare"/>'
        f"{joint.format('arm', 'revolute', 'base')}"
        f"{joint.format('tool', 'fixed', 'arm')}"
        f"{joint.format('bare', 'revolute', 'tool')}</robot>"
    )
    urdf = Urdf(Path("arm.urdf"), text)
    findings = Findings()
    complete_inertias(urdf, findings)
    has_mass = {
        name: link.find("inertial") is not None
        for name, link in urdf.links.items()
    }
    # The last link that moves cannot weigh nothing.
    assert has_mass == {"base": True, "arm": True, "tool": False, "bare": True}
    assert "for base, bare" in dict(findings.guessed)["mass"]
