"""Arguments of xacro files, and packages whose folders have other names."""

from pathlib import Path

import pytest

pytest.importorskip("xacro")

from remosplat_drake.base.errors import RemoSplatError
from remosplat_drake.robot.importing.findings import Findings
from remosplat_drake.robot.importing.packages import Packages
from remosplat_drake.robot.importing.sources import read_robot
from remosplat_drake.robot.importing.xacro_files import xacro_arguments

HEAD = '<robot name="toy" xmlns:xacro="http://www.ros.org/wiki/xacro">'


def written(path: Path, text: str) -> Path:
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(f"{HEAD}{text}</robot>")
    return path


def read(path: Path, **arguments: str):
    findings = Findings()
    packages = Packages(path, variables={})
    urdf, _ = read_robot(path, packages, arguments, findings)
    return urdf, findings, packages


@pytest.fixture
def gen3(tmp_path) -> Path:
    """Like Kinova's: folders for each number of joints, one needed argument."""
    for dof in ("6", "7"):
        written(
            tmp_path / f"arms/gen3/{dof}dof/arm.xacro",
            f'<link name="arm_{dof}"/>',
        )
    return written(
        tmp_path / "gen3.urdf.xacro",
        '<xacro:arg name="vision" default="false"/>'
        '<xacro:property name="dofs" value="$(arg dof)"/>'
        '<xacro:property name="eyes" value="$(arg vision)"/>'
        "<xacro:if value=\"${eyes == 'true'}\"><link name='eye'/></xacro:if>"
        '<xacro:include filename="arms/gen3/${dofs}dof/arm.xacro"/>',
    )


def test_arguments_are_found_with_defaults_and_choices(gen3):
    found = xacro_arguments(gen3, Packages(gen3, variables={}))
    assert {name: str(x) for name, x in found.items()} == {
        "vision": "vision ('false'; of true)",
        "dof": "dof (needed; of 6, 7)",
    }


def test_a_missing_argument_is_named_with_all_others(gen3):
    with pytest.raises(
        RemoSplatError,
        match=r"gen3.urdf.xacro: argument 'dof': has no default: give --arg"
        r" dof=...; arguments: vision .*, dof \(needed; of 6, 7\)",
    ):
        read(gen3)


def test_given_it_is_read_and_the_others_are_noted(gen3):
    urdf, findings, _ = read(gen3, dof="7")
    assert set(urdf.links) == {"arm_7"}
    said = dict(findings.found)["xacro arguments"]
    assert said.endswith("dof (needed; of 6, 7); --arg sets them")


def test_an_unknown_argument_is_one_line(gen3):
    with pytest.raises(
        RemoSplatError,
        match=r"--arg: unknown argument 'dofs' \(did you mean 'dof'\?\)",
    ):
        read(gen3, dofs="7")


def test_a_urdf_has_no_arguments(tmp_path):
    path = tmp_path / "toy.urdf"
    path.write_text('<robot name="toy"><link name="a"/></robot>')
    with pytest.raises(RemoSplatError, match="--arg: dof: only xacro has"):
        read(path, dof="7")


def test_a_package_in_a_renamed_folder_is_found_by_what_is_wanted(tmp_path):
    written(tmp_path / "kr6/urdf/macro.xacro", '<link name="a"/>')
    path = written(
        tmp_path / "kr6/urdf/kr6.xacro",
        '<xacro:include filename="$(find kr6_support)/urdf/macro.xacro"/>',
    )
    urdf, _, packages = read(path)
    assert set(urdf.links) == {"a"}
    assert packages.guessed == {"kr6_support": tmp_path / "kr6"}


def test_one_that_is_nowhere_is_one_line(tmp_path):
    path = written(
        tmp_path / "kr6.xacro",
        '<xacro:include filename="$(find kr6_support)/urdf/macro.xacro"/>',
    )
    with pytest.raises(RemoSplatError, match="no package 'kr6_support'"):
        read(path)
