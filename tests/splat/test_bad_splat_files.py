"""Damaged, truncated, swollen and foreign files: one line that names them."""

import gzip
import struct
import sys
import tracemalloc

import numpy as np
import pytest
import zstandard
from hypothesis import given, settings
from hypothesis import strategies as st
from optional import needs_torch
from toy_splats import rejected

from remosplat_drake.base.errors import (
    FileError,
    MissingExtraError,
    RemoSplatError,
)
from remosplat_drake.splat.codecs.unpacking import (
    MAX_SPLATS,
    check_unpacked_size,
)
from remosplat_drake.splat.formats import FORMATS, read_splat

SUFFIXES = [
    pytest.param(suffix, marks=needs_torch if suffix == ".pt" else ())
    for suffix in sorted(format_.suffix for format_ in FORMATS)
]
PNG = b"\x89PNG\r\n\x1a\n\0\0\0\rIHDR" + bytes(20)
SPZ_HEADER = struct.Struct("<4sIIBBBB")


@pytest.mark.parametrize("suffix", SUFFIXES)
@pytest.mark.parametrize(
    "content",
    [b"", b"\0", PNG, b"PK\x03\x04", b"\x1f\x8b\x08", b"NGSP", b"ply\n", b"{}"],
)
def test_foreign_content(tmp_path, suffix, content):
    path = tmp_path / f"s{suffix}"
    path.write_bytes(content)
    rejected(path)


def test_nothing_tells_the_format(tmp_path):
    path = tmp_path / "photo.png"
    path.write_bytes(PNG)
    rejected(path, r"not a known format of splats; valid: .*\.sog, \.splat")
    rejected(tmp_path, "folder without meta.json")
    rejected(tmp_path / "nowhere.spz", "No such file")
    (tmp_path / "s.sog").write_bytes(b"")
    rejected(tmp_path / "s.sog" / "inside.spz", "Not a directory")


@pytest.mark.parametrize("suffix", [*SUFFIXES, "4.spz"])
def test_truncated_anywhere(tmp_path, whole_files, suffix):
    path = tmp_path / f"ckpt_0.{suffix}"
    data = whole_files[suffix]
    for length in np.linspace(0, len(data) - 1, 40).astype(int):
        # A .splat has no end mark: any 32 bytes are a splat.
        if suffix != ".splat" or length % 32:
            path.write_bytes(data[:length])
            rejected(path)


@given(data=st.data())
@settings(max_examples=60)
def test_changed_bytes_never_escape(data, whole_files, tmp_path_factory):
    suffix = data.draw(st.sampled_from(sorted(whole_files)))
    content = bytearray(whole_files[suffix])
    path = tmp_path_factory.mktemp("changed") / f"ckpt_0.{suffix}"
    for _ in range(data.draw(st.integers(1, 4))):
        where = data.draw(st.integers(0, len(content) - 1))
        content[where] = data.draw(st.integers(0, 255))
    path.write_bytes(content)
    try:
        assert np.isfinite(read_splat(path).scales).all()
    except RemoSplatError as error:
        assert "\n" not in str(error)


@pytest.mark.parametrize("name", ["p_GK", "scales"])
def test_values_that_no_splat_can_have(tmp_path, name):
    row = {"p_GK": [0.0] * 3, "scales": [1.0] * 3}
    for value in (np.nan, np.inf):
        bad = {**row, name: [value, *row[name][1:]]}
        data = struct.pack("<6f8B", *bad["p_GK"], *bad["scales"], *[255] * 8)
        (tmp_path / "s.splat").write_bytes(data)
        rejected(tmp_path / "s.splat", f"{name} of splat 0 is not finite")
    data = struct.pack("<6f8B", *[1.0] * 6, *[255] * 4, *[128] * 4)
    (tmp_path / "s.splat").write_bytes(data)
    rejected(tmp_path / "s.splat", "quaternion is zero")
    data = struct.pack("<6f8B", *[-1.0] * 6, *[255] * 8)
    (tmp_path / "s.splat").write_bytes(data)
    rejected(tmp_path / "s.splat", "scale of splat 0 is not positive")


@pytest.mark.parametrize(
    ("header", "problem"),
    [
        ((b"NOPE", 2, 1, 0, 12, 0, 0), "gzipped, but without splats"),
        ((b"NGSP", 5, 1, 0, 12, 0, 0), "version 5"),
        ((b"NGSP", 4, 1, 0, 12, 0, 0), "version 4"),
        ((b"NGSP", 2, 0, 0, 12, 0, 0), "holds no splats"),
        ((b"NGSP", 2, 1, 5, 12, 0, 0), "degree 5"),
        ((b"NGSP", 2, 1, 0, 24, 0, 0), "24 fractional bits"),
        ((b"NGSP", 2, 2, 0, 12, 0, 0), "declares 2 splats"),
        ((b"NGSP", 3, 1, 0, 12, 0, 0), "declares 1 splats"),
        ((b"NGSP", 2, 2**32 - 1, 3, 12, 0, 0), f"at most {MAX_SPLATS}"),
        ((b"NGSP", 2, MAX_SPLATS, 3, 12, 0, 0), "made to exhaust the memory"),
        ((b"NGSP", 1, 1, 0, 12, 0, 0), "holds more than the 1 splats"),
    ],
)
def test_spz_headers(tmp_path, header, problem):
    path = tmp_path / "s.spz"
    body = bytes([128]) * (9 + 1 + 3 + 3 + 3)
    path.write_bytes(gzip.compress(SPZ_HEADER.pack(*header) + body))
    rejected(path, problem)


def spz4(table, streams, num_streams=5, count=1, offset=32) -> bytes:
    return b"".join(
        [
            SPZ_HEADER.pack(b"NGSP", 4, count, 0, 12, 0, num_streams),
            struct.pack("<I12x", offset),
            *(struct.pack("<QQ", *entry) for entry in table),
            *streams,
        ]
    )


def test_spz_of_version_4(tmp_path):
    path = tmp_path / "s.spz"
    sizes = [9, 1, 3, 3, 4]
    streams = [zstandard.compress(bytes([200]) * size) for size in sizes]
    table = [(len(s), size) for s, size in zip(streams, sizes, strict=True)]
    path.write_bytes(spz4(table, streams))
    assert len(read_splat(path)) == 1
    for problem, content in {
        "4 streams; expected 5": spz4(table, streams, num_streams=4),
        "lies outside": spz4(table, streams, offset=10**6),
        "declares a stream of 8": spz4([(9, 8), *table[1:]], streams),
        "ends beyond": spz4([(10**15, 9), *table[1:]], streams),
        "splats need 18": spz4(table, streams, count=2),
        "not of its declared size": spz4(
            table, [zstandard.compress(bytes(8)), *streams[1:]]
        ),
        "damaged: ": spz4(table, [bytes(len(streams[0])), *streams[1:]]),
    }.items():
        path.write_bytes(content)
        rejected(path, problem)


def test_a_file_that_swells_takes_no_memory(tmp_path):
    """Fifty megabytes of zeros, where twenty bytes are announced."""
    zeros = bytes(5 * 10**7)
    header = SPZ_HEADER.pack(b"NGSP", 2, 1, 0, 12, 0, 0)
    gzipped, streamed = tmp_path / "a.spz", tmp_path / "b.spz"
    gzipped.write_bytes(gzip.compress(header + zeros, 1))
    bomb = zstandard.compress(zeros)
    streamed.write_bytes(spz4([(len(bomb), 9)] + [(0, 1)] * 4, [bomb]))
    del zeros
    tracemalloc.start()
    try:
        rejected(gzipped, "holds more than the 1 splats")
        rejected(streamed, "not of its declared size")
        _, peak = tracemalloc.get_traced_memory()
    finally:
        tracemalloc.stop()
    assert peak < 10**7


def test_what_may_be_unpacked(tmp_path):
    check_unpacked_size(tmp_path, 1, 2**26)
    check_unpacked_size(tmp_path, 10**6, 10**9)
    with pytest.raises(FileError, match="1000 bytes would unpack to 100000000"):
        check_unpacked_size(tmp_path, 1000, 10**8)


def test_compressed_ply_counts(tmp_path, whole_files):
    path = tmp_path / "s.compressed.ply"
    data = whole_files[".compressed.ply"]
    for old, new, problem in [
        (b"element vertex 20", b"element vertex 300", "row|element"),
        (b"element vertex 20", b"element vertex 19", "more data|rows"),
        (b"element chunk 1", b"element chunk 999999999999", "memory|row"),
        (b"element sh 20", b"element sh 0", "more data"),
        (b"float min_x", b"float least", "min_x is missing"),
        (b"uint packed_scale", b"int packed_scale", "type int32; expected"),
        (b"element vertex", b"element corner", "no element 'vertex'"),
        (b"uchar f_rest_8", b"uchar f_rest_9", "f_rest_8 is missing"),
    ]:
        assert old in data
        path.write_bytes(data.replace(old, new, 1))
        rejected(path, problem)


@pytest.mark.parametrize("suffix", [".ply", ".compressed.ply"])
@pytest.mark.parametrize(
    ("count", "problem"),
    [
        (b"-10", "-10 rows"),
        (b"-1", "-1 rows"),
        (b"9" * 30, "9 rows"),
        (b"4000000000", "4000000000 rows"),
        (b"1e3", "expected integer count"),
        (b"many", "expected integer count"),
    ],
)
def test_ply_counts(tmp_path, whole_files, suffix, count, problem):
    path = tmp_path / f"s{suffix}"
    data = whole_files[suffix]
    assert b"element vertex 20" in data
    path.write_bytes(
        data.replace(b"element vertex 20", b"element vertex " + count)
    )
    rejected(path, problem)


@pytest.mark.filterwarnings("error")
@pytest.mark.parametrize("number", ["1e300", "1e999", "-nan", "9" * 5000])
def test_text_ply_numbers_that_no_float_holds(tmp_path, number):
    path = tmp_path / "s.ply"
    names = "x y z f_dc_0 f_dc_1 f_dc_2 opacity scale_0 scale_1"
    names = [*names.split(), *(f"rot_{i}" for i in range(4))]
    properties = "".join(f"property float {name}\n" for name in names)
    numbers = " ".join([number, *["1"] * (len(names) - 1)])
    path.write_text(
        "ply\nformat ascii 1.0\nelement vertex 1\n"
        f"{properties}end_header\n{numbers}\n"
    )
    rejected(path, "row 0: x is not finite")


def test_ply_lists_take_no_memory(tmp_path):
    """A list may say that it is long; it is refused before it is read."""
    path = tmp_path / "s.ply"
    header = (
        b"ply\nformat binary_little_endian 1.0\nelement vertex 1\n"
        b"property list uint double x\nend_header\n"
    )
    path.write_bytes(header + struct.pack("<I", 2**32 - 1))
    tracemalloc.start()
    try:
        rejected(path, "property x is a list")
        _, peak = tracemalloc.get_traced_memory()
    finally:
        tracemalloc.stop()
    assert peak < 10**7


@pytest.mark.parametrize(
    ("suffix", "module", "extra"),
    [
        ("4.spz", "zstandard", "formats"),
        (".sog", "PIL", "formats"),
        pytest.param(".pt", "torch", "gpu", marks=needs_torch),
    ],
)
def test_missing_extras_are_named(
    tmp_path, whole_files, monkeypatch, suffix, module, extra
):
    monkeypatch.setitem(sys.modules, module, None)
    path = tmp_path / f"s.{suffix}"
    path.write_bytes(whole_files[suffix])
    with pytest.raises(MissingExtraError, match=rf"\[{extra}\]"):
        read_splat(path)
