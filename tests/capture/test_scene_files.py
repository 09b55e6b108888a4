"""Solids from files: drawn where the file says, and clear about bad files."""

import numpy as np
import pytest
from pydrake.math import RigidTransform

from remosplat_drake.base.errors import FileError, RemoSplatError
from remosplat_drake.capture.checks.seen_space import look_round
from remosplat_drake.capture.rendering.camera_poses import survey
from remosplat_drake.capture.rendering.renderer import render_views
from remosplat_drake.capture.rendering.scene_files import read_solids
from remosplat_drake.capture.rendering.solids import extent, primitive_solids
from remosplat_drake.robot.sphere_model import Spheres
from remosplat_drake.scene.primitive_scene import Box, PrimitiveScene

LOWER, UPPER = np.array([0.3, -0.1, 0.0]), np.array([0.7, 0.1, 0.6])

URDF = """<robot name="lamp">
  <link name="foot"><visual><origin xyz="0 0 0.1"/>
    <geometry><box size="0.4 0.4 0.2"/></geometry></visual></link>
  <link name="head"><visual><origin xyz="0.5 0 0"/>
    <geometry><sphere radius="0.1"/></geometry></visual></link>
  <joint name="stem" type="fixed"><parent link="foot"/><child link="head"/>
    <origin xyz="0 0 1" rpy="0 0 1.5707963267948966"/></joint>
</robot>"""


@pytest.fixture(scope="module")
def trimesh():
    return pytest.importorskip("trimesh")


@pytest.fixture(scope="module")
def block(trimesh):
    mesh = trimesh.creation.box(bounds=[LOWER, UPPER])
    mesh.visual.vertex_colors = [200, 60, 40, 255]
    return mesh


def points_seen(solids, poses) -> np.ndarray:
    capture = render_views(solids, poses, 120, 90)
    views = range(len(capture))
    points = np.concatenate([capture.points_W(v).reshape(-1, 3) for v in views])
    return points[np.isfinite(points[:, 0])]


@pytest.mark.parametrize("suffix", [".obj", ".stl", ".ply", ".off"])
def test_a_mesh_is_seen_where_it_is(block, tmp_path, suffix):
    block.export(tmp_path / f"block{suffix}")
    solids = read_solids(tmp_path / f"block{suffix}")
    lower, upper = extent(solids)
    np.testing.assert_allclose([lower, upper], [LOWER, UPPER], atol=1e-6)
    field = look_round(solids, lower, upper)
    poses = survey(field, (lower + upper) / 2, 10, radius=1.0)
    points = points_seen(solids, poses)
    assert len(points) > 1000
    box = np.abs(points - (LOWER + UPPER) / 2) - (UPPER - LOWER) / 2
    assert np.abs(box.max(axis=1)).max() < 3e-5


def test_gltf_files_are_y_up(block, tmp_path):
    block.export(tmp_path / "block.glb")
    lower, upper = extent(read_solids(tmp_path / "block.glb"))
    np.testing.assert_allclose(lower, [0.3, -0.6, -0.1], atol=1e-6)
    np.testing.assert_allclose(upper, [0.7, 0.0, 0.1], atol=1e-6)


def test_a_mesh_can_be_placed_and_scaled(block, tmp_path):
    block.export(tmp_path / "block.stl")
    X_WM = RigidTransform([1, 2, 3])
    lower, upper = extent(read_solids(tmp_path / "block.stl", X_WM, scale=2))
    expected = np.array([LOWER, UPPER]) * 2 + [1, 2, 3]
    np.testing.assert_allclose([lower, upper], expected, atol=1e-6)


def test_vertex_colours_are_drawn(block, tmp_path):
    block.export(tmp_path / "block.ply")
    solids = read_solids(tmp_path / "block.ply")
    field = look_round(solids, LOWER, UPPER)
    capture = render_views(solids, survey(field, LOWER, 4), 64, 48)
    red, green, _ = capture.rgb[capture.depth > 0].mean(axis=0)
    assert red > 1.5 * green


def test_a_models_links_are_where_its_joints_put_them(tmp_path):
    path = tmp_path / "lamp.urdf"
    path.write_text(URDF)
    solids = read_solids(path, RigidTransform([2, 0, 0]))
    assert len(solids) == 2
    (head,) = (s for s in solids if s.X_WG.translation()[2] > 0.5)
    # The joint turns by a quarter, so that the head's x is y in W.
    np.testing.assert_allclose(head.X_WG.translation(), [2, 0.5, 1], atol=1e-9)
    field = look_round(solids, *extent(solids))
    points = points_seen([head], survey(field, np.array([2, 0.5, 1]), 6))
    radius = np.linalg.norm(points - [2, 0.5, 1], axis=1)
    assert radius.min() > 0.097 and radius.max() < 0.1001


@pytest.mark.parametrize("filename", ["{}", "package://shop/{}"])
def test_a_models_meshes_may_be_of_any_format(block, tmp_path, filename):
    folder = tmp_path / "urdf"
    folder.mkdir()
    (tmp_path / "package.xml").write_text(
        "<package><name>shop</name></package>"
    )
    block.export(folder / "block.stl")
    name = filename.format(
        "urdf/block.stl" if "shop" in filename else "block.stl"
    )
    mesh = f'<geometry><mesh filename="{name}" scale="2 2 2"/></geometry>'
    (folder / "shop.urdf").write_text(
        f"<robot name='shop'><link name='block'><visual>{mesh}</visual>"
        f"<collision>{mesh}</collision></link></robot>"
    )
    lower, upper = extent(read_solids(folder / "shop.urdf"))
    np.testing.assert_allclose(
        [lower, upper], [2 * LOWER, 2 * UPPER], atol=1e-6
    )


def test_unseen_space_counts_as_solid():
    box = Box(RigidTransform([0, 0, 0.5]), np.full(3, 0.5))
    solids = primitive_solids(PrimitiveScene(boxes=(box,)))
    field = look_round(solids, *extent(solids))
    inside, outside = [0.1, 0, 0.5], [1.0, 0.2, 0.5]
    answer = field.clearances(Spheres.at([inside, outside], 0.05))
    # The samples of the surface are up to 2 cm apart.
    np.testing.assert_allclose(answer.distance, [-0.45, 0.45], atol=0.01)
    # Both point as the distance falls: out of the solid is up the gradient.
    np.testing.assert_allclose(
        answer.direction_W, [[-1, 0, 0], [-1, 0, 0]], atol=0.2
    )


def test_a_room_is_seen_from_within(trimesh, tmp_path):
    room = trimesh.creation.box((4, 4, 3))
    room.export(tmp_path / "room.stl")
    solids = read_solids(tmp_path / "room.stl")
    middle = np.array([0.1, 0.2, 0])
    lower, upper = extent(solids)
    assert not look_round(solids, lower, upper).is_seen(middle[None])[0]
    field = look_round(solids, lower, upper, around=middle)
    poses = survey(field, middle, 20, radius=1.2)
    centers = np.array([X_WC.translation() for X_WC in poses])
    assert (np.abs(centers) < [1.95, 1.95, 1.45]).all()


def test_no_room_for_cameras_is_said(trimesh, tmp_path):
    trimesh.creation.box((4, 4, 4)).export(tmp_path / "solid.stl")
    solids = read_solids(tmp_path / "solid.stl")
    field = look_round(solids, *extent(solids))
    with pytest.raises(RemoSplatError, match="room for only 0 of 5"):
        survey(field, np.zeros(3), 5, radius=0.5)


BAD_NUMBER = """<robot name="a"><link name="b"><visual>
<origin xyz="1_000 0 0"/><geometry><sphere radius="1"/></geometry>
</visual></link></robot>"""


@pytest.mark.parametrize(
    ("name", "content", "problem"),
    [
        ("scene.txt", "", "expected a file of .urdf"),
        ("bad.urdf", "<robot", "bad.urdf: unclosed"),
        ("empty.urdf", "<robot name='a'><link name='b'/></robot>", "no visual"),
        ("number.urdf", BAD_NUMBER, "Expected 3 values"),
        ("bad.obj", "v 1 2", "vertices"),
        ("bad.gltf", "{}", "bad.gltf"),
        ("bad.stl", "nothing", "bad.stl"),
        ("bad.ply", "ply", "unreadable mesh"),
    ],
)
def test_bad_files_are_named(tmp_path, name, content, problem, trimesh):
    path = tmp_path / name
    path.write_text(content)
    with pytest.raises(FileError, match=problem) as caught:
        read_solids(path)
    assert str(path) in str(caught.value)
    assert "\n" not in str(caught.value)


def test_missing_files_are_named(tmp_path):
    with pytest.raises(FileError, match="no such file"):
        read_solids(tmp_path / "none.urdf")
