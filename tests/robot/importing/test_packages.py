"""The folders of `package://NAME/...`."""

from pathlib import Path

import pytest

from remosplat_drake.base.errors import FieldError, FileError
from remosplat_drake.robot.importing.packages import Packages, given_packages


def write(path: Path, text: str = "") -> Path:
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(text)
    return path


def named(name: str) -> str:
    return f"<package><name>{name}</name></package>"


@pytest.fixture
def robot(tmp_path) -> Path:
    return write(tmp_path / "src/some_folder/urdf/robot.urdf")


def found(robot: Path, uri: str, **variables: str) -> Path:
    return Packages(robot, {}, variables).resolve(uri, "link 'a'")


def test_a_package_above_the_file_is_known_by_its_package_xml(robot):
    package = robot.parents[1]
    write(package / "package.xml", named("arm_description"))
    mesh = write(package / "meshes/a.stl")
    assert found(robot, "package://arm_description/meshes/a.stl") == mesh


def test_a_package_without_package_xml_is_known_by_its_folder(robot):
    mesh = write(robot.parents[1] / "meshes/a.stl")
    assert found(robot, "package://some_folder/meshes/a.stl") == mesh


@pytest.mark.parametrize("slashes", ["//", "///"])
def test_a_package_beside_the_robots_is_found(robot, slashes):
    mesh = write(robot.parents[2] / "hand_description/a.stl")
    assert found(robot, f"package:{slashes}hand_description/a.stl") == mesh


@pytest.mark.parametrize(
    ("variable", "place"),
    [
        ("ROS_PACKAGE_PATH", "hand"),
        ("ROS_PACKAGE_PATH", "stack/deep/hand"),
        ("AMENT_PREFIX_PATH", "share/hand"),
        ("COLCON_PREFIX_PATH", "share/hand"),
        ("COLCON_PREFIX_PATH", "hand/share/hand"),
    ],
)
def test_workspaces_are_searched(robot, tmp_path, variable, place):
    mesh = write(tmp_path / "ws" / place / "a.stl")
    path = f"/nowhere:{tmp_path / 'ws'}"
    assert found(robot, "package://hand/a.stl", **{variable: path}) == mesh


def test_what_is_given_comes_first(robot, tmp_path):
    write(robot.parents[1] / "a.stl")
    mesh = write(tmp_path / "other" / "a.stl")
    packages = given_packages([f"some_folder={tmp_path / 'other'}"])
    uri = "package://some_folder/a.stl"
    assert Packages(robot, packages, {}).resolve(uri, "link 'a'") == mesh


def test_files_and_relative_names_are_found(robot):
    mesh = write(robot.parents[1] / "a.stl")
    assert found(robot, f"file://{mesh}") == mesh
    assert found(robot, "../a.stl").samefile(mesh)


def test_an_unknown_package_says_what_to_write(robot):
    with pytest.raises(
        FieldError,
        match=r"robot.urdf: link 'a': no package 'hand' .*"
        r"give --package hand=DIR",
    ):
        found(robot, "package://hand/a.stl")


def test_a_missing_mesh_is_told_with_its_element(robot):
    with pytest.raises(FieldError, match=r"link 'a': package://some_folder/b"):
        found(robot, "package://some_folder/b.stl")


def test_flags_are_checked(tmp_path):
    with pytest.raises(FieldError, match="expected NAME=DIR"):
        given_packages(["hand"])
    with pytest.raises(FileError, match="no such folder"):
        given_packages([f"hand={tmp_path / 'none'}"])
