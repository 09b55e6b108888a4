"""Maps survive their files; other files are refused in one line."""

import os
import pickle
import struct
import subprocess
import sys
import zlib
from pathlib import Path

import map_mutations as mutations
import numba
import numpy as np
import pytest
from effort import effort
from patience import PATIENCE

from remosplat_drake.base.errors import FileError, RemoSplatError
from remosplat_drake.mapping.store.map_file import KIND, open_map, write_map
from remosplat_drake.oracle.composite import CompositeDistanceField
from remosplat_drake.oracle.depth_rasterization import DepthRasterizationField
from remosplat_drake.oracle.depth_sensor import DepthSensor
from remosplat_drake.oracle.sphere_to_ellipsoid import SphereToEllipsoidField
from remosplat_drake.oracle.unknown_space import unknown_space_field
from remosplat_drake.robot.sphere_model import Spheres
from remosplat_drake.signals.coverage import Coverage
from remosplat_drake.signals.scene_map import SceneMap
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


def some_coverage() -> Coverage:
    state = np.ones((3, 4, 5), np.uint8)
    state[:, 2:] = 0
    return Coverage(np.array([-0.5, -0.5, 0]), 0.25, state)


def all_of(splat: GaussianSplat) -> CompositeDistanceField:
    """Every kind of field that a map may have."""
    return CompositeDistanceField(
        [
            SphereToEllipsoidField(splat, n_sigma=2, bisection_steps=9),
            DepthRasterizationField(splat, DepthSensor(far=2)),
            unknown_space_field(some_coverage()),
        ]
    )


def a_map(make_field=SphereToEllipsoidField, splat=None) -> SceneMap:
    splat = splat or floor()
    return SceneMap(
        version=3,
        parent=1,
        frames=("frame 1", "frame 2"),
        time=12.5,
        field=make_field(splat),
        splat_W=splat,
        coverage=some_coverage(),
        tiles=make_tiles(splat),
        quality="2 frames",
    )


@pytest.fixture
def path(tmp_path) -> Path:
    return tmp_path / "map_0003.rsmap"


@pytest.mark.parametrize("is_sealed", [True, False])
@pytest.mark.parametrize(
    "make_field", [SphereToEllipsoidField, DepthRasterizationField, all_of]
)
def test_a_map_comes_back_as_it_was(path, make_field, is_sealed):
    before = a_map(make_field, turned_floor(1500))
    seal = write_map(path, before)
    after = open_map(path, seal if is_sealed else None)
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
    assert len(after.tiles) == 2
    for ours, theirs in zip(before.tiles, after.tiles, strict=True):
        for name in ("vertices", "faces", "colors"):
            expected, array = getattr(ours, name), getattr(theirs, name)
            np.testing.assert_array_equal(array, expected)
            assert array.strides == expected.strides


@pytest.mark.parametrize("is_sealed", [True, False])
def test_uncertainty_comes_back(path, is_sealed):
    splat = floor().with_uncertainty(np.linspace(0, 0.1, 500))
    before = a_map(all_of, splat)
    seal = write_map(path, before)
    after = open_map(path, seal if is_sealed else None)
    np.testing.assert_array_equal(after.splat_W.uncertainty, splat.uncertainty)
    expected = before.field.clearances(SPHERES, 0.5)
    answer = after.field.clearances(SPHERES, 0.5)
    np.testing.assert_array_equal(answer.distance, expected.distance)
    assert after.field.revision == before.field.revision


@pytest.mark.parametrize("is_sealed", [True, False])
def test_a_map_without_anything_comes_back(path, is_sealed):
    splat = GaussianSplat.empty()
    before = SceneMap(
        0, None, (), -np.inf, SphereToEllipsoidField(splat), splat
    )
    seal = write_map(path, before)
    after = open_map(path, seal if is_sealed else None)
    assert (after.parent, after.time, after.tiles) == (None, -np.inf, ())
    assert after.coverage is None
    assert len(after.field.clearances(SPHERES)) == 0


def turned_floor(n: int) -> GaussianSplat:
    """Discs in all directions, whose quaternions are rounded."""
    splat, rng = floor(n), np.random.default_rng(1)
    return GaussianSplat(
        **{name: getattr(splat, name) for name in vars(splat)}
        | {"quaternions": rng.normal(size=(n, 4))}
    )


def test_the_arrays_of_a_sealed_file_are_views_of_it(path):
    before = a_map(all_of)
    after = open_map(path, write_map(path, before))
    assert not after.splat_W.p_GK.flags.writeable
    for ours, theirs in zip(before.field.parts, after.field.parts, strict=True):
        for name, array in ours.prepared.items():
            view = theirs.prepared[name]
            assert not view.flags.owndata
            assert view.ctypes.data % 64 == 0
            # A kernel is compiled for read-only arrays or for others.
            assert numba.typeof(view) == numba.typeof(array)


def test_a_map_outlives_the_name_of_its_file(path):
    after = open_map(path, write_map(path, a_map()))
    path.unlink()
    assert len(after.field.clearances(SPHERES)) == 2


def test_a_map_that_fits_in_no_file_leaves_the_old_one(path):
    write_map(path, a_map())
    hopeless = SceneMap(4, 3, (), 0.0, field=lambda: None)  # pyright: ignore
    with pytest.raises(
        FileError, match="cannot hold this map: files cannot hold a fun"
    ):
        write_map(path, hopeless)
    foreign = SceneMap(4, 3, (), 0.0, SphereToEllipsoidField(floor()), floor(9))
    with pytest.raises(FileError, match="belongs to another splat"):
        write_map(path, foreign)
    assert open_map(path).version == 3
    assert os.listdir(path.parent) == [path.name]


def test_only_the_file_that_was_sealed_opens_with_its_seal(path):
    seal = write_map(path, a_map())
    write_map(path, a_map(splat=floor(400)))
    with pytest.raises(FileError, match="not the file that this program wrote"):
        open_map(path, seal)


def test_what_others_have_prepared_is_not_used(path):
    """A hierarchy without boxes would lead past everything."""
    write_map(path, a_map())
    header, pieces = mutations.take_apart(path.read_bytes())
    spoilt = bytes(len(pieces["field.wide"]))
    path.write_bytes(
        mutations.with_sums(header, pieces | {"field.wide": spoilt})
    )
    expected = a_map().field.clearances(SPHERES).distance
    answer = open_map(path).field.clearances(SPHERES).distance
    np.testing.assert_array_equal(answer, expected)


def refusal(path: Path) -> str:
    with pytest.raises(RemoSplatError) as error:
        open_map(path)
    assert "\n" not in str(error.value)
    assert str(path) in str(error.value)
    return str(error.value)


def test_a_missing_or_foreign_file_is_refused(path):
    assert "No such file" in refusal(path)
    path.write_bytes(b"")
    assert "too short" in refusal(path)
    path.write_bytes(b"ply")
    assert "too short" in refusal(path)
    path.write_bytes(b"ply\n" + bytes(1000))
    assert "is not a map" in refusal(path)
    path.unlink()
    path.mkdir()
    assert refusal(path)


def test_a_fifo_is_refused(path):
    os.mkfifo(path)
    assert "is not a file" in refusal(path)


def test_a_file_of_another_format_is_refused(path):
    write_map(path, a_map())
    data = bytearray(path.read_bytes())
    data[len(KIND.magic)] = 9
    path.write_bytes(data)
    assert (
        f"is a map of format 9; this program reads {KIND.version}"
        in refusal(path)
    )


def test_a_truncated_file_is_refused(path):
    write_map(path, a_map())
    whole = path.read_bytes()
    for length in (len(whole) - 1, len(whole) // 2, 60):
        path.write_bytes(whole[:length])
        assert "is truncated" in refusal(path)


def test_a_damaged_array_is_refused(path):
    """Moved discs were seen only by the caller."""
    splat = floor(50)
    write_map(path, a_map(splat=splat))
    whole = bytearray(path.read_bytes())
    for array in (splat.p_GK, splat.scales, some_coverage().state):
        place = whole.index(array.tobytes())
        data = bytearray(whole)
        data[place + 2] ^= 1
        path.write_bytes(data)
        assert "is damaged: the checksum of" in refusal(path)


def test_a_damaged_header_is_refused(path):
    write_map(path, a_map())
    data = bytearray(path.read_bytes())
    data[90] ^= 1
    path.write_bytes(data)
    assert "the checksum of its header is wrong" in refusal(path)


LIES = [
    (("document", "version"), -1, "must lie in"),
    (("document", "frames"), [7], "frames[0]: expected text"),
    (("document", "field", "kind"), "pickle", "unknown field 'pickle'"),
    (("document", "field", "settings", "n_sigma"), 1e9, "at most 1000"),
    (("document", "field", "settings", "bisection_steps"), 10**20, "got 1e+20"),
    (("document", "coverage", "voxel"), 0, "must be at least 0.0001"),
    (("document", "coverage", "lower"), [0, 0], "expected 3 numbers"),
    (("arrays", "splat.p_GK", "dtype"), "|O", "expected one of <f4"),
    (("arrays", "splat.p_GK", "shape"), [2**52, 3], "is too large"),
    (("arrays", "splat.p_GK", "shape"), [1] * 99, "too many dimensions"),
    (("arrays", "splat.p_GK", "shape"), [400, 3], "its arrays end at"),
    (("arrays", "coverage.state", "shape"), [60], "not a grid of bytes"),
]


@pytest.mark.parametrize(("way", "value", "problem"), LIES)
def test_a_file_that_lies_is_refused(path, way, value, problem):
    write_map(path, a_map())
    header, pieces = mutations.take_apart(path.read_bytes())
    inner = header
    for key in way[:-1]:
        inner = inner[key]
    inner[way[-1]] = value
    path.write_bytes(mutations.put_together(header, pieces))
    assert problem in refusal(path)


class Pointers:
    """As a pickle: an array of objects that are anywhere in memory."""

    def __reduce__(self):
        return np.ndarray, ((1,), np.dtype("O"), b"\x41" * 8)


class Follower:
    """As a pickle: what looks at these objects."""

    def __reduce__(self):
        return np.ndarray, (Pointers(), np.dtype("f8"))


def test_no_pickle_is_read(path):
    """Format 1 was one; numpy followed its pointers, and the program died."""
    body = pickle.dumps(Follower(), protocol=5)
    size = struct.calcsize("<8sIIQQII") + len(body)
    sums = zlib.crc32(body), 0
    head = struct.pack("<8sIIQQII", KIND.magic, 1, 0, len(body), size, *sums)
    path.write_bytes(head + body)
    code = (
        "import sys\n"
        "from remosplat_drake.mapping.store.map_file import open_map\n"
        "open_map(sys.argv[1])\n"
    )
    child = subprocess.run(
        [sys.executable, "-c", code, path], capture_output=True, text=True
    )
    assert child.returncode == 1, child.returncode  # Not -SIGSEGV.
    assert (
        f"is a map of format 1; this program reads {KIND.version}"
        in child.stderr
    )


def test_no_file_ends_the_program(path):
    """In a process of its own, so that its death is seen."""
    write_map(path, a_map(all_of, floor(40)))
    tries = effort(100, 400)
    child = subprocess.run(
        [sys.executable, mutations.__file__, path, "0", str(tries)],
        capture_output=True,
        text=True,
        timeout=PATIENCE,
    )
    last = child.stdout.splitlines()[-1:]
    assert child.returncode == 0, (last, child.stderr)
    # What was prepared may be spoilt, or the name of a frame.
    assert 0.05 < int(last[0].removeprefix("opened ")) / tries < 0.5
