"""Objects of ours, and those of a folder of meshes."""

import numpy as np
import pytest
from pydrake.math import RigidTransform, RollPitchYaw

from remosplat_drake.base.errors import FileError
from remosplat_drake.generation.object_library import (
    MASS,
    draw_solid,
    placed_object,
    read_mesh_library,
    standing,
    volume,
)
from remosplat_drake.scene.objects.convex_hull import ConvexHull
from remosplat_drake.scene.objects.scene_object import SceneObject
from remosplat_drake.scene.primitive_scene import Box

CORNERS = np.array(np.meshgrid([-1, 1], [-1, 1], [-1, 1])).reshape(3, 8).T

URDF = """<robot name="x"><link name="x"><collision><geometry>
<mesh filename="{}.obj" scale="0.02 0.02 0.02"/></geometry></collision></link>
</robot>"""


def test_a_folder_of_meshes_is_read(tmp_path):
    """A cube of two units, 40 mm, and a mesh of one point."""
    for name, points in (("cube", CORNERS), ("point", np.zeros((8, 3)))):
        folder = tmp_path / name
        folder.mkdir()
        (folder / f"{name}.urdf").write_text(URDF.format(name))
        lines = [f"v {x} {y} {z}" for x, y, z in points]
        faces = [
            "1 2 4 3",
            "5 6 8 7",
            "1 2 6 5",
            "3 4 8 7",
            "1 3 7 5",
            "2 4 8 6",
        ]
        lines += [f"f {face}" for face in faces]
        (folder / f"{name}.obj").write_text("\n".join(lines) + "\n")
    library = read_mesh_library(tmp_path)
    assert list(library.refused) == ["point"]
    np.testing.assert_allclose(np.ptp(library.hulls["cube"], axis=0), 0.04)
    with pytest.raises(FileError, match="has no folders with URDF"):
        read_mesh_library(tmp_path / "cube")


def test_a_turned_brick_stands_on_its_largest_face():
    size = np.array([0.05, 0.08, 0.02])
    turn = RollPitchYaw(0.3, 0.7, -1.0).ToRotationMatrix().matrix()
    stood = standing(CORNERS * size @ turn.T + [1, 2, 3])
    assert stood is not None
    np.testing.assert_allclose(stood.mean(axis=0), 0, atol=1e-9)
    np.testing.assert_allclose(np.abs(stood[:, 2]), 0.02, atol=1e-6)


def test_a_needle_of_facets_stands_on_none():
    """A thin double cone: all faces are slim, far off the middle."""
    angle = np.arange(6) * np.pi / 3
    ring = 0.01 * np.column_stack([np.cos(angle), np.sin(angle), 0 * angle])
    assert standing(np.vstack([ring, [[0, 0, 0.2], [0, 0, -0.2]]])) is None


@pytest.mark.parametrize("seed", range(6))
def test_drawn_objects_stand_on_the_spot(seed):
    rng = np.random.default_rng(seed)
    solid = draw_solid(rng)
    thing = placed_object(solid, "it", np.array([1, 2, 0.5]), 0.7, rng)
    low, high = thing.corners[:, 2]
    z = thing.X_WO.translation()[2]
    np.testing.assert_allclose(z + low, 0.5)
    assert 0.06 < high - low < 0.2
    assert thing.mass is not None
    assert MASS[0] <= thing.mass <= MASS[1]
    np.testing.assert_allclose(thing.X_WO.translation()[:2], [1, 2])


def test_volumes_of_a_box_and_of_its_hull_are_equal():
    size = np.array([0.05, 0.08, 0.02])
    box, hull = Box(RigidTransform(), size), size * CORNERS
    np.testing.assert_allclose(volume(box), 8 * size.prod())
    np.testing.assert_allclose(
        volume(ConvexHull(RigidTransform(), hull)), 8 * size.prod()
    )
    assert SceneObject("box", box).mass is None
