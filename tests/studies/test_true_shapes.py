"""The study of shapes measures meshes, and knows what is inside what."""

import numpy as np
import pytest

pytest.importorskip("fcl")
trimesh = pytest.importorskip("trimesh")

from apps.studies.true_shapes.__main__ import main
from apps.studies.true_shapes.maker_meshes import MakerMeshes

URDF = """<robot name="two">
<link name="a"><collision><geometry><mesh filename="large.stl"/></geometry>
</collision></link>
<link name="b"><collision><geometry><mesh filename="small.stl"/></geometry>
</collision></link>
<joint name="slide" type="prismatic"><parent link="a"/><child link="b"/>
<axis xyz="1 0 0"/><limit lower="0" upper="1" effort="1" velocity="1"/></joint>
</robot>"""


@pytest.mark.parametrize(
    ("x", "distance"),
    [
        (0.30, 0.04),  # Beside the large cube, whose edge is 0.4 m.
        (0.22, 0.0),  # Across its side.
        (0.10, 0.0),  # Inside of it, 40 mm from its side.
    ],
)
def test_cubes_are_as_far_apart_as_their_sides(tmp_path, x, distance):
    trimesh.creation.box((0.4, 0.4, 0.4)).export(tmp_path / "large.stl")
    trimesh.creation.box((0.12, 0.12, 0.12)).export(tmp_path / "small.stl")
    (tmp_path / "two.urdf").write_text(URDF)
    meshes = MakerMeshes(tmp_path / "two.urdf", ("a", "b"))
    X_WB = np.eye(4)
    X_WB[0, 3] = x
    measured = meshes.distance(("a", "b"), np.eye(4), X_WB)
    assert measured == pytest.approx(distance, abs=1e-6)
    is_across = abs(x - 0.2) < 0.06
    assert meshes.intersect(("a", "b"), np.eye(4), X_WB) == is_across


WELDED = """<link name="rod"><collision><origin xyz="0 0 0.5"/><geometry>
<box size="0.02 0.02 1"/></geometry></collision></link>
<joint name="weld" type="fixed"><parent link="b"/><child link="rod"/>
<origin xyz="0 0 0.1" rpy="0 -1.5707963267948966 0"/></joint>
</robot>"""


@pytest.mark.parametrize(
    ("left_out", "distance"),
    [
        ((), 0.18),  # The rod ends 1 m from the small cube's middle.
        (("rod",), 1.12),  # The small cube's side is 60 mm from its middle.
    ],
)
def test_welded_links_count_as_what_carries_them(tmp_path, left_out, distance):
    trimesh.creation.box((0.4, 0.4, 0.4)).export(tmp_path / "large.stl")
    trimesh.creation.box((0.12, 0.12, 0.12)).export(tmp_path / "small.stl")
    text = URDF.replace("</robot>", WELDED)
    (tmp_path / "two.urdf").write_text(text)
    meshes = MakerMeshes(tmp_path / "two.urdf", ("a", "b"), left_out)
    assert set(meshes.triangles) == {"a", "b"}
    X_WB = np.eye(4)
    X_WB[0, 3] = 1.38
    measured = meshes.distance(("a", "b"), np.eye(4), X_WB)
    assert measured == pytest.approx(distance, abs=1e-6)


@pytest.mark.parametrize(
    ("flags", "message"),
    [
        (["fetch"], "expected ROBOT=FILE"),
        (["fetch=a.urdf", "--postures", "-1"], "expected 0 to 1000000, got -1"),
    ],
)
def test_wrong_flags_are_one_line(capsys, flags, message):
    assert main(flags) == 2
    assert message in capsys.readouterr().err
