"""Damaged and senseless captures give one line that names what is wrong."""

import json
import zipfile

import capture_writers as writers
import numpy as np
import pytest
from PIL import Image

from remosplat_drake.base.errors import RemoSplatError
from remosplat_drake.capture.capture import check_reconstructible
from remosplat_drake.capture.formats import read_capture
from remosplat_drake.capture.images import MAX_PIXELS

lzfse = pytest.importorskip("lzfse")
pytest.importorskip("av")
pytest.importorskip("OpenEXR")

PACKED_BOMB = 25 * lzfse.compress(bytes(10_000_000))[:-4] + b"bvx$"
"""150 kB that unpack to 250 MB."""

GREEDY = lzfse.compress(bytes(range(200)) + bytes(1528))
GREEDY = GREEDY[:12] + bytes(1) + GREEDY[13:]
"""A block whose damage makes the decoder ask for more and more memory."""

TALL = np.zeros((20, 10), np.uint16)


def replace(name, new):
    """A damage: a file gets other text or bytes, or is deleted."""

    def damage(folder):
        path = folder / name
        if new is None:
            path.unlink()
        elif isinstance(new, bytes):
            path.write_bytes(new)
        elif isinstance(new, np.ndarray):
            writers.save_image(path, new)
        else:
            path.write_text(new)

    return damage


def cut(name, keep=0.5):
    """A damage: only the beginning of a file is left."""

    def damage(folder):
        data = (folder / name).read_bytes()
        (folder / name).write_bytes(data[: int(keep * len(data))])

    return damage


def swap(name, old, new):
    """A damage: some bytes of a file are others."""

    def damage(folder):
        data = (folder / name).read_bytes()
        assert old in data
        (folder / name).write_bytes(data.replace(old, new))

    return damage


def pose(matrix):
    text = "\n".join(" ".join(map(str, row)) for row in matrix)
    return replace("frame-000002.pose.txt", text)


def huge_png():
    """A small file that claims to be a very large image."""
    from io import BytesIO

    file = BytesIO()
    Image.new("L", (1, 1)).save(file, "png")
    data = bytearray(file.getvalue())
    side = (int(MAX_PIXELS**0.5) + 100).to_bytes(4, "big")
    data[16:24] = side + side
    # The header's own sum, so that the size is what is wrong with it.
    import zlib

    data[29:33] = zlib.crc32(bytes(data[12:29])).to_bytes(4, "big")
    return bytes(data)


MOVED = np.eye(4) + np.eye(4, k=3) * 0.5
MIRROR = np.diag([1.0, 1, -1, 1])
DOUBLE = np.diag([2.0, 2, 2, 1])
SHEAR = np.eye(4) + np.eye(4, k=1) * [[0.3], [0], [0], [0]]
NAN = np.full((4, 4), np.nan)
DEPTH_2 = "frame-000002.depth.png"
COLOR_2 = "frame-000002.color.png"

BAD_SEVEN_SCENES = [
    (replace(DEPTH_2, None), r"000002\.depth\.png: no such file"),
    (replace(COLOR_2, None), r"000002\.color\.png: no such file"),
    (cut(DEPTH_2), r"000002\.depth\.png: unreadable image"),
    (cut(COLOR_2, 0.9), r"000002\.color\.png: unreadable image"),
    (replace(COLOR_2, b"no image"), r"000002\.color\.png: unreadable"),
    (replace(COLOR_2, huge_png()), r"000002\.color\.png: .*million|unreadable"),
    (replace(DEPTH_2, np.zeros((90, 120), np.uint8)), "expected 16-bit or flo"),
    (replace(COLOR_2, np.zeros((90, 120), np.uint16)), "expected 8-bit col"),
    (replace(DEPTH_2, TALL), r"000002: colour \(120x90\) and depth \(10x20\)"),
    (replace(DEPTH_2, np.zeros((45, 60), np.uint16)), "images differ in size"),
    (pose(MIRROR), "frame-000002: its pose is a reflection"),
    (pose(DOUBLE), "frame-000002: its pose is scaled by 2"),
    (pose(SHEAR), "frame-000002: its pose has no valid rotation"),
    (pose(MOVED.T), "frame-000002: the last row of its pose must be 0 0 0 1"),
    (pose(NAN), "frame-000002: its camera or pose is not finite"),
    (pose(np.eye(3)), r"pose\.txt: expected a 4x4 matrix"),
    (pose([["a"] * 4] * 4), r"pose\.txt: expected numbers"),
    (replace("camera-intrinsics.txt", None), "no intrinsics; expected"),
    (replace("camera-intrinsics.txt", "1 2"), r"rinsics\.txt: expected a 3x3"),
    (replace("camera-intrinsics.txt", "0 0 1\n0 0 1\n0 0 1"), "focal lengths"),
    (replace("camera-intrinsics.txt", b"\xff\xfe\x00"), "unreadable text"),
]
BAD_TUM = [
    (
        replace("rgb.txt", ""),
        r"rgb\.txt: expected a time and a file in each line",
    ),
    (replace("depth.txt", "1.0"), r"depth\.txt: expected a time"),
    (replace("depth.txt", "x a.png"), r"depth\.txt: expected numbers"),
    (
        replace("depth.txt", "9e9 a.png"),
        "no frame has colour, depth and pose within",
    ),
    (replace("rgb.txt", "100 no.png"), r"no\.png: no such file"),
    (replace("groundtruth.txt", "1 2 3"), r"groundtruth\.txt: expected a 1x8"),
    (replace("groundtruth.txt", "1 0 0 0 0 0 0 1"), "at least two poses"),
    (
        replace("groundtruth.txt", "1 0 0 0 0 0 0 0\n2 0 0 0 0 0 0 1"),
        "a pose has no rotation: a quaternion is zero",
    ),
    (
        replace("groundtruth.txt", "1 nan 0 0 0 0 0 1\n2 0 0 0 0 0 0 1"),
        "poses must be finite",
    ),
]
BAD_TRAJECTORY_LOG = [
    (replace("trajectory.log", ""), "expected five lines for each frame"),
    (replace("trajectory.log", "0 0 1\n1 0 0 0"), "expected five lines"),
    (cut("trajectory.log", 0.7), "expected"),
    (replace("depth/00003.png", None), "4 colour images, but 3 depth images"),
    (replace("camera_primesense.json", "{}"), "camera_primesense.json: expec"),
    (replace("camera_primesense.json", "[1"), "camera_primesense.json: not JS"),
]
BAD_STRAY_SCANNER = [
    (replace("depth/000001.png", None), r"000001\.png: no such file"),
    (replace("rgb.mp4", b"no video"), r"rgb\.mp4: unreadable video"),
    (cut("rgb.mp4"), r"rgb\.mp4: unreadable video"),
    (
        swap("rgb.mp4", b"avc1", b"zzzz"),
        r"rgb\.mp4: contains no video that can",
    ),
    (replace("odometry.csv", ""), r"odometry\.csv: expected a header"),
    (replace("odometry.csv", "frame, x\n0, 1"), "has no column y, z, qx"),
    (
        replace("odometry.csv", "frame,x,y,z,qx,qy,qz,qw\n0,1,2,3,0,0,0"),
        r"odometry\.csv: a row is shorter",
    ),
    (
        replace("odometry.csv", "frame,x,y,z,qx,qy,qz,qw\n0,1,2,3,0,0,0,w"),
        r"odometry\.csv: expected numbers",
    ),
    (
        replace("odometry.csv", "frame,x,y,z,qx,qy,qz,qw\n0,1,2,3,0,0,0,0"),
        r"odometry\.csv: a quaternion is zero",
    ),
    (
        replace("odometry.csv", "frame,x,y,z,qx,qy,qz,qw\n0,1,2,3,0,0,nan,0"),
        "frame 000000: its camera or pose is not finite",
    ),
]
BAD = [
    *[("7-scenes", *case) for case in BAD_SEVEN_SCENES],
    *[("tum", *case) for case in BAD_TUM],
    *[("trajectory-log", *case) for case in BAD_TRAJECTORY_LOG],
    *[("stray-scanner", *case) for case in BAD_STRAY_SCANNER],
    ("record3d-export", replace("depth/1.exr", None), r"1\.exr: no such file"),
    ("record3d-export", replace("depth/1.exr", b"x"), r"1\.exr: unreadable"),
    ("record3d-export", cut("depth/1.exr"), r"1\.exr: unreadable"),
    ("nerfstudio", replace("transforms.json", "{"), "not JSON"),
    ("nerfstudio", replace("transforms.json", "[" * 10**5), "not JSON"),
    ("nerfstudio", replace("transforms.json", "[1]"), "expected a JSON object"),
    ("nerfstudio", replace("images/0001.png", b""), "0001.png: unreadable"),
]


@pytest.mark.parametrize(("name", "damage", "match"), BAD)
def test_names_what_is_wrong(name, damage, match, scene_capture, tmp_path):
    writers.WRITERS[name](tmp_path, scene_capture.select(np.arange(4)))
    damage(tmp_path)
    with pytest.raises(RemoSplatError, match=match) as info:
        read_capture(tmp_path, name.removesuffix("-export"))
    assert "\n" not in str(info.value)
    assert str(tmp_path) in str(info.value)


def change(**members):
    """A damage: members get other content (`__` for / and `_` for .)."""

    def damage(all_members):
        for key, data in members.items():
            name = key.replace("__", "/").replace("_", ".")
            if data is None:
                del all_members[name]
            else:
                all_members[name] = data

    return damage


def other_metadata(**fields):
    """A damage: the metadata have other values."""

    def damage(all_members):
        metadata = json.loads(all_members["metadata"]) | fields
        all_members["metadata"] = json.dumps(metadata).encode()

    return damage


@pytest.mark.filterwarnings("error::RuntimeWarning")
@pytest.mark.parametrize(
    ("damage", "match"),
    [
        (change(metadata=None), "metadata: no such file"),
        (change(metadata=b"{}"), "metadata: h: expected a number"),
        (
            change(metadata=b'{"h": 9, "w": 0}'),
            "metadata: h, w: the image must have",
        ),
        (
            change(metadata=b'{"h": 1e308, "w": 9}'),
            "h, w: the image must have 1 to",
        ),
        (
            change(metadata=b'{"h": 9, "w": 1e30}'),
            "h, w: the image must have 1 to",
        ),
        (change(metadata=b"[" * 10**5), "metadata: not JSON that"),
        (other_metadata(h=1e308), "h, w: the image must have 1 to"),
        (other_metadata(dh=1e308), "dh, dw: the image must have 1 to"),
        (other_metadata(K=[1e308] * 9), "camera has numbers above 1e9"),
        (other_metadata(poses=[[0] * 3 + [1, np.inf, 0, 0]]), "not finite"),
        (other_metadata(poses=[[1e308] * 7]), "camera has numbers above 1e9"),
        (change(metadata=b'{"h": 9, "w": 9}'), "metadata: poses: expected"),
        (
            change(metadata=b'{"h": 9, "w": 9, "poses": [[1, 2]]}'),
            "metadata: poses: expected a 1x7 matrix",
        ),
        (change(rgbd__1_jpg=None), r"rgbd/1\.jpg: no such file"),
        (change(rgbd__1_jpg=b"x"), r"rgbd/1\.jpg: unreadable image"),
        (change(rgbd__1_depth=None), r"rgbd/1\.depth: no such file"),
        (change(rgbd__1_depth=b"bvx2"), r"rgbd/1\.depth: damaged LZFSE"),
        (change(rgbd__1_depth=b"bvx2" + bytes(99)), "damaged LZFSE"),
        (change(rgbd__1_depth=GREEDY), r"rgbd/1\.depth: damaged LZFSE"),
        (change(rgbd__1_depth=b"none"), r"rgbd/1\.depth: damaged LZFSE"),
        (
            change(rgbd__1_depth=lzfse.compress(bytes(8))),
            r"rgbd/1\.depth: expected 120x90 float32 depths, got 8 bytes",
        ),
        (
            change(rgbd__1_depth=PACKED_BOMB),
            r"rgbd/1\.depth: unpacks to more than",
        ),
        (
            change(rgbd__1_conf=lzfse.compress(bytes(120 * 90 + 1))),
            r"rgbd/1\.conf: unpacks to more than 10800 bytes",
        ),
        (
            change(rgbd__1_conf=lzfse.compress(bytes(7))),
            r"rgbd/1\.conf: has 7 levels for 10800 depths",
        ),
    ],
)
def test_names_what_is_wrong_in_an_archive(
    damage, match, scene_capture, tmp_path
):
    members = writers.record3d_members(scene_capture.select(np.arange(2)))
    damage(members)
    writers.write_archive(tmp_path / "scan.r3d", members)
    with pytest.raises(RemoSplatError, match=match) as info:
        read_capture(tmp_path / "scan.r3d")
    assert "\n" not in str(info.value)


def test_refuses_what_is_no_archive(scene_capture, tmp_path):
    path = tmp_path / "scan.r3d"
    path.write_bytes(b"no archive")
    with pytest.raises(RemoSplatError, match=r"scan\.r3d: unreadable archive"):
        read_capture(path)
    writers.write_record3d(path, scene_capture.select(np.arange(2)))
    path.write_bytes(path.read_bytes()[:-40])
    with pytest.raises(RemoSplatError, match=r"scan\.r3d: unreadable archive"):
        read_capture(path)


def test_refuses_an_archive_that_would_fill_the_memory(tmp_path):
    """64 kB that unpack to 65 MB; nothing is unpacked to find that out."""
    path = tmp_path / "scan.r3d"
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr("metadata", bytes(65_000_000))
    with pytest.raises(RemoSplatError, match="metadata has 65 MB"):
        read_capture(path)


def test_archives_cannot_reach_other_files(scene_capture, tmp_path):
    """Members are read by name, never written to disk."""
    members = writers.record3d_members(scene_capture.select(np.arange(2)))
    members["../escaped.txt"] = b"x"
    folder = tmp_path / "inner"
    writers.write_archive(folder / "scan.r3d", members)
    assert len(read_capture(folder / "scan.r3d")) == 2
    assert sorted(p.name for p in tmp_path.iterdir()) == ["inner"]


def test_one_frame_and_no_depth_cannot_be_reconstructed(
    scene_capture, tmp_path
):
    writers.write_seven_scenes(tmp_path, scene_capture.select(np.arange(2)))
    with pytest.raises(RemoSplatError, match="1 view"):
        check_reconstructible(read_capture(tmp_path, stride=2))
    nothing = np.full((90, 120), 65535, np.uint16)
    for i in range(2):
        writers.save_image(tmp_path / f"frame-{i:06d}.depth.png", nothing)
    with pytest.raises(RemoSplatError, match="too few for"):
        check_reconstructible(read_capture(tmp_path))
