"""Maps survive their files; other files are refused in one line."""

import os
from pathlib import Path

import numpy as np
import pytest

from remosplat_drake.errors import FileError
from remosplat_drake.mapping.map_file import MAGIC, open_map, write_map
from remosplat_drake.mapping.scene_map import SceneMap
from remosplat_drake.oracle.depth_rasterization import DepthRasterizationField
from remosplat_drake.oracle.sphere_to_ellipsoid import SphereToEllipsoidField
from remosplat_drake.reconstruction.coverage import Coverage
from remosplat_drake.robot.sphere_model import Spheres
from remosplat_drake.splat.gaussian_splat import GaussianSplat
from remosplat_drake.splat.surfel_tiles import make_tiles

SPHERES = Spheres.at([[0, 0, 0.1], [0.4, 0.1, 0.3]], 0.05)


def floor(n: int = 500) -> GaussianSplat:
    """Discs all over a square of the floor."""
    rng = np.random.default_rng(0)
    p_GK = np.column_stack([rng.uniform(-1, 1, (n, 2)), np.zeros(n)])
    return GaussianSplat(
        p_GK=p_GK,
        quaternions=np.tile([1.0, 0, 0, 0], (n, 1)),
        scales=np.full((n, 2), 0.05),
        opacities=np.full(n, 0.9),
        colors=rng.random((n, 3)),
    )


def a_map(make_field=SphereToEllipsoidField) -> SceneMap:
    splat = floor()
    coverage = Coverage(np.zeros(3), 0.1, np.ones((3, 4, 5), np.uint8))
    return SceneMap(
        version=3,
        parent=1,
        frames=("frame_0001", "frame_0002"),
        time=12.5,
        field=make_field(splat),
        splat_W=splat,
        coverage=coverage,
        tiles=make_tiles(splat, size=200),
        quality="2 frames",
    )


@pytest.fixture
def path(tmp_path) -> Path:
    return tmp_path / "map_0003.rsmap"


@pytest.mark.parametrize(
    "make_field", [SphereToEllipsoidField, DepthRasterizationField]
)
def test_a_map_comes_back_as_it_was(path, make_field):
    before = a_map(make_field)
    write_map(path, before)
    after = open_map(path, check=True)
    assert (after.version, after.parent, after.time) == (3, 1, 12.5)
    assert after.frames == before.frames
    assert after.quality == "2 frames"
    assert after.field.revision == before.field.revision
    expected = before.field.clearances(SPHERES, 0.5)
    answer = after.field.clearances(SPHERES, 0.5)
    assert len(expected) > 0
    np.testing.assert_array_equal(answer.distance, expected.distance)
    np.testing.assert_array_equal(answer.direction_W, expected.direction_W)
    np.testing.assert_array_equal(after.coverage.state, before.coverage.state)
    assert after.splat_W.content_hash == before.splat_W.content_hash
    assert len(after.tiles) == 3
    np.testing.assert_array_equal(after.tiles[2].faces, before.tiles[2].faces)


def test_arrays_are_views_of_the_file_at_cache_lines(path):
    write_map(path, a_map())
    after = open_map(path)
    for array in (after.splat_W.p_GK, after.tiles[0].vertices):
        assert not array.flags.owndata
        assert array.ctypes.data % 64 == 0
    # A kernel is compiled for read-only arrays or for others.
    assert not after.splat_W.p_GK.flags.writeable
    assert after.coverage.state.flags.writeable


def test_a_map_outlives_the_name_of_its_file(path):
    write_map(path, a_map())
    after = open_map(path)
    path.unlink()
    assert len(after.field.clearances(SPHERES)) == 2


def test_a_map_that_fits_in_no_file_leaves_the_old_one(path):
    write_map(path, a_map())
    hopeless = SceneMap(4, 3, (), 0.0, field=lambda: None)
    with pytest.raises(FileError, match="this map fits in no file"):
        write_map(path, hopeless)
    assert open_map(path).version == 3
    assert os.listdir(path.parent) == [path.name]


def refusal(path: Path, **options) -> str:
    with pytest.raises(FileError) as error:
        open_map(path, **options)
    assert "\n" not in str(error.value)
    assert str(path) in str(error.value)
    return error.value.problem


def test_a_missing_or_foreign_file_is_refused(path):
    assert "No such file" in refusal(path)
    path.write_bytes(b"")
    assert "is empty" in refusal(path)
    path.write_bytes(b"ply")
    assert "too short" in refusal(path)
    path.write_bytes(b"ply\n" + bytes(1000))
    assert "is no map" in refusal(path)
    path.unlink()
    path.mkdir()
    assert refusal(path)


def test_a_file_of_another_format_is_refused(path):
    write_map(path, a_map())
    data = bytearray(path.read_bytes())
    data[len(MAGIC)] = 9
    path.write_bytes(data)
    assert "is a map of format 9" in refusal(path)


def test_a_truncated_file_is_refused(path):
    write_map(path, a_map())
    whole = path.read_bytes()
    for length in (len(whole) - 1, len(whole) // 2, 60):
        path.write_bytes(whole[:length])
        assert "cut off" in refusal(path)


def test_a_damaged_file_is_refused(path):
    write_map(path, a_map())
    whole = path.read_bytes()
    for place in (50, 500):
        data = bytearray(whole)
        data[place] ^= 1
        path.write_bytes(data)
        assert "checksum is wrong" in refusal(path)
    data = bytearray(whole)
    data[-100] ^= 1
    path.write_bytes(data)
    assert "of its arrays" in refusal(path, check=True)


class Evil:
    """What a pickle may hold, and no map."""

    def __reduce__(self):
        return os.system, ("true",)


def test_nothing_but_maps_is_made(path):
    hidden = SceneMap(0, None, (), 0.0, field=Evil())  # pyright: ignore
    with pytest.raises(FileError, match="system is not part of a map"):
        write_map(path, hidden)


def test_something_else_of_ours_is_no_map(path):
    write_map(path, floor())  # pyright: ignore
    assert "something else than a map" in refusal(path)
