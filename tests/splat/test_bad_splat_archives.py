"""Zip archives that hold no good splat: SOG bundles."""

import io
import json

import pytest
from PIL import Image
from toy_splats import rejected, resaved

from remosplat_drake.splat.formats import read_splat

PNG = b"\x89PNG\r\n\x1a\n" + bytes(20)


def changed_meta(data: bytes, field: str, value) -> bytes:
    def change(name, content):
        if name != "meta.json":
            return content
        meta = json.loads(content)
        *parents, last = field.split(".")
        target = meta
        for parent in parents:
            target = target[parent]
        if value is None:
            del target[last]
        else:
            target[last] = value
        return json.dumps(meta)

    return resaved(data, change)


@pytest.mark.parametrize(
    ("field", "value", "problem"),
    [
        ("version", 1, "SOG version 1; this program reads version 2"),
        ("version", None, "SOG version None"),
        ("count", "many", "count is not a whole number"),
        ("count", 0, "holds no splats"),
        ("count", 10**12, "declares 1000000000000 splats"),
        ("count", 30, "25 pixels|pixels for 30 splats"),
        ("means", 3, "means.files is missing"),
        ("means.mins", [0, 0], "means.mins is not a list of 3"),
        ("means.maxs", [0, 0, 1e999], "means.maxs is not a list of 3 finite"),
        ("means.maxs", [0, 0, 1e9], "p_GK of splat .* is not finite"),
        ("means.files", ["means_l.webp"], "not a list of 2 names"),
        ("quats.files", ["../../secret"], "not a list of 1 names"),
        ("quats.files", ["nowhere.webp"], "nowhere.webp is missing"),
        ("quats.files", ["meta.json"], "meta.json is not a WebP picture"),
        ("quats.files", ["means_l.webp"], None),
        ("quats.files", ["sh0.webp"], "splat .* has no rotation"),
        ("scales.codebook", [1, 2], "scales.codebook is not a list of 256"),
        ("sh0.codebook", ["x"] * 256, "sh0.codebook is not a list of 256"),
        ("shN", {"count": 1, "bands": 9}, "expected 1 to 3 bands"),
    ],
)
def test_sog_descriptions(tmp_path, whole_files, field, value, problem):
    path = tmp_path / "s.sog"
    path.write_bytes(changed_meta(whole_files[".sog"], field, value))
    if problem is None:  # Alpha is 255 there, as for the last component.
        assert len(read_splat(path)) == 20
    else:
        rejected(path, problem)


def test_sog_parts(tmp_path, whole_files):
    path = tmp_path / "s.sog"
    huge = io.BytesIO()
    Image.new("RGBA", (4000, 4000)).save(huge, "WEBP", lossless=True)
    for name, content, problem in [
        ("meta.json", "[1]", "expected a JSON object"),
        ("meta.json", "{", "not JSON"),
        ("meta.json", "[" * 10**6, "not JSON"),
        ("meta.json", " " * 2**25, "has 33554432 bytes"),
        ("quats.webp", bytes(2**27), "would unpack to 134217728 bytes"),
        ("quats.webp", PNG, "quats.webp is not a WebP picture"),
        ("quats.webp", huge.getvalue(), "4000 x 4000 pixels, but 20"),
    ]:
        path.write_bytes(
            resaved(
                whole_files[".sog"],
                lambda part, old, n=name, c=content: c if part == n else old,
            )
        )
        rejected(path, problem)
