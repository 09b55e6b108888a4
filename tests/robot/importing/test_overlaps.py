"""Shapes that no real links can have, told and not refused."""

from itertools import pairwise

import yaml

from remosplat_drake.robot.importing.findings import Findings
from remosplat_drake.robot.importing.overlaps import doubt_overlaps
from remosplat_drake.robot.robot_model import load_robot

LINKS = "abcd"


def doubted(folder, sizes: list[float]) -> dict[str, str]:
    """What is doubted of four cubes in a row, 0.3 m apart.

    Args:
        folder: Where the robot is written.
        sizes: The sides of the cubes [m].
    """
    text = ""
    for link, size in zip(LINKS, sizes, strict=True):
        text += (
            f'<link name="{link}"><collision><geometry>'
            f'<box size="{size} {size} {size}"/></geometry></collision></link>'
        )
    for parent, child in pairwise(LINKS):
        text += (
            f'<joint name="{child}_joint" type="revolute">'
            f'<parent link="{parent}"/><child link="{child}"/>'
            '<origin xyz="0 0 0.3"/><axis xyz="0 0 1"/>'
            '<limit lower="-3" upper="3" velocity="1" effort="1"/></joint>'
        )
    (folder / "r.urdf").write_text(f'<robot name="r">{text}</robot>')
    spheres = {link: [[0.0, 0.0, 0.0, 0.1]] for link in LINKS}
    (folder / "s.yaml").write_text(yaml.safe_dump({"spheres": spheres}))
    joints = [f"{link}_joint" for link in LINKS[1:]]
    description = {
        "name": "r",
        "model": "r.urdf",
        "arm": {"name": "arm", "joints": joints, "mount": "a"},
        "end_effector_frame": "d",
        "velocity_limits": [1.0] * 3,
        "acceleration_limits": [1.0] * 3,
        "home": [0.0] * 3,
        "spheres": {"covering": "s.yaml"},
    }
    (folder / "r.yaml").write_text(yaml.safe_dump(description))
    findings = Findings()
    doubt_overlaps(load_robot(folder / "r.yaml"), findings)
    return dict(findings.doubted)


def test_links_that_keep_apart_are_not_doubted(tmp_path):
    assert not doubted(tmp_path, [0.2] * 4)


def test_what_overlaps_in_every_pose_is_told(tmp_path):
    # a reaches to 0.35, c from 0.55 down to 0.25 in any turn about z.
    said = doubted(tmp_path, [0.7, 0.2, 0.7, 0.2])
    assert said["self-collision"] == (
        "a and c overlap in every pose, and are not checked"
    )


def test_a_hull_that_swallows_its_neighbour_is_told(tmp_path):
    said = doubted(tmp_path, [0.9, 0.1, 0.1, 0.1])
    assert said == {
        "collision shapes": "that of a contains b; are their meshes, scales"
        " and origins right?"
    }
