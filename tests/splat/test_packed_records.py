"""One splat of each packed format, its bytes worked out by hand.

The splat lies at (1, -2, 3) and is turned by 90 degrees about -y; SPZ's axes
turn that into (1, 2, -3) and +y.
"""

import gzip
import json
import math
import struct
import zipfile

import numpy as np
import pytest
import zstandard
from PIL import Image

from remosplat_drake.splat.codecs.antimatter import write_antimatter
from remosplat_drake.splat.codecs.compressed_ply import write_compressed_ply
from remosplat_drake.splat.codecs.spz import write_spz
from remosplat_drake.splat.formats import read_splat
from remosplat_drake.splat.gaussian_splat import SH_C0, GaussianSplat

HALF = math.sqrt(0.5)
SPLAT = GaussianSplat(
    p_GK=np.array([[1.0, -2.0, 3.0]]),
    quaternions=np.array([[HALF, 0, -HALF, 0]]),
    scales=np.array([[1.0, math.exp(-1), math.exp(-5)]]),
    opacities=np.array([0.6]),
    colors=np.array([[0.0, 0.2, 1.0]]),
)


def expect(splat, atol: float = 1e-6, rotation: float = 1e-6):
    assert len(splat) == 1
    np.testing.assert_allclose(splat.p_GK, SPLAT.p_GK, atol=atol)
    np.testing.assert_allclose(splat.scales, SPLAT.scales, rtol=1e-6)
    np.testing.assert_allclose(splat.opacities, SPLAT.opacities, atol=1e-6)
    turn = np.abs(np.sum(splat.quaternions * SPLAT.quaternions))
    assert 1 - turn <= rotation


def test_antimatter(tmp_path):
    record = struct.pack("<6f", 1, -2, 3, *SPLAT.scales[0])
    # 0.6 * 255 = 153; 128 + 128 * 0.7071 = 218.5, 128 - 90.5 = 37.5.
    record += bytes([0, 51, 255, 153, 219, 128, 37, 128])
    path = tmp_path / "s.splat"
    path.write_bytes(record)
    splat = read_splat(path)
    expect(splat, rotation=1e-4)
    np.testing.assert_allclose(splat.colors, SPLAT.colors, atol=1e-6)
    write_antimatter(path, SPLAT)
    assert path.read_bytes()[:30] == record[:30]


SPZ_HEADER = struct.Struct("<4sIIBBBB")
SPZ_POSITION = bytes.fromhex("001000 002000 00d0ff")  # 4096, 8192, -12288
SPZ_ALPHA = bytes([153])
SPZ_COLOR = bytes([0, 128, 255])
SPZ_SCALE = bytes([160, 144, 80])  # 16 (log s + 10)
SPZ_ROTATION = struct.pack("<I", 3 << 30 | 511 << 10)  # w is left out
SPZ_COLORS = [
    0.5 - SH_C0 * 0.5 / 0.15,
    0.5 + SH_C0 * (128 / 255 - 0.5) / 0.15,
    0.5 + SH_C0 * 0.5 / 0.15,
]


@pytest.mark.parametrize(
    ("version", "position", "rotation"),
    [
        (1, struct.pack("<3e", 1, 2, -3), None),
        (2, SPZ_POSITION, None),
        (3, SPZ_POSITION, SPZ_ROTATION),
    ],
)
def test_gzipped_spz(version, position, rotation, tmp_path):
    # 127.5 (1 + 0.7071) = 217.7 for y; zero lies between 127 and 128.
    rotation = rotation or bytes([128, 218, 128])
    content = b"".join(
        [
            SPZ_HEADER.pack(b"NGSP", version, 1, 0, 12, 0, 0),
            *(position, SPZ_ALPHA, SPZ_COLOR, SPZ_SCALE, rotation),
        ]
    )
    path = tmp_path / "s.spz"
    path.write_bytes(gzip.compress(content))
    splat = read_splat(path)
    expect(splat, rotation=1e-4 if version < 3 else 1e-6)
    np.testing.assert_allclose(splat.colors, [SPZ_COLORS], atol=1e-6)
    if version == 3:
        write_spz(path, splat)
        written = gzip.decompress(path.read_bytes())
        # A half is the largest component either way: w, or y.
        assert written[:-4] == content[:-4]
        expect(read_splat(path))


def test_spz_of_version_4_with_extensions(tmp_path):
    sections = [SPZ_POSITION, SPZ_ALPHA, SPZ_COLOR, SPZ_SCALE, SPZ_ROTATION]
    # Degree 1: of y, z and x, the first two change sign with the axes.
    sections.append(bytes([192] * 3 + [160] * 3 + [144] * 3))
    streams = [zstandard.compress(section) for section in sections]
    extension = struct.pack("<II4s", 1, 4, b"data")
    start = 32 + len(extension)
    header = SPZ_HEADER.pack(b"NGSP", 4, 1, 1, 12, 2, 6)
    table = b"".join(
        struct.pack("<QQ", len(stream), len(section))
        for stream, section in zip(streams, sections, strict=True)
    )
    path = tmp_path / "s.spz"
    path.write_bytes(
        header
        + struct.pack("<I12x", start)
        + extension
        + table
        + b"".join(streams)
    )
    splat = read_splat(path)
    expect(splat)
    np.testing.assert_allclose(
        splat.sh_rest[0], np.repeat([[-0.5], [-0.25], [0.125]], 3, axis=1)
    )


CHUNK = {
    **{"min_x": 0, "min_y": -4, "min_z": 3, "max_x": 2.047, "max_y": 4},
    **{"max_z": 3, "min_scale_x": -20, "min_scale_y": -1, "min_scale_z": -5},
    **{"max_scale_x": 0, "max_scale_y": 9, "max_scale_z": -5},
    **{"min_r": 0, "min_g": 0, "min_b": -1, "max_r": 1, "max_g": 0.2},
    "max_b": 1,
}


@pytest.mark.parametrize("with_color", [True, False])
def test_compressed_ply(tmp_path, with_color):
    bounds = {
        name: value
        for name, value in CHUNK.items()
        if with_color or name[-2:] not in ("_r", "_g", "_b")
    }
    header = [
        *("ply", "format binary_little_endian 1.0", "element chunk 1"),
        *(f"property float {name}" for name in bounds),
        "element vertex 1",
        *(
            f"property uint packed_{name}"
            for name in ("position", "rotation", "scale", "color")
        ),
        *("element sh 1", *(f"property uchar f_rest_{i}" for i in range(9))),
        "end_header\n",
    ]
    position = 1000 << 21 | 256 << 11 | 5  # 1 m; -1.998 m; no extent
    # w is left out; -HALF is the least of a field: 0; zero is 511.5.
    rotation = 0 << 30 | 512 << 20 | 0 << 10 | 511
    scale = 2047 << 21 | 0 << 11 | 9
    color = 0 << 24 | 255 << 16 | 255 << 8 | 153
    path = tmp_path / "s.compressed.ply"
    path.write_bytes(
        "\n".join(header).encode()
        + struct.pack(f"<{len(bounds)}f", *bounds.values())
        + struct.pack("<4I", position, rotation, scale, color)
        + bytes([0, 127, 128, 255, 192, 0, 0, 0, 0])
    )
    splat = read_splat(path)
    expect(splat, atol=2e-3, rotation=1e-5)
    np.testing.assert_allclose(
        splat.colors, [[0, 0.2 if with_color else 1, 1]], atol=1e-6
    )
    # Channel-major: red has bytes 0, 127, 128, green 255, 192, 0.
    np.testing.assert_allclose(
        splat.sh_rest[0, :, :2],
        [[-4, 4], [-1 / 64, 129 / 64], [1 / 64, -4]],
    )


def test_compressed_ply_is_written_as_it_is_defined(tmp_path):
    path = tmp_path / "s.compressed.ply"
    write_compressed_ply(path, SPLAT)
    body = path.read_bytes().partition(b"end_header\n")[2]
    bounds = struct.unpack_from("<18f", body)
    np.testing.assert_allclose(bounds[:6], [1, -2, 3, 1, -2, 3])
    np.testing.assert_allclose(bounds[6:12], [0, -1, -5, 0, -1, -5], atol=1e-6)
    rotation, _, color = struct.unpack_from("<3I", body, 18 * 4 + 4)
    assert color & 255 == 153
    assert rotation >> 30 in (0, 2)


def save_webp(path, rows):
    pixels = np.array([rows], np.uint8)
    Image.fromarray(pixels, "RGBA").save(path, lossless=True, exact=True)


@pytest.mark.parametrize("kind", ["folder", "meta", "zip"])
def test_sog(tmp_path, kind):
    folder = tmp_path / "scene"
    folder.mkdir()
    # Logarithmic positions from 0 or to 0: log 2 = 20000 steps, and so on.
    steps = [20000, 65535 - 40000, 30000]
    save_webp(folder / "l.webp", [[*(s & 255 for s in steps), 255]])
    save_webp(folder / "u.webp", [[*(s >> 8 for s in steps), 255]])
    # w is left out: 255 (0.5 (1 + sqrt(2) q)), and 127 or 128 for zero.
    save_webp(folder / "quats.webp", [[127, 0, 128, 252]])
    save_webp(folder / "scales.webp", [[7, 8, 9, 255]])
    save_webp(folder / "sh0.webp", [[1, 0, 2, 153]])
    # Splat 0 has label 65 of a palette of 66 in rows of 64, degree 1.
    save_webp(folder / "labels.webp", [[65, 0, 0, 255]])
    palette = np.zeros((2, 64 * 3, 4), np.uint8)
    palette[1, 3:6, :3] = [[1, 0, 0], [0, 1, 0], [0, 0, 2]]
    image = Image.fromarray(palette, "RGBA")
    image.save(folder / "centroids.webp", lossless=True, exact=True)
    book = [0.0] * 256
    scales = [*book[:7], 0, -1, -5, *book[10:]]
    f_dc = [(c - 0.5) / SH_C0 for c in (0.2, 0, 1)] + book[3:]
    far = [math.log(v) * 65535 / s for v, s in ((2, 20000), (4, 30000))]
    near = -math.log(3) * 65535 / 40000
    meta = {
        "version": 2,
        "count": 1,
        "means": {
            "mins": [0, near, 0],
            "maxs": [far[0], 0, far[1]],
            "files": ["l.webp", "u.webp"],
        },
        "quats": {"files": ["quats.webp"]},
        "scales": {"codebook": scales, "files": ["scales.webp"]},
        "sh0": {"codebook": f_dc, "files": ["sh0.webp"]},
        "shN": {
            "count": 66,
            "bands": 1,
            "codebook": [0, 0.5, -0.25, *book[3:]],
            "files": ["centroids.webp", "labels.webp"],
        },
    }
    (folder / "meta.json").write_text(json.dumps(meta))
    path = {"folder": folder, "meta": folder / "meta.json"}.get(kind)
    if path is None:
        path = tmp_path / "s.sog"
        with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as archive:
            for part in sorted(folder.iterdir()):
                archive.write(part, part.name)
    splat = read_splat(path)
    expect(splat, rotation=1e-4)
    np.testing.assert_allclose(splat.colors, SPLAT.colors, atol=1e-6)
    np.testing.assert_array_equal(splat.sh_rest[0], np.diag([0.5, 0.5, -0.25]))
