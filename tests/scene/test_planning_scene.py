"""MoveIt's planning scenes: frames, shapes, and what is refused."""

from pathlib import Path

import numpy as np
import pytest

from remosplat_drake.base.errors import RemoSplatError
from remosplat_drake.scene.planning_scene import read_planning_scene

FILE = (
    Path(__file__).resolve().parents[1] / "data/mbm/shelf_panda/scene0001.yaml"
)


def test_objects_are_placed_by_their_own_pose_and_their_primitives():
    objects = read_planning_scene(FILE)
    assert list(objects) == ["board", "Can1", "Can2"]
    (board,) = objects["board"].boxes
    # A quarter turn about z: what is long in x is long in y.
    np.testing.assert_allclose(board.X_WP.translation(), [0.35, 0.35, 0.38])
    np.testing.assert_allclose(
        board.X_WP.rotation().matrix()[:, 0], [0, 1, 0], atol=1e-12
    )
    np.testing.assert_array_equal(board.half_extents, [0.25, 0.15, 0.02])
    (can,) = objects["Can1"].cylinders
    assert (can.radius, can.half_height) == (0.03, 0.06)
    np.testing.assert_array_equal(can.X_WP.translation(), [0.21, 0.22, 0.46])


@pytest.mark.parametrize(
    ("before", "after", "complaint"),
    [
        ("type: box", "type: sphere", r"primitives\[0\].type: unknown shape"),
        ("id: Can2", "id: Can1", "'Can1' appears twice"),
        ("      id: Can1\n", "", r"collision_objects\[1\].id: is missing"),
        ("[0.5, 0.3, 0.04]", "[0.5, 0.3]", "expected 3 numbers, got 2"),
        ("[0.5, 0.3, 0.04]", "[0.5, 0, 0.04]", "dimensions: must be positive"),
        ("[0.5, 0.3, 0.04]", "[0.5, .nan, 0.04]", "expected a finite number"),
        ("[0, 0, 0, 2]", "[0, 0, 0, 0]", "orientation: is not a rotation"),
        ("collision_objects", "objects", "collision_objects: is missing"),
        (
            "- id: board",
            "- id: board\n      meshes: [{}]",
            "meshes: unknown shape; valid: box, cylinder",
        ),
    ],
)
def test_bad_scenes_are_named_in_one_line(tmp_path, before, after, complaint):
    text = FILE.read_text()
    assert before in text
    path = tmp_path / "scene0001.yaml"
    path.write_text(text.replace(before, after, 1))
    with pytest.raises(RemoSplatError, match=complaint) as error:
        read_planning_scene(path)
    assert str(error.value).startswith(f"{path}:")
    assert "\n" not in str(error.value)


def test_a_primitive_without_a_pose_is_refused(tmp_path):
    path = tmp_path / "scene.yaml"
    path.write_text(
        "world: {collision_objects: [{id: a, primitive_poses: [],"
        " primitives: [{type: box, dimensions: [1, 1, 1]}]}]}"
    )
    with pytest.raises(RemoSplatError, match="one for each of 1 primitives"):
        read_planning_scene(path)
